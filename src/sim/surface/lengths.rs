//! The lengths that remeshing works with: the targets, shorter near chains that bend, changing gradually from there.

use crate::mesh::{IdVec, Topology, VertexId};
use crate::sim::baseline::Baseline;
use glam::Vec3;
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// Lengths grow at most by this much per length away from a shorter one. Larger values spend fewer triangles near bends,
/// smaller ones make them more even.
const GROWTH: f32 = 0.3;

/// A vertex with the length that it would get; the shortest is settled first.
#[derive(PartialEq)]
struct Entry(f32, VertexId);

impl Eq for Entry {}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0).then(self.1.cmp(&other.1))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Shortens the lengths of vertices until none grows by more than `growth` per length away from another. Returns the
/// number of those that changed.
pub(crate) fn grade(
    lengths: &mut IdVec<VertexId, f32>,
    shorter: impl Iterator<Item = (VertexId, f32)>,
    growth: f32,
    t: &Topology,
    points: &IdVec<VertexId, Vec3>,
) -> usize {
    let before = lengths.clone();
    let mut queue = BinaryHeap::new();
    for (v, length) in shorter {
        lengths[v] = lengths[v].min(length);
        queue.push(Reverse(Entry(lengths[v], v)));
    }
    while let Some(Reverse(Entry(length, v))) = queue.pop() {
        if length > lengths[v] {
            continue;
        }
        for &corner in t.vertex_corners.row(v) {
            for w in [t.faces.vertex(t.faces.next(corner)), t.faces.vertex(t.faces.prev(corner))] {
                let grown = length + growth * points[v].distance(points[w]);
                if grown < lengths[w] {
                    lengths[w] = grown;
                    queue.push(Reverse(Entry(grown, w)));
                }
            }
        }
    }
    lengths.iter().zip(before.iter()).filter(|(after, before)| after < before).count()
}

impl Baseline {
    /// Spreads the lengths of the chains over the vertices around them.
    pub(crate) fn spread_lengths(&mut self) {
        self.sizing = self.target.clone();
        let on_chains = self.chains.iter().flat_map(|c| c.vertices.iter().copied().zip(c.lengths.iter().copied()));
        let shorter: Vec<(VertexId, f32)> = on_chains.filter(|&(v, length)| length < self.target[v]).collect();
        grade(&mut self.sizing, shorter.into_iter(), GROWTH, &self.topology, &self.points);
    }
}
