//! Values of the corners, points and faces of a mesh as the page draws them.

use crate::messages::ValuesOf;
use tailor::report::TriangleQuality;
use tailor_mesh::connectivity::{CornerId, IdVec, VertexId};
use tailor_mesh::garment::{Interpolation, Mesh, Primvar, Values};

/// Names of the quality figures that are drawn as values.
pub const ANGLE: &str = "quality:angle";
/// As [`ANGLE`], for lengths.
pub const LENGTH: &str = "quality:length";

/// Name of the set of edges where a UV set is cut.
pub const UV_SEAMS: &str = "UV seams";

/// Values with their elements.
pub struct Channel {
    /// The elements.
    pub of: ValuesOf,
    pub values: Vec<f32>,
}

/// The UV set that is drawn: the one called `name`, or else the first.
pub fn uv_set<'a>(mesh: &'a Mesh, name: &str) -> Option<&'a Primvar> {
    let is_uv = |p: &&Primvar| {
        p.interpolation == Interpolation::FaceVarying && p.width() == 2 && matches!(p.values, Values::F32(_))
    };
    let all = || mesh.primvars.iter().filter(is_uv);
    all().find(|p| p.name == name).or_else(|| all().next())
}

/// u and v of each corner.
pub fn uvs(primvar: &Primvar, corners: usize) -> Vec<f32> {
    let Values::F32(values) = &primvar.values else { return Vec::new() };
    (0..corners).flat_map(|corner| row(primvar, values, corner, 2).iter().copied()).collect()
}

fn row<'a>(primvar: &Primvar, values: &'a [f32], element: usize, width: usize) -> &'a [f32] {
    let at = primvar.indices.as_ref().map_or(element, |indices| indices[element] as usize);
    values.get(at * width..(at + 1) * width).unwrap_or(&[])
}

/// The values called `name`, if the mesh has them and they are single numbers.
pub fn channel(mesh: &Mesh, quality: Option<&TriangleQuality>, name: &str) -> Option<Channel> {
    match (name, quality) {
        (ANGLE, Some(quality)) => Some(Channel { of: ValuesOf::Face, values: quality.angles.clone() }),
        (LENGTH, Some(quality)) => Some(Channel { of: ValuesOf::Face, values: quality.lengths.clone() }),
        _ => painted(mesh, mesh.primvar(name)?),
    }
}

fn painted(mesh: &Mesh, primvar: &Primvar) -> Option<Channel> {
    let Values::F32(values) = &primvar.values else { return None };
    if primvar.width() != 1 {
        return None;
    }
    let (of, count) = match primvar.interpolation {
        Interpolation::Constant => return None,
        Interpolation::Uniform => (ValuesOf::Face, mesh.faces.len()),
        Interpolation::Varying | Interpolation::Vertex => (ValuesOf::Point, mesh.points.len()),
        Interpolation::FaceVarying => (ValuesOf::Corner, mesh.faces.corners().len()),
    };
    let value = |element| row(primvar, values, element, 1).first().copied().unwrap_or(0.0);
    Some(Channel { of, values: (0..count).map(value).collect() })
}

/// Inner edges at which the corners of the two faces have other values of a UV set.
pub fn uv_seams(mesh: &Mesh, primvar: &Primvar) -> Vec<[VertexId; 2]> {
    let Values::F32(values) = &primvar.values else { return Vec::new() };
    let uv = |corner: CornerId| row(primvar, values, corner.index(), 2);
    let faces = &mesh.faces;
    // Only a few vertices have several values; edges between the others need no look.
    let mut first: IdVec<VertexId, Option<CornerId>> = IdVec::filled(None, mesh.points.len());
    let mut is_cut: IdVec<VertexId, bool> = IdVec::filled(false, mesh.points.len());
    for (corner, &vertex) in faces.corners().enumerated() {
        match first[vertex] {
            None => first[vertex] = Some(corner),
            Some(known) => is_cut[vertex] |= uv(known) != uv(corner),
        }
    }
    let halves = faces.ids().flat_map(|face| faces.corners_of(face));
    let near = halves.filter(|&half| faces.half_edge(half).iter().any(|&end| is_cut[end]));
    let mut near: Vec<([VertexId; 2], CornerId)> = near.map(|half| (undirected(faces.half_edge(half)), half)).collect();
    near.sort_unstable();
    let at = |half: CornerId, vertex: VertexId| if faces.vertex(half) == vertex { half } else { faces.next(half) };
    let differ = |pair: &&[([VertexId; 2], CornerId)]| matches!(pair, [(ends, a), (_, b)] if ends.iter().any(|&end| uv(at(*a, end)) != uv(at(*b, end))));
    near.chunk_by(|a, b| a.0 == b.0).filter(differ).map(|pair| pair[0].0).collect()
}

fn undirected([a, b]: [VertexId; 2]) -> [VertexId; 2] {
    [a.min(b), a.max(b)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use tailor_mesh::garment::{Garment, PrimvarInput, check_garment};

    #[test]
    fn edges_between_two_shells_are_seams_and_borders_are_not() {
        let corners = vec![0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6];
        let uv = |(i, point): (usize, &i32)| [(point % 4) as f32 + if i < 4 { 9.0 } else { 0.0 }, (point / 4) as f32];
        let uvs: Vec<[f32; 2]> = corners.iter().enumerate().map(uv).collect();
        let mesh = Garment {
            points: (0..8).map(|i| glam::Vec3::new((i % 4) as f32, (i / 4) as f32, 0.0)).collect(),
            face_vertex_counts: vec![4; 3],
            face_vertex_indices: corners,
            primvars: vec![PrimvarInput::uvs("st", &uvs, (0..12).collect())],
            ..Garment::default()
        };
        let (garment, _) = check_garment(mesh).expect("a good mesh");
        let seams = uv_seams(&garment, uv_set(&garment, "st").expect("a UV set"));
        assert_eq!(seams, [[VertexId::new(1), VertexId::new(5)]]);
    }
}
