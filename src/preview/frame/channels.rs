//! Values of the corners, points and faces of a mesh as the page draws them.

use crate::garment::{Garment, Interpolation, Primvar, Values};
use crate::mesh::{CornerId, Topology, VertexId};
use crate::report::TriangleQuality;

/// Names of the quality figures that are drawn as values.
pub const ANGLE: &str = "quality:angle";
/// As [`ANGLE`], for lengths.
pub const LENGTH: &str = "quality:length";

/// Name of the set of edges where a UV set is cut.
pub const UV_SEAMS: &str = "UV seams";

/// Values with their elements.
pub struct Channel {
    /// `point`, `corner` or `face`.
    pub of: &'static str,
    pub values: Vec<f32>,
}

/// The UV set that is drawn: the one called `name`, or else the first.
pub fn uv_set<'a>(mesh: &'a Garment, name: &str) -> Option<&'a Primvar> {
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
pub fn channel(mesh: &Garment, quality: Option<&TriangleQuality>, name: &str) -> Option<Channel> {
    match (name, quality) {
        (ANGLE, Some(quality)) => Some(Channel { of: "face", values: quality.angles.clone() }),
        (LENGTH, Some(quality)) => Some(Channel { of: "face", values: quality.lengths.clone() }),
        _ => painted(mesh, mesh.primvar(name)?),
    }
}

fn painted(mesh: &Garment, primvar: &Primvar) -> Option<Channel> {
    let Values::F32(values) = &primvar.values else { return None };
    if primvar.width() != 1 {
        return None;
    }
    let (of, count) = match primvar.interpolation {
        Interpolation::Constant => return None,
        Interpolation::Uniform => ("face", mesh.faces.len()),
        Interpolation::Varying | Interpolation::Vertex => ("point", mesh.points.len()),
        Interpolation::FaceVarying => ("corner", mesh.faces.corners().len()),
    };
    let value = |element| row(primvar, values, element, 1).first().copied().unwrap_or(0.0);
    Some(Channel { of, values: (0..count).map(value).collect() })
}

/// Inner edges at which the corners of the two faces have other values of a UV set.
pub fn uv_seams(mesh: &Garment, primvar: &Primvar) -> Vec<[VertexId; 2]> {
    let topology = Topology::new(mesh.faces.clone(), mesh.points.len());
    let Values::F32(values) = &primvar.values else { return Vec::new() };
    let uv = |corner: CornerId| row(primvar, values, corner.index(), 2);
    let faces = &topology.faces;
    // The corners of a half-edge at its two ends, by vertex.
    let at = |half: CornerId, vertex: VertexId| if faces.vertex(half) == vertex { half } else { faces.next(half) };
    let is_cut = |&[first, second]: &[CornerId; 2], ends: [VertexId; 2]| {
        ends.iter().any(|&end| uv(at(first, end)) != uv(at(second, end)))
    };
    let edges = topology.edges.enumerated().filter(|&(edge, &ends)| {
        <&[CornerId; 2]>::try_from(topology.edge_corners.row(edge)).is_ok_and(|pair| is_cut(pair, ends))
    });
    edges.map(|(_, &ends)| ends).collect()
}
