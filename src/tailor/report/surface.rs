//! How a simulation mesh lies on its surface, and which sharp edges of it have none.

use crate::sim::{BluntRidge as Ridge, NarrowStrip, SimProduct};
use rayon::prelude::*;
use serde::Serialize;
use tailor_mesh::connectivity::{CornerId, VertexId};

/// The angle from which a triangle counts as steep. \[degrees\]
pub(super) const STEEP: f32 = 60.0;

/// Sharp edges that are too near to a border, a seam or other sharp edges to have a feature line of their own.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct NarrowFeature {
    /// One of the garment's vertices along it.
    pub vertex: usize,
    /// The number of the garment's edges along it.
    pub edges: usize,
    /// The largest distance to the edges beside it, a bound of how far the surface moves. \[target lengths\]
    pub width: f32,
}

pub(super) fn narrow_features(product: &SimProduct) -> Vec<NarrowFeature> {
    let baseline = &product.baseline;
    let of = |strip: &NarrowStrip| NarrowFeature {
        vertex: baseline.manifold.vertex_source[strip.vertex].index(),
        edges: strip.edges,
        width: strip.width,
    };
    baseline.narrow.iter().map(of).collect()
}

/// A line of edges that turns by two thirds or more of the angle of a feature line, so that triangles may cut it off.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct BluntRidge {
    /// One of the garment's vertices along it.
    pub vertex: usize,
    /// The number of the garment's edges along it.
    pub edges: usize,
    /// Its length. \[target lengths\]
    pub length: f32,
}

pub(super) fn blunt_ridges(product: &SimProduct) -> Vec<BluntRidge> {
    let baseline = &product.baseline;
    let of = |&Ridge { vertex, edges, length }: &Ridge| BluntRidge {
        vertex: baseline.manifold.vertex_source[vertex].index(),
        edges,
        length,
    };
    baseline.blunt.iter().map(of).collect()
}

/// A triangle against the surface that it lies on.
pub(super) struct OnSurface {
    /// Distances of the centre and of the middles of the edges. \[target lengths\]
    pub distances: [f32; 4],
    /// The angle to the surface at the point nearest to the centre. \[degrees\]
    pub angle: f32,
}

/// Measures each triangle. Each search starts at the baseline faces of the triangle's corners.
pub(super) fn on_surface(product: &SimProduct) -> Vec<OnSurface> {
    let baseline = &product.baseline;
    let of = |(i, t): (usize, &[VertexId; 3])| {
        let [a, b, c] = t.map(|v| product.points[v]);
        let target = t.iter().map(|&v| product.target[v]).sum::<f32>() / 3.0;
        let starts = [0, 1, 2].map(|k| product.places[CornerId::new(3 * i + k)].location.face);
        let middles = [(a + b + c) / 3.0, a.midpoint(b), b.midpoint(c), c.midpoint(a)];
        let near = middles.map(|point| baseline.closest_from(starts, point));
        let surface = baseline.normal(near[0].location.face).normalize_or_zero();
        let cosine = (b - a).cross(c - a).normalize_or_zero().dot(surface);
        OnSurface {
            distances: near.map(|near| near.distance_squared.sqrt() / target),
            angle: cosine.clamp(-1.0, 1.0).acos().to_degrees(),
        }
    };
    product.triangles.par_iter().enumerate().map(of).collect()
}

/// The angle between each triangle and the surface that it lies on, at the point nearest to its centre. \[degrees\]
pub fn facing(product: &SimProduct) -> Vec<f32> {
    on_surface(product).into_iter().map(|triangle| triangle.angle).collect()
}
