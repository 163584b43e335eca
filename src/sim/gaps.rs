//! How well the edges of chains follow their curves.

use crate::mesh::{IdVec, VertexId};
use crate::sim::constraints::chain::Chain;
use crate::sim::{Baseline, OnChain};
use glam::Vec3;

/// Where a chain's curve lies farthest from the edges that follow it.
#[derive(Clone, Copy, Debug)]
pub struct CurveGap {
    /// The distance, as a share of the target length there.
    pub distance: f32,
    /// The garment's vertex on the chain nearest to that place, by the steps of the curve.
    pub near: VertexId,
}

/// The largest gap of a chain; `edges` are all of its edges, and `points` the positions of the mesh.
pub(crate) fn gap(baseline: &Baseline, chain: &Chain, edges: &[OnChain], points: &IdVec<VertexId, Vec3>) -> CurveGap {
    let (last, step) = (chain.vertices.len() - 1, chain.step().max(1));
    let mut largest = CurveGap { distance: 0.0, near: chain.cage[0] };
    for &(start, length, [a, b]) in edges {
        let first = chain.along.partition_point(|&s| s <= start);
        // A loop's edge may run over the place where its curve begins.
        let rest = start + length - chain.length();
        let ahead = (first..=last).take_while(|&i| chain.along[i] < start + length);
        let around = (1..last).take_while(|&i| chain.is_loop && chain.along[i] < rest);
        for i in ahead.chain(around) {
            let vertex = chain.vertices[i];
            let off = distance_to_segment(baseline.points[vertex], points[a], points[b]);
            let distance = off / baseline.target[vertex];
            if distance > largest.distance {
                largest = CurveGap { distance, near: chain.cage[(i + step / 2) / step] };
            }
        }
    }
    largest
}

pub(crate) fn distance_to_segment(p: Vec3, a: Vec3, b: Vec3) -> f32 {
    let along = b - a;
    let t = (p - a).dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
    p.distance(a + along * t.clamp(0.0, 1.0))
}
