//! How a simulation mesh follows the folds of its surface.

use crate::mesh::{CornerId, VertexId};
use crate::sim::{NarrowStrip, SimProduct};
use rayon::prelude::*;
use serde::Serialize;

/// The angle from which a triangle counts as steep. \[degrees\]
pub(super) const STEEP: f32 = 60.0;

/// A fold that is too near to a border, a seam or another fold to have edges of its own.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct NarrowFold {
    /// One of the garment's vertices along it.
    pub vertex: usize,
    /// The number of the garment's edges along it.
    pub edges: usize,
    /// The largest distance to the edges beside it, a bound of how far the surface moves. \[target lengths\]
    pub width: f32,
}

pub(super) fn narrow_folds(product: &SimProduct) -> Vec<NarrowFold> {
    let baseline = &product.baseline;
    let of = |strip: &NarrowStrip| NarrowFold {
        vertex: baseline.manifold.vertex_source[strip.vertex].index(),
        edges: strip.edges,
        width: strip.width,
    };
    baseline.narrow.iter().map(of).collect()
}

/// The angle between each triangle and the surface that it lies on, at the point nearest to its centre. \[degrees\]
pub fn facing(product: &SimProduct) -> Vec<f32> {
    let baseline = &product.baseline;
    let of = |(i, t): (usize, &[VertexId; 3])| {
        let [a, b, c] = t.map(|v| product.points[v]);
        let centre = (a + b + c) / 3.0;
        let faces = [0, 1, 2].map(|k| product.places[CornerId::new(3 * i + k)].location.face);
        let near = faces.map(|face| baseline.closest(face, centre));
        let face =
            near.iter().min_by(|p, q| p.distance_squared.total_cmp(&q.distance_squared)).map(|p| p.location.face);
        let surface = baseline.normal(face.unwrap_or(faces[0])).normalize_or_zero();
        (b - a).cross(c - a).normalize_or_zero().dot(surface).clamp(-1.0, 1.0).acos().to_degrees()
    };
    product.triangles.par_iter().enumerate().map(of).collect()
}
