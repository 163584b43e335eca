//! Cloth that lies nearer to other cloth than its thickness at rest, which a solver would push apart.

use super::surface::Surface;
use rayon::prelude::*;
use tailor_mesh::connectivity::{FaceId, VertexId};
use tailor_mesh::meter;

/// Triangles near one vertex that are paired with its own. More are a crowd in one place, whose pairs no memory holds.
const MOST_NEAR: usize = 256;

/// Pairs of triangles that share no vertex, of which one has a vertex nearer to the other than the thickness, sorted.
pub fn doubled(surface: &Surface<'_>, thickness: impl Fn(FaceId) -> f32 + Sync) -> Vec<[FaceId; 2]> {
    let faces = &surface.mesh.faces;
    let of_vertex = |vertex: usize| {
        meter::check();
        let vertex = VertexId::new(vertex);
        let around: Vec<FaceId> = surface.topology.faces_at(vertex).collect();
        let reach = around.iter().map(|&face| thickness(face)).fold(0.0, f32::max);
        let ring = || around.iter().flat_map(|&face| faces.vertices_of(face));
        let touches = |face: FaceId| faces.vertices_of(face).iter().any(|v| ring().any(|of| of == v));
        let is_apart = |face| !around.contains(&face) && !touches(face);
        let near = surface.near(surface.mesh.points[vertex], reach, MOST_NEAR, is_apart);
        let pairs = near.into_iter().flat_map(|near| around.iter().map(move |&face| [face, near]));
        pairs.map(|[a, b]| [a.min(b), a.max(b)]).collect::<Vec<_>>()
    };
    let mut pairs: Vec<[FaceId; 2]> = (0..surface.mesh.points.len()).into_par_iter().flat_map_iter(of_vertex).collect();
    pairs.par_sort_unstable();
    pairs.dedup();
    pairs
}
