//! How a distance from chains goes on over a triangle: as a plane wave beside an edge, as a circle around a vertex.
//!
//! Two corners with known distances give that of the third one: the source is unfolded into the plane of the triangle. Both
//! waves are exact on flat cloth.
//!
//! Reference: Kimmel, Sethian 1998, Computing Geodesic Paths on Manifolds.

use glam::Vec3;
use tailor_mesh::connectivity::VertexId;

/// Overhang by which a ray may miss the edge that it crosses, as a share of the edge.
const OVERHANG: f32 = 1e-3;

/// Distance of the feet of two points, as a share of that of the points, above which they are of two waves that meet. One wave
/// spreads its points, or draws them together where a chain is bent.
const APART: f32 = 1.2;

/// The form of a wave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wave {
    /// From an edge of a chain, or from several places.
    Plane,
    /// From a vertex of a chain.
    Circle(VertexId),
}

/// The nearest place on the chains.
#[derive(Clone, Copy, Debug)]
pub struct Foot {
    /// Distance along the surface. \[mesh units\]
    pub distance: f32,
    /// The side of the chain: 0 on its left, 1 on its right.
    pub side: usize,
    /// Index of the chain.
    pub chain: usize,
    /// The place on the chain, as the length from its start. \[mesh units\]
    pub along: f32,
    /// The position of that place.
    pub place: Vec3,
    /// The form of the wave there.
    pub wave: Wave,
}

/// The foot of a point at the end of an edge of a length.
pub fn over_edge(from: Foot, length: f32) -> Foot {
    Foot { distance: from.distance + length, ..from }
}

/// The foot of the point `c`, where the wave comes through the edge from `a` to `b`; none where two waves meet there.
pub fn over_triangle((a, at_a): (Vec3, Foot), (b, at_b): (Vec3, Foot), c: Vec3) -> Option<Foot> {
    let length = a.distance(b);
    let along = (b - a) / length;
    let x = (c - a).dot(along);
    let y = (c - a - x * along).length();
    let is_flat = length.is_nan() || length <= f32::MIN_POSITIVE || y <= 1e-4 * length;
    if is_flat {
        return None;
    }
    let (distance, crossing, wave) = match (at_a.wave, at_b.wave) {
        (Wave::Circle(v), Wave::Circle(w)) if v == w => {
            let sx = (length * length + at_a.distance.powi(2) - at_b.distance.powi(2)) / (2.0 * length);
            let sy = (at_a.distance.powi(2) - sx * sx).max(0.0).sqrt();
            ((x - sx).hypot(y + sy), sx + (x - sx) * sy / (y + sy), Wave::Circle(v))
        }
        _ if at_a.place.distance(at_b.place) > APART * length => return None,
        _ => {
            let slope = (at_b.distance - at_a.distance) / length;
            let ahead = (1.0 - slope * slope).max(0.0).sqrt();
            if ahead <= 1e-3 {
                return None;
            }
            (at_a.distance + slope * x + ahead * y, x - slope / ahead * y, Wave::Plane)
        }
    };
    let share = crossing / length;
    let is_through = (-OVERHANG..=1.0 + OVERHANG).contains(&share) && distance.is_finite();
    is_through.then(|| {
        let nearer = if share < 0.5 { at_a } else { at_b };
        let is_same = (at_a.chain, at_a.side) == (at_b.chain, at_b.side);
        let (share, step) = (share.clamp(0.0, 1.0), at_b.along - at_a.along);
        // The ends of a closed chain are in one place, and so are those of sides far from it.
        let is_near = step.abs() <= 2.0 * length;
        let along = if is_same && is_near { at_a.along + share * step } else { nearer.along };
        Foot { distance, along, place: at_a.place.lerp(at_b.place, share), wave, ..nearer }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn foot(distance: f32, wave: Wave) -> Foot {
        Foot { distance, side: 0, chain: 0, along: 0.0, place: Vec3::ZERO, wave }
    }

    #[test]
    fn waves_are_exact_on_a_plane() {
        let (a, b, c) = (Vec3::new(2.0, 1.0, 0.0), Vec3::new(1.0, 2.0, 0.0), Vec3::new(2.5, 2.5, 0.0));
        let v = Wave::Circle(VertexId::new(0));
        let round = over_triangle((a, foot(a.length(), v)), (b, foot(b.length(), v)), c).expect("a foot");
        assert!((round.distance - c.length()).abs() < 1e-5 && round.wave == v);
        let plane = over_triangle((a, foot(a.y, Wave::Plane)), (b, foot(b.y, Wave::Plane)), c);
        // The ray from below does not come through the edge.
        assert!(plane.is_none());
        let c = Vec3::new(1.7, 2.5, 0.0);
        let plane = over_triangle((a, foot(a.y, Wave::Plane)), (b, foot(b.y, Wave::Plane)), c).expect("a foot");
        assert!((plane.distance - c.y).abs() < 1e-5);
    }

    #[test]
    fn waves_that_meet_are_not_one() {
        // Points beside the two legs of a corner, each as far from its own: no plane wave leads on from both.
        let at = |place: Vec3| Foot { place, ..foot(0.5, Wave::Plane) };
        let (a, b) = ((Vec3::new(1.0, 0.5, 0.0), at(Vec3::X)), (Vec3::new(0.5, 1.0, 0.0), at(Vec3::Y)));
        assert!(over_triangle(a, b, Vec3::new(1.0, 1.0, 0.0)).is_none());
        // Beside one leg it does.
        let b = (Vec3::new(1.5, 0.5, 0.0), at(1.5 * Vec3::X));
        let beyond = over_triangle(a, b, Vec3::new(1.2, 1.0, 0.0)).expect("a foot");
        assert!((beyond.distance - 1.0).abs() < 1e-5 && beyond.place.distance(1.2 * Vec3::X) < 1e-5);
    }
}
