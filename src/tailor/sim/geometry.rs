//! Distances and angles of segments and triangles.

use glam::Vec3;

/// The unsigned angle between two vectors, 0 to π. \[radians\]
#[inline]
pub fn angle(u: Vec3, v: Vec3) -> f32 {
    u.cross(v).length().atan2(u.dot(v))
}

/// Distance of a point from a segment.
pub fn distance_to_segment(p: Vec3, a: Vec3, b: Vec3) -> f32 {
    let along = b - a;
    let t = (p - a).dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
    p.distance(a + along * t.clamp(0.0, 1.0))
}

/// The cosine of a triangle's smallest angle, which is opposite its shortest side.
#[inline]
pub fn smallest_angle_cosine([a, b, c]: [Vec3; 3]) -> f32 {
    let (x, y, z) = (b.distance_squared(c), c.distance_squared(a), a.distance_squared(b));
    let (least, most, middle) = (x.min(y).min(z), x.max(y).max(z), x.max(y).min(x.min(y).max(z)));
    (most + middle - least) / (2.0 * (most * middle).sqrt()).max(f32::MIN_POSITIVE)
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
    // Edges of zero length are skipped: the point is closest to another edge.
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
