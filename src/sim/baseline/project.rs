//! Closest points on the baseline by walking from a known triangle.
//!
//! A walk never crosses a chain or a border, so a vertex stays on its own piece and panel however near another layer
//! lies.

use crate::mesh::edit;
use crate::mesh::{CornerId, FaceId, IdVec, VertexId};
use crate::sim::baseline::{Baseline, Location};
use glam::{Vec2, Vec3};

/// Steps after which a walk stops where it is. A walk gets nearer with every step, so only a start that is very far
/// away comes near this.
const MAX_STEPS: usize = 4096;
/// A step must shorten the squared distance by this share, so that rounding cannot turn it back.
const PROGRESS: f32 = 1.0 - 1e-6;

/// A point of the baseline with its position.
#[derive(Clone, Copy, Debug)]
pub struct Projection {
    /// Where it is on the baseline.
    pub location: Location,
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

    /// A mix of corner or vertex values.
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
    pub fn position(&self, at: Location) -> Vec3 {
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
    pub fn uv(&self, at: Location) -> Vec2 {
        Self::mix(at.weights, self.triangle_uvs(at.face))
    }

    /// Target edge length at a location. \[stage units\]
    pub fn target_at(&self, at: Location) -> f32 {
        let [a, b, c] = self.vertices(at.face);
        Self::mix(at.weights, [self.target[a], self.target[b], self.target[c]])
    }

    /// The length that remeshing works with at a location. \[stage units\]
    #[inline]
    pub fn sizing_at(&self, at: Location) -> f32 {
        let [a, b, c] = self.vertices(at.face);
        Self::mix(at.weights, [self.sizing[a], self.sizing[b], self.sizing[c]])
    }

    /// The location of a corner of a triangle.
    pub fn corner_location(&self, corner: CornerId) -> Location {
        let mut weights = [0.0; 3];
        weights[corner.index() % 3] = 1.0;
        Location { face: FaceId::new(corner.index() / 3), weights: weights.into() }
    }

    /// The closest point of one triangle.
    #[inline]
    fn on_triangle(&self, face: FaceId, point: Vec3) -> Projection {
        let [a, b, c] = self.triangle(face);
        let weights = closest_weights(a, b, c, point);
        let position = a * weights.x + b * weights.y + c * weights.z;
        let distance_squared = position.distance_squared(point);
        Projection { location: Location { face, weights }, position, distance_squared }
    }

    /// The closest point that a walk from triangle `start` reaches.
    pub fn closest(&self, start: FaceId, point: Vec3) -> Projection {
        self.walk(start, point, |half| self.open_twin(half))
    }

    /// The same, with half-edges that it does not cross given by `barrier`.
    pub fn closest_within(&self, start: FaceId, point: Vec3, barrier: &IdVec<CornerId, bool>) -> Projection {
        self.walk(start, point, |half| self.topology.twin(half).filter(|_| !barrier[half]))
    }

    /// Goes on to the nearest of the triangles around as long as that is nearer; `cross` leads over a half-edge.
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

    /// The location of a UV point in the shell of triangle `start`, by a straight walk there; none where a barrier or a
    /// fold of the layout is in the way.
    pub fn locate_uv(&self, start: FaceId, uv: Vec2) -> Option<Location> {
        let mut face = start;
        for _ in 0..MAX_STEPS {
            let [a, b, c] = self.triangle_uvs(face);
            let area = (b - a).perp_dot(c - a);
            let weights =
                Vec3::new((b - uv).perp_dot(c - uv), (c - uv).perp_dot(a - uv), (a - uv).perp_dot(b - uv)) / area;
            if !weights.is_finite() {
                return None;
            }
            let outward = weights.min_position();
            if weights[outward] >= 0.0 {
                return Some(Location { face, weights });
            }
            let half = CornerId::new(3 * face.index() + (outward + 1) % 3);
            face = edit::face(self.open_twin(half)?);
        }
        None
    }
}

/// The triangles that share the edge or vertex on which a location lies, as far as `cross` leads.
#[inline]
fn for_each_neighbour(
    at: Location,
    cross: impl Fn(CornerId) -> Option<CornerId> + Copy,
    mut visit: impl FnMut(FaceId),
) {
    let corner = |k: usize| CornerId::new(at.face.index() * 3 + k);
    let zero = at.weights.to_array().map(|w| w <= 0.0);
    match zero {
        [false, false, false] => {}
        // The edge opposite the corner without weight.
        [true, false, false] => drop(cross(corner(1)).map(|t| visit(edit::face(t)))),
        [false, true, false] => drop(cross(corner(2)).map(|t| visit(edit::face(t)))),
        [false, false, true] => drop(cross(corner(0)).map(|t| visit(edit::face(t)))),
        [_, true, true] => around(corner(0), cross, visit),
        [true, _, true] => around(corner(1), cross, visit),
        [true, true, _] => around(corner(2), cross, visit),
    }
}

/// Turns around the vertex of a corner, both ways as far as `cross` leads.
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

/// Weights of the point of a triangle that is closest to `p` (Ericson, Real-Time Collision Detection, 5.1.5).
#[inline]
pub fn closest_weights(a: Vec3, b: Vec3, c: Vec3, p: Vec3) -> Vec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return Vec3::X;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return Vec3::Y;
    }
    let vc = d1 * d4 - d3 * d2;
    // An edge without length is passed by: the point is closest to one of the others.
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3 {
        let v = d1 / (d1 - d3);
        return Vec3::new(1.0 - v, v, 0.0);
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return Vec3::Z;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6 {
        let w = d2 / (d2 - d6);
        return Vec3::new(1.0 - w, 0.0, w);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return Vec3::new(0.0, 1.0 - w, w);
    }
    let sum = va + vb + vc;
    // A degenerate triangle that reaches here is a point.
    if sum <= 0.0 {
        return Vec3::X;
    }
    let (v, w) = (vb / sum, vc / sum);
    Vec3::new(1.0 - v - w, v, w)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_without_area_have_closest_points() {
        let (a, b) = (Vec3::ZERO, Vec3::new(2.0, 0.0, 0.0));
        for [p, q, r] in [[a, a, b], [a, b, a], [b, a, a], [a, b, b], [a, a, a], [a, b, (a + b) / 2.0]] {
            for point in [Vec3::new(1.0, 1.0, 0.0), Vec3::new(3.0, 0.0, 0.0), Vec3::new(-1.0, 1.0, 1.0), a, b] {
                let weights = closest_weights(p, q, r, point);
                let found = p * weights.x + q * weights.y + r * weights.z;
                let far = if [p, q, r].contains(&b) { point.x.clamp(0.0, 2.0) } else { 0.0 };
                assert!((weights.element_sum() - 1.0).abs() < 1e-6, "{weights} for {point} on {p} {q} {r}");
                assert_eq!(found, Vec3::new(far, 0.0, 0.0), "{weights} for {point} on {p} {q} {r}");
            }
        }
    }
}
