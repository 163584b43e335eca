//! Triangles and edges in double precision.

use glam::DVec3;
use tailor::contact::{Aabb, NearestSearch, TEST, WorkLimit};

/// Share of the size of triangles by which a point may be above a plane that it lies in.
const ROUNDING: f64 = 1e-12;

/// The point of a triangle with these weights of its corners.
pub fn at([a, b, c]: [DVec3; 3], weights: DVec3) -> DVec3 {
    a * weights.x + b * weights.y + c * weights.z
}

/// The weights of a triangle's corners at its point that is nearest to `p`.
pub fn closest_weights(corners: [DVec3; 3], p: DVec3) -> DVec3 {
    let [a, b, c] = corners.map(|corner| (corner - p).as_vec3());
    tailor::sim::closest_weights(a, b, c, glam::Vec3::ZERO).as_dvec3()
}

/// Triangles among which the nearest one is found.
pub struct TriangleSearch {
    corners: Vec<[DVec3; 3]>,
    search: NearestSearch,
}

impl TriangleSearch {
    pub fn new(corners: Vec<[DVec3; 3]>) -> Self {
        let boxes: Vec<Aabb> = corners.iter().map(|triangle| aabb(triangle)).collect();
        Self { corners, search: NearestSearch::new(&boxes) }
    }

    /// The triangle nearest to a point, the weights of its corners there, and that place; none without triangles.
    pub fn nearest(&self, point: DVec3) -> Option<(usize, DVec3, DVec3)> {
        let distance = |triangle, p: DVec3| self.place(triangle, p).2.distance_squared(p);
        Some(self.place(self.search.nearest(point.as_vec3(), distance)?, point))
    }

    /// Triangles about as near to a point as `reach`, as [`TriangleSearch::nearest`] gives them: about `most` of them.
    pub fn near(&self, point: DVec3, reach: f64, most: usize) -> impl Iterator<Item = (usize, DVec3, DVec3)> + '_ {
        let found = self.search.intersecting(&aabb(&[point]).expanded(reach as f32), &WorkLimit::new(TEST * most));
        found.into_iter().map(move |triangle| self.place(triangle, point))
    }

    /// A triangle with the weights of its corners at its point that is nearest to `point`, and that point.
    fn place(&self, triangle: usize, point: DVec3) -> (usize, DVec3, DVec3) {
        let weights = closest_weights(self.corners[triangle], point);
        (triangle, weights, at(self.corners[triangle], weights))
    }
}

/// The shares along two edges where their lines are nearest to each other; none where that is not inside both.
pub fn closest_shares([a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> Option<[f64; 2]> {
    let (u, v, w) = (b - a, d - c, a - c);
    let (uu, uv, vv, uw, vw) = (u.dot(u), u.dot(v), v.dot(v), u.dot(w), v.dot(w));
    let determinant = uu * vv - uv * uv;
    let shares = [(uv * vw - vv * uw) / determinant, (uu * vw - uv * uw) / determinant];
    // Parallel edges are nearest at their ends, of which triangles know.
    (determinant > 1e-6 * uu * vv && shares.iter().all(|s| *s > 0.0 && *s < 1.0)).then_some(shares)
}

/// The way from the second triangle to the first where they are nearest to each other.
pub fn between(first: [DVec3; 3], second: [DVec3; 3]) -> DVec3 {
    let to_point = |p: DVec3, t: [DVec3; 3]| p - at(t, closest_weights(t, p));
    let of_points =
        first.into_iter().map(|p| to_point(p, second)).chain(second.into_iter().map(|p| -to_point(p, first)));
    let pairs = sides(first).into_iter().flat_map(|edge| sides(second).map(|other| (edge, other)));
    let of_edges = pairs.filter_map(|(edge, other)| {
        let [s, t] = closest_shares(edge, other)?;
        Some(edge[0].lerp(edge[1], s) - other[0].lerp(other[1], t))
    });
    let all = of_points.chain(of_edges);
    all.min_by(|a, b| a.length_squared().total_cmp(&b.length_squared())).unwrap_or(DVec3::ZERO)
}

/// Whether two triangles cross: a side of one goes through the other.
pub fn cross(first: [DVec3; 3], second: [DVec3; 3]) -> bool {
    let pierces = |t: [DVec3; 3], other: [DVec3; 3]| sides(t).into_iter().any(|side| goes_through(side, other));
    pierces(first, second) || pierces(second, first)
}

/// Whether an edge goes through a triangle, by the signs of volumes.
fn goes_through([from, to]: [DVec3; 2], [a, b, c]: [DVec3; 3]) -> bool {
    let normal = (b - a).cross(c - a);
    let [start, end] = [from, to].map(|p| normal.dot(p - a));
    // A point in the plane counts as below it, so that an edge which ends there is counted on one side alone. Rounding may lift
    // points of coplanar triangles.
    let size = (b - a).abs().max(to - from).max(from - a).max_element();
    let rounding = ROUNDING * normal.length() * size;
    if (start > rounding) == (end > rounding) {
        return false;
    }
    let along = to - from;
    let volumes = [[a, b], [b, c], [c, a]].map(|[p, q]| along.dot((p - from).cross(q - from)));
    let is_inside = volumes.iter().all(|v| *v >= 0.0) || volumes.iter().all(|v| *v <= 0.0);
    is_inside && volumes != [0.0; 3]
}

fn sides([a, b, c]: [DVec3; 3]) -> [[DVec3; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// The box of points.
pub fn aabb(points: &[DVec3]) -> Aabb {
    Aabb::of(points.iter().map(DVec3::as_vec3a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_cross_where_a_side_goes_through() {
        let flat = [DVec3::ZERO, 2.0 * DVec3::X, 2.0 * DVec3::Y];
        let upright = |x: f64, low: f64| [DVec3::new(x, 0.5, low), DVec3::new(x, 0.6, 1.0), DVec3::new(x, 0.4, 1.0)];
        assert!(cross(flat, upright(0.5, -0.1)) && cross(upright(0.5, -0.1), flat));
        // A corner in the plane is below it; coplanar triangles beside each other do not cross.
        assert!(cross(flat, upright(0.5, 0.0)));
        let (x, y) = (DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.48, 0.64, -0.36).normalize());
        let beside = |at: DVec3| [at, at + x / 3.0, at + y / 7.0];
        for i in 0..100 {
            let at = x * (0.37 * f64::from(i)) + y;
            assert!(!cross(beside(at), beside(at + x / 3.0)) && !cross(beside(at), beside(at + y / 7.0)));
        }
        assert!(!cross(flat, upright(0.5, 0.1)) && !cross(flat, upright(1.7, -0.1)));
        let away = between(upright(0.5, 0.1), flat);
        assert!(away.distance(0.1 * DVec3::Z) < 1e-6, "{away}");
        assert!(between(flat, upright(0.5, 0.1)).distance(-0.1 * DVec3::Z) < 1e-6);
    }
}
