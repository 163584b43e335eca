//! The axis that separates two quads best.

use glam::Vec3;
use tailor_mesh::connectivity::VertexId;

/// A child of a face, with its vertices in the refinement.
pub struct Quad {
    /// Its corners. \[mesh units\]
    pub points: [Vec3; 4],
    /// Their vertices.
    pub vertices: [VertexId; 4],
}

impl Quad {
    fn edges(&self) -> [Vec3; 4] {
        [0, 1, 2, 3].map(|i| self.points[(i + 1) % 4] - self.points[i])
    }

    fn normal(&self) -> Vec3 {
        let [a, b, c, d] = self.points;
        (c - a).cross(d - b)
    }

    /// The least height along an axis of the points that are not those of another quad too.
    fn lowest(&self, axis: Vec3, other: &Self) -> f32 {
        let own = (0..4).filter(|&i| !other.vertices.contains(&self.vertices[i]));
        own.map(|i| self.points[i].dot(axis)).fold(f32::INFINITY, f32::min)
    }
}

/// The axis along which `a` is furthest over `b`, of those that can separate convex quads: the normals, and the cross
/// products of an edge of each (Gottschalk, Lin and Manocha 1996, *OBBTree*, section 5).
pub fn separating_axis(a: &Quad, b: &Quad) -> Vec3 {
    let across = a.edges().into_iter().flat_map(|e| b.edges().map(|f| e.cross(f)));
    let axes = [a.normal(), b.normal()].into_iter().chain(across).filter_map(Vec3::try_normalize);
    let distance = |axis: Vec3| a.lowest(axis, b) + b.lowest(-axis, a);
    let both = axes.flat_map(|axis| [axis, -axis]).map(|axis| (axis, distance(axis)));
    both.max_by(|(_, d), (_, e)| d.total_cmp(e)).map_or(Vec3::ZERO, |(axis, _)| axis)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quads_are_separated_along_an_axis() {
        let quad = |points: [[f32; 3]; 4], first: usize| Quad {
            points: points.map(Vec3::from),
            vertices: std::array::from_fn(|i| VertexId::new(first + i)),
        };
        let ground = quad([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], 0);
        let over = quad([[0.0, 0.0, 0.2], [1.0, 0.0, 0.1], [1.0, 1.0, 0.2], [0.0, 1.0, 0.1]], 4);
        let axis = separating_axis(&over, &ground);
        assert!(axis.abs_diff_eq(Vec3::Z, 1e-6) && separating_axis(&ground, &over).abs_diff_eq(-Vec3::Z, 1e-6));
        // Turned about a common edge.
        let mut beside = quad([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.5, 1.0], [0.0, 0.5, 1.0]], 8);
        beside.vertices[0] = ground.vertices[0];
        beside.vertices[1] = ground.vertices[1];
        let axis = separating_axis(&beside, &ground);
        assert!(beside.lowest(axis, &ground) > 0.5 && ground.lowest(-axis, &beside) > -1e-6, "{axis}");
    }
}
