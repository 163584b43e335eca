//! A body in two shapes.

use super::triangle::{at, closest_weights};
use crate::contact::{Aabb, NearestSearch};
use crate::error::{Error, ErrorCode, ErrorKind};
use crate::garment::{Meaning, Mesh, Primvar, PrimvarRole, Values};
use crate::mesh::VertexId;
use glam::DVec3;
use rayon::prelude::*;

/// How far outside of all faces a UV may be. \[UV units\]
const UV_TOLERANCE: f64 = 0.01;
/// Share of the vertices that may be that far outside.
const MOST_WITHOUT_UV: f64 = 0.01;

/// A body before and after, with the same triangles.
#[derive(Clone, Debug, Default)]
pub struct Bodies {
    /// The vertices of each triangle.
    pub(super) triangles: Vec<[usize; 3]>,
    /// The ends of each edge.
    pub(super) edges: Vec<[usize; 2]>,
    /// Points of the body that the garment was made for. \[mesh units\]
    pub(super) from: Vec<DVec3>,
    /// Points of the body that it is to fit. \[mesh units\]
    pub(super) to: Vec<DVec3>,
}

impl Bodies {
    /// Two bodies with the same faces, or with UVs in which they correspond.
    ///
    /// # Errors
    /// Bodies that have neither.
    pub fn new(from: &Mesh, to: &Mesh) -> Result<Self, Error> {
        let points = |mesh: &Mesh| mesh.points.iter().map(|p| p.as_dvec3()).collect::<Vec<_>>();
        let to_points =
            if from.points.len() == to.points.len() && from.faces == to.faces { points(to) } else { by_uvs(from, to)? };
        let triangles = fans(from);
        let sides = triangles.iter().flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
        let mut edges: Vec<[usize; 2]> = sides.map(|[a, b]| [a.min(b), a.max(b)]).collect();
        edges.sort_unstable();
        edges.dedup();
        Ok(Self { triangles, edges, from: points(from), to: to_points })
    }

    /// The points at a share of the way.
    pub(super) fn shape(&self, share: f64) -> Vec<DVec3> {
        self.from.iter().zip(&self.to).map(|(a, b)| a.lerp(*b, share)).collect()
    }

    /// The diagonal of the box of the first shape.
    pub(super) fn size(&self) -> f64 {
        let low = self.from.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = self.from.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        low.distance(high)
    }
}

/// The faces of a mesh as fans of triangles.
pub(super) fn fans(mesh: &Mesh) -> Vec<[usize; 3]> {
    let of_face = |face| {
        let vertices = mesh.faces.vertices_of(face);
        vertices[1..].windows(2).map(move |pair| [vertices[0], pair[0], pair[1]].map(|v| v.index()))
    };
    mesh.faces.ids().flat_map(of_face).collect()
}

/// The points of `to` at the UVs of the vertices of `from`.
fn by_uvs(from: &Mesh, to: &Mesh) -> Result<Vec<DVec3>, Error> {
    let fault = |text: String| {
        let remedy = "name bodies of the same faces, or with a common UV set";
        Error::new(ErrorKind::Mesh, &to.prim, text).code(ErrorCode::BodiesDiffer).remedy(remedy)
    };
    let (a, b) = (from.points.len(), to.points.len());
    let other = format!("it has other faces than {} ({b} points, not {a})", from.prim);
    let Some((name, own)) = uv_sets(from).find(|(name, _)| uv_sets(to).any(|(other, _)| other == *name)) else {
        return Err(fault(format!("{other}, and no UV set in common")));
    };
    let of_to = uv_sets(to).find(|(other, _)| *other == name).map(|(_, uvs)| uvs).unwrap_or_default();
    let mut uv_of = vec![None; a];
    from.faces.corners().enumerated().for_each(|(corner, v)| {
        uv_of[v.index()].get_or_insert(own[corner.index()]);
    });
    let (triangles, uvs) = (fans(to), uv_fans(to, &of_to));
    let boxes: Vec<Aabb> = uvs.iter().map(|t| super::triangle::aabb(t)).collect();
    let search = NearestSearch::new(&boxes);
    let found: Vec<Option<(DVec3, f64)>> = uv_of
        .par_iter()
        .map(|uv| {
            let uv: DVec3 = (*uv)?;
            let distance = |t: usize, p: DVec3| at(uvs[t], closest_weights(uvs[t], p)).distance_squared(p);
            let t = search.nearest(uv.as_vec3(), distance)?;
            let weights = closest_weights(uvs[t], uv);
            let place = at(triangles[t].map(|v| to.points[VertexId::new(v)].as_dvec3()), weights);
            Some((place, at(uvs[t], weights).distance(uv)))
        })
        .collect();
    let missing = found.iter().flatten().filter(|(_, distance)| *distance > UV_TOLERANCE).count();
    if missing as f64 > MOST_WITHOUT_UV * a as f64 {
        return Err(fault(format!("{other}, and {missing} of its places in the UV set \"{name}\" are on no face")));
    }
    // Points without a face do not matter.
    Ok(found.iter().zip(from.points.iter()).map(|(found, p)| found.map_or(p.as_dvec3(), |(place, _)| place)).collect())
}

/// The UV sets of a mesh: their names, and the UV of each corner.
fn uv_sets(mesh: &Mesh) -> impl Iterator<Item = (&str, Vec<DVec3>)> {
    let is_uvs = |p: &&Primvar| p.role == PrimvarRole::Primvar && p.meaning == Meaning::TextureCoordinate;
    mesh.primvars.iter().filter(is_uvs).filter_map(|primvar| {
        let Values::F32(values) = &primvar.values else { return None };
        let uv = |row: usize| DVec3::new(f64::from(values[2 * row]), f64::from(values[2 * row + 1]), 0.0);
        Some((
            primvar.name.as_str(),
            primvar.corner_rows(&mesh.faces, mesh.points.len()).iter().map(|&row| uv(row as usize)).collect(),
        ))
    })
}

/// The UVs of the corners of each triangle.
fn uv_fans(mesh: &Mesh, uvs: &[DVec3]) -> Vec<[DVec3; 3]> {
    let of_face = |face| {
        let corners = mesh.faces.range(face);
        (corners.start + 1..corners.end - 1).map(move |c| [corners.start, c, c + 1].map(|c| uvs[c]))
    };
    mesh.faces.ids().flat_map(of_face).collect()
}
