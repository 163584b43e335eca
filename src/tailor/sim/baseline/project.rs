//! Closest points on the baseline by walking from a known triangle.
//!
//! Walks stop at chains and borders, so a vertex stays on its own panel however near another layer lies.

use super::{Baseline, BaselinePoint};
use crate::sim::geometry::closest_weights;
use glam::{Vec2, Vec3};
use tailor_mesh::connectivity::edit;
use tailor_mesh::connectivity::{CornerId, FaceId, IdVec, VertexId};

/// Most triangles of a walk. Every step gets nearer, so only walks from very far away need this many.
const MAX_STEPS: usize = 4096;
/// A step must bring the squared distance below this share of the last, so that rounding cannot make walks cycle.
const PROGRESS: f32 = 1.0 - 1e-6;

/// A point of the baseline with its position.
#[derive(Clone, Copy, Debug)]
pub struct Projection {
    /// Triangle and weights.
    pub location: BaselinePoint,
    /// Position.
    pub position: Vec3,
    /// Squared distance from the point that was projected.
    pub distance_squared: f32,
}

impl Baseline {
    /// Vertices of a triangle.
    #[inline]
    fn vertices(&self, face: FaceId) -> [VertexId; 3] {
        let first = 3 * face.index();
        let corners = &self.topology.faces.corners().as_slice()[first..first + 3];
        [corners[0], corners[1], corners[2]]
    }

    /// Barycentric interpolation of values at a triangle's corners.
    #[inline]
    fn mix<T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>>(weights: Vec3, [a, b, c]: [T; 3]) -> T {
        a * weights.x + b * weights.y + c * weights.z
    }

    /// Positions of a triangle's corners.
    #[inline]
    pub fn triangle(&self, face: FaceId) -> [Vec3; 3] {
        self.facets[face].points
    }

    /// Normal of a triangle, not scaled to unit length.
    pub fn normal(&self, face: FaceId) -> Vec3 {
        let [a, b, c] = self.triangle(face);
        (b - a).cross(c - a)
    }

    /// Position of a location.
    pub fn position(&self, at: BaselinePoint) -> Vec3 {
        Self::mix(at.weights, self.triangle(at.face))
    }

    /// Constraint UVs of a triangle's corners.
    #[inline]
    fn triangle_uvs(&self, face: FaceId) -> [Vec2; 3] {
        let first = 3 * face.index();
        let uvs = &self.uvs.as_slice()[first..first + 3];
        [uvs[0], uvs[1], uvs[2]]
    }

    /// Constraint UVs of a location.
    #[inline]
    pub fn uv(&self, at: BaselinePoint) -> Vec2 {
        Self::mix(at.weights, self.triangle_uvs(at.face))
    }

    /// Target edge length at a location. \[mesh units\]
    pub fn target_at(&self, at: BaselinePoint) -> f32 {
        let [a, b, c] = self.vertices(at.face);
        Self::mix(at.weights, [self.target[a], self.target[b], self.target[c]])
    }

    /// Target length at a location, shortened near chains that bend. \[mesh units\]
    #[inline]
    pub fn sizing_at(&self, at: BaselinePoint) -> f32 {
        let [a, b, c] = self.vertices(at.face);
        Self::mix(at.weights, [self.sizing[a], self.sizing[b], self.sizing[c]])
    }

    /// The location of a corner of a triangle.
    pub fn corner_location(&self, corner: CornerId) -> BaselinePoint {
        BaselinePoint { face: edit::face(corner), weights: Vec3::AXES[corner.index() % 3] }
    }

    /// The closest point of one triangle.
    #[inline]
    pub fn on_triangle(&self, face: FaceId, point: Vec3) -> Projection {
        let [a, b, c] = self.triangle(face);
        let weights = closest_weights(a, b, c, point);
        let position = Self::mix(weights, [a, b, c]);
        let distance_squared = position.distance_squared(point);
        Projection { location: BaselinePoint { face, weights }, position, distance_squared }
    }

    /// The closest point that a walk from triangle `start` reaches.
    pub fn closest(&self, start: FaceId, point: Vec3) -> Projection {
        self.walk(start, point, |half| self.open_twin(half))
    }

    /// The closest of the points that walks from the triangles of three corners reach.
    pub fn closest_from(&self, starts: [FaceId; 3], point: Vec3) -> Projection {
        let [near, others @ ..] = starts.map(|face| self.closest(face, point));
        let nearer = |a: Projection, b: Projection| if b.distance_squared < a.distance_squared { b } else { a };
        others.into_iter().fold(near, nearer)
    }

    /// The closest point that a walk reaches without crossing the half-edges of `barrier`.
    pub fn closest_within(&self, start: FaceId, point: Vec3, barrier: &IdVec<CornerId, bool>) -> Projection {
        self.walk(start, point, |half| self.topology.twin(half).filter(|_| !barrier[half]))
    }

    /// The closest point that a walk reaches over triangles that `is_wanted` admits.
    pub fn closest_among(&self, start: FaceId, point: Vec3, is_wanted: impl Fn(FaceId) -> bool + Copy) -> Projection {
        self.walk(start, point, |half| self.open_twin(half).filter(|&twin| is_wanted(edit::face(twin))))
    }

    /// Steps to the nearest of the adjacent triangles while that is nearer; `cross` leads over a half-edge.
    #[inline]
    fn walk(&self, start: FaceId, point: Vec3, cross: impl Fn(CornerId) -> Option<CornerId> + Copy) -> Projection {
        let mut best = self.on_triangle(start, point);
        for _ in 0..MAX_STEPS {
            let here = best.location;
            let mut next = best;
            for_each_neighbour(here, cross, |face| {
                let there = self.on_triangle(face, point);
                if there.distance_squared < next.distance_squared * PROGRESS {
                    next = there;
                }
            });
            if next.location.face == here.face {
                break;
            }
            best = next;
        }
        best
    }

    /// The location of a UV point in the shell of triangle `start`, by a straight walk; none where a barrier, a flipped part of the
    /// UV layout or a small shell blocks it.
    pub fn locate_uv(&self, start: FaceId, uv: Vec2) -> Option<BaselinePoint> {
        let mut face = start;
        for _ in 0..MAX_STEPS {
            if self.facets[face].sense == 0.0 {
                return None;
            }
            let [a, b, c] = self.triangle_uvs(face);
            let area = (b - a).perp_dot(c - a);
            let weights =
                Vec3::new((b - uv).perp_dot(c - uv), (c - uv).perp_dot(a - uv), (a - uv).perp_dot(b - uv)) / area;
            if !weights.is_finite() {
                return None;
            }
            let outward = weights.min_position();
            if weights[outward] >= 0.0 {
                return Some(BaselinePoint { face, weights });
            }
            let half = CornerId::new(3 * face.index() + (outward + 1) % 3);
            face = edit::face(self.open_twin(half)?);
        }
        None
    }
}

/// Visits the triangles that share the edge or vertex on which a location lies, where `cross` leads to them.
#[inline]
fn for_each_neighbour(
    at: BaselinePoint,
    cross: impl Fn(CornerId) -> Option<CornerId> + Copy,
    mut visit: impl FnMut(FaceId),
) {
    let corner = |k: usize| CornerId::new(at.face.index() * 3 + k);
    let zero = at.weights.to_array().map(|w| w <= 0.0);
    match zero {
        [false, false, false] => {}
        // On the edge opposite the corner of zero weight.
        [true, false, false] => cross(corner(1)).into_iter().for_each(|t| visit(edit::face(t))),
        [false, true, false] => cross(corner(2)).into_iter().for_each(|t| visit(edit::face(t))),
        [false, false, true] => cross(corner(0)).into_iter().for_each(|t| visit(edit::face(t))),
        [_, true, true] => around(corner(0), cross, visit),
        [true, _, true] => around(corner(1), cross, visit),
        [true, true, _] => around(corner(2), cross, visit),
    }
}

/// Visits the triangles around the vertex of a corner, in both directions as far as `cross` leads.
fn around(corner: CornerId, cross: impl Fn(CornerId) -> Option<CornerId>, mut visit: impl FnMut(FaceId)) {
    let mut at = corner;
    while let Some(twin) = cross(edit::prev(at)) {
        at = twin;
        if at == corner {
            return;
        }
        visit(edit::face(at));
    }
    at = corner;
    while let Some(twin) = cross(at) {
        at = edit::next(twin);
        visit(edit::face(at));
    }
}
