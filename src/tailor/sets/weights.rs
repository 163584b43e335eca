//! Weights at vertices: painted ones, and those of sets.

use super::functions::painted_weights;
use std::borrow::Cow;
use tailor_mesh::connectivity::VertexId;
use tailor_mesh::garment::{Elements, Interpolation, Mesh, Primvar, Subset};

/// Rings of edges around a set over which its weights fall to 0, so that what follows them has no jump at its border.
const BLEND: usize = 2;

/// The weights of a name: those of a primvar, or else of a set; none without either.
pub fn weights_named<'a>(garment: &'a Mesh, name: &str) -> Option<Cow<'a, Primvar>> {
    let of_set = || garment.subset(name).map(|set| Cow::Owned(weights_of(garment, set)));
    garment.primvar(name).map(Cow::Borrowed).or_else(of_set)
}

/// The weights of a set: those that it is painted with, or else 1 at the points of its elements, and less on each ring around them.
pub fn weights_of(garment: &Mesh, set: &Subset) -> Primvar {
    let painted = painted_weights(&set.name).filter(|weights| weights.len() == garment.points.len());
    let weights = painted.unwrap_or_else(|| blended(garment, set));
    Primvar { name: set.name.clone(), interpolation: Interpolation::Vertex, ..Primvar::of_corners(weights, None) }
}

fn blended(garment: &Mesh, set: &Subset) -> Vec<f32> {
    let faces = &garment.faces;
    let mut weights = vec![0.0; garment.points.len()];
    let mut rim: Vec<VertexId> = match &set.elements {
        Elements::Faces(of) => of.iter().flat_map(|&face| faces.vertices_of(face)).copied().collect(),
        Elements::Edges(edges) => edges.as_flattened().to_vec(),
        Elements::Points(points) => points.clone(),
    };
    for ring in 0..=BLEND {
        let weight = 1.0 - ring as f32 / (BLEND + 1) as f32;
        rim.iter().for_each(|v| weights[v.index()] = weight);
        let is_outer = |[a, b]: &[VertexId; 2]| weights[a.index()] == weight && weights[b.index()] == 0.0;
        let halves = faces.corners().ids().map(|corner| faces.half_edge(corner));
        rim = halves.flat_map(|[a, b]| [[a, b], [b, a]]).filter(is_outer).map(|[_, outer]| outer).collect();
    }
    weights
}
