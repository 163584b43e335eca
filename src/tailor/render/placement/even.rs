//! Even normals of a second layer: means over its own thickness, so that what is finer goes along with the layer.
//!
//! The offset of a surface crosses itself where a radius is below the height. Normals that turn by an angle within one
//! height, in place of at once, turn less than the layer is long there.

use crate::render::operator::Control;
use glam::Vec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use tailor_mesh::connectivity::{IdVec, Topology, VertexId};

/// Most controls that a mean is of.
const MOST: usize = 128;

/// A second layer without heights.
pub struct EvenNormals<'a> {
    /// Position and normal of each control.
    pub targets: &'a [(Vec3, Vec3)],
    /// Edges between copies, as indices of their controls.
    pub edges: &'a [[usize; 2]],
    /// The controls.
    pub controls: &'a [Control],
    /// The cage.
    pub topology: &'a Topology,
    /// The points of the cage.
    pub points: &'a IdVec<VertexId, Vec3>,
}

impl EvenNormals<'_> {
    /// The targets with means of normals, weighted by area and less with distance, up to the height of each control.
    pub fn over(&self, heights: &[f32]) -> Vec<(Vec3, Vec3)> {
        let mut beside: FxHashMap<usize, Vec<usize>> = FxHashMap::default();
        for &[a, b] in self.edges {
            beside.entry(a).or_default().push(b);
            beside.entry(b).or_default().push(a);
        }
        let of = |i: usize| {
            let (point, own) = self.targets[i];
            let is_alone = !beside.contains_key(&i) || own == Vec3::ZERO || heights[i] == 0.0;
            let mean = if is_alone { Vec3::ZERO } else { self.mean(i, heights[i].abs(), &beside) };
            (point, if mean.dot(own) > 0.0 { mean.normalize() } else { own })
        };
        (0..self.targets.len()).into_par_iter().map(of).collect()
    }

    /// Twice the area of the corners at a control.
    fn area(&self, control: usize) -> f32 {
        let (faces, at) = (&self.topology.faces, self.controls[control].vertex);
        let to = |vertex: VertexId| self.points[vertex] - self.points[at];
        let corners = self.topology.vertex_corners.row(at).iter();
        let corner = |&c| to(faces.vertex(faces.next(c))).cross(to(faces.vertex(faces.prev(c)))).length();
        corners.map(corner).sum()
    }

    fn mean(&self, start: usize, reach: f32, beside: &FxHashMap<usize, Vec<usize>>) -> Vec3 {
        let mut known = FxHashMap::from_iter([(start, 0.0_f32)]);
        // Distances are not negative, so that their bits are in their order.
        let mut queue = BinaryHeap::from([Reverse((0_u32, start))]);
        let mut mean = Vec3::ZERO;
        let mut left = MOST;
        while let Some(Reverse((bits, here))) = queue.pop().filter(|_| left > 0) {
            let distance = f32::from_bits(bits);
            if distance > known[&here] {
                continue;
            }
            left -= 1;
            mean += (1.0 - distance / reach) * self.area(here) * self.targets[here].1;
            for &next in &beside[&here] {
                let there = distance + self.targets[here].0.distance(self.targets[next].0);
                let best = known.entry(next).or_insert(f32::INFINITY);
                if there < reach && there < *best {
                    *best = there;
                    queue.push(Reverse((there.to_bits(), next)));
                }
            }
        }
        mean
    }
}
