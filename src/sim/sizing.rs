//! The lengths that remeshing works with: the targets, shorter near chains that bend, changing gradually from there.

use super::baseline::Baseline;
use crate::mesh::VertexId;
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

impl Baseline {
    /// Spreads the lengths of the chains over the vertices around them.
    pub(super) fn spread_lengths(&mut self) {
        self.sizing = self.target.clone();
        let mut queue = BinaryHeap::new();
        let shorten = |sizing: &mut f32, v: VertexId, length: f32, queue: &mut BinaryHeap<_>| {
            if length < *sizing {
                *sizing = length;
                queue.push(Reverse(Entry(length, v)));
            }
        };
        for chain in self.chains.iter() {
            for (&v, &length) in chain.vertices.iter().zip(&chain.lengths) {
                shorten(&mut self.sizing[v], v, length, &mut queue);
            }
        }
        let t = &self.topology;
        while let Some(Reverse(Entry(length, v))) = queue.pop() {
            if length > self.sizing[v] {
                continue;
            }
            for &corner in t.vertex_corners.row(v) {
                for w in [t.faces.vertex(t.faces.next(corner)), t.faces.vertex(t.faces.prev(corner))] {
                    let grown = length + GROWTH * self.points[v].distance(self.points[w]);
                    shorten(&mut self.sizing[w], w, grown, &mut queue);
                }
            }
        }
    }
}
