//! Target edge lengths on the surface, and how fast they may change.

use super::manifold::Manifold;
use glam::Vec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use tailor_mesh::connectivity::{IdVec, Topology, VertexId};
use tailor_mesh::garment::{Primvar, Values};
use tailor_mesh::subdivide::Level;

/// An edge longer than this times its target is split. Smaller values make more, shorter edges. Botsch and Kobbelt 2004,
/// section 4, use 4/3, from which halves are nearer to the target than the whole. 5/4 makes better triangles: on the
/// garments it raises the 5th percentile of the smallest angle by 0.7 degrees, with 1 % more triangles.
pub const SPLIT_RATIO: f32 = 1.25;

/// Target edge lengths over the garment.
#[derive(Clone, Copy, Debug)]
pub struct Lengths<'a> {
    /// Where the density is 1. \[mesh units\]
    pub min: f32,
    /// Where the density is 0. \[mesh units\]
    pub max: f32,
    /// The density, on the garment's vertices.
    pub density: Option<&'a Primvar>,
}

impl Lengths<'_> {
    /// The target length for a density.
    fn of(&self, density: f32) -> f32 {
        self.max + (self.min - self.max) * density.clamp(0.0, 1.0)
    }

    /// The target length at a vertex of the garment. \[mesh units\]
    pub fn at(&self, vertex: VertexId) -> f32 {
        match self.density.map(|d| (d, &d.values)) {
            Some((density, Values::F32(values))) => self.of(values[density.row(vertex.index())]),
            _ => self.max,
        }
    }

    /// Target edge length at each of the `vertices` vertices of the finest level. \[mesh units\]
    pub fn refined(&self, manifold: &Manifold, levels: &[Level], vertices: usize) -> IdVec<VertexId, f32> {
        let density = self.density.and_then(|density| painted(manifold, levels, density));
        density.map_or_else(|| IdVec::filled(self.max, vertices), |all| all.iter().map(|&w| self.of(w)).collect())
    }
}

/// A painted weight at each vertex of the finest level.
pub fn painted(manifold: &Manifold, levels: &[Level], primvar: &Primvar) -> Option<IdVec<VertexId, f32>> {
    let Values::F32(values) = &primvar.values else { return None };
    Some(manifold.refine_rows(levels, primvar, values).into_iter().collect())
}

/// Shortens the lengths of vertices until none grows by more than `growth` per length away from another. `shorter` are
/// vertices with a new upper bound. Returns the number of vertices that changed.
pub fn grade(
    lengths: &mut IdVec<VertexId, f32>,
    shorter: impl Iterator<Item = (VertexId, f32)>,
    growth: f32,
    t: &Topology,
    points: &IdVec<VertexId, Vec3>,
) -> usize {
    let before = lengths.clone();
    // Positive floats order like their bits.
    let entry = |length: f32, v: VertexId| Reverse((length.to_bits(), v));
    let mut queue = BinaryHeap::new();
    for (v, length) in shorter {
        lengths[v] = lengths[v].min(length);
        queue.push(entry(lengths[v], v));
    }
    while let Some(Reverse((bits, v))) = queue.pop() {
        let length = f32::from_bits(bits);
        if length > lengths[v] {
            continue;
        }
        for &corner in t.vertex_corners.row(v) {
            for w in [t.faces.next(corner), t.faces.prev(corner)].map(|c| t.faces.vertex(c)) {
                let grown = length + growth * points[v].distance(points[w]);
                if grown < lengths[w] {
                    lengths[w] = grown;
                    queue.push(entry(grown, w));
                }
            }
        }
    }
    lengths.iter().zip(before.iter()).filter(|(after, before)| after < before).count()
}
