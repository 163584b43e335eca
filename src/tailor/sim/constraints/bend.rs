//! How much the surface bends across an edge, within one target length.

use super::cage_edges::half_edge;
use super::chain::Chain;
use crate::sim::geometry::angle;
use crate::sim::surface::triangulation::RefinedSurface;
use glam::Vec3;
use tailor_mesh::connectivity::edit::{next, prev};
use tailor_mesh::connectivity::{CornerId, VertexId};

/// Most triangles of a walk away from an edge.
const MAX_STEPS: usize = 64;

impl RefinedSurface<'_> {
    /// Finds the normals on both sides of a chain: at the chain itself, but half a target length away from a feature line.
    pub fn set_normals(&self, chain: &mut Chain) {
        let part = if chain.kind.feature { 0.5 } else { 0.0 };
        let reach = |v: VertexId| part * self.target[v];
        let beyond = |half: Option<CornerId>, v| half.map_or(Vec3::ZERO, |h| self.normal_beyond(h, reach(v)));
        let sides = chain.left.iter().zip(&chain.right).zip(&chain.vertices);
        chain.normals = sides.map(|((&left, &right), &v)| [beyond(left, v), beyond(right, v)]).collect();
    }

    /// The angle between the normals half a target length to the left and to the right of an edge. \[radians\]
    pub(super) fn bend(&self, a: VertexId, b: VertexId) -> f32 {
        let half = |a, b| half_edge(self.topology, a, b);
        let (Some(left), Some(right)) = (half(a, b), half(b, a)) else { return 0.0 };
        let reach = 0.25 * (self.target[a] + self.target[b]);
        angle(self.normal_beyond(left, reach), self.normal_beyond(right, reach))
    }

    /// The normal at a distance from the middle of a half-edge, by a straight walk away from it over the surface.
    fn normal_beyond(&self, half: CornerId, reach: f32) -> Vec3 {
        let at = |c: CornerId| self.points[self.topology.faces.vertex(c)];
        let mut from = at(half).midpoint(at(next(half)));
        let mut half = half;
        let mut normal = self.normal(half);
        let mut way = normal.cross(at(next(half)) - at(half)).normalize_or_zero();
        let mut left = reach;
        for _ in 0..MAX_STEPS {
            let Some((side, passed)) = [next(half), prev(half)]
                .into_iter()
                .filter_map(|c| Some((c, crossing(from, way, normal, at(c), at(next(c)))?)))
                .min_by(|a, b| a.1.total_cmp(&b.1))
            else {
                break;
            };
            let twin = self.topology.twin(side);
            let (Some(twin), true) = (twin, passed < left) else { break };
            left -= passed;
            from += way * passed;
            let along = (at(next(side)) - at(side)).normalize_or_zero();
            // Unfolds the direction into the next triangle.
            let (own, across) = (way.dot(along), way.dot(along.cross(normal)));
            normal = self.normal(twin);
            way = along * own + along.cross(normal) * across;
            half = twin;
        }
        normal
    }

    fn normal(&self, half: CornerId) -> Vec3 {
        let [a, b, c] = [half, next(half), prev(half)].map(|c| self.points[self.topology.faces.vertex(c)]);
        (b - a).cross(c - a).normalize_or_zero()
    }
}

/// How far along `way` a line in a triangle's plane leaves it through the side from `a` to `b`, counter-clockwise.
fn crossing(from: Vec3, way: Vec3, normal: Vec3, a: Vec3, b: Vec3) -> Option<f32> {
    let outward = (b - a).cross(normal);
    let speed = way.dot(outward);
    (speed > 0.0).then(|| ((a - from).dot(outward) / speed).max(0.0))
}
