//! Which triangles an edit may make.

use crate::mesh::CornerId;
use crate::mesh::edit::{next, prev};
use crate::sim::sim_mesh::{SimMesh, Wedge};
use glam::Vec3;

/// A triangle with less than this share of the area of the equilateral triangle on its longest edge is degenerate.
const MIN_SHAPE: f32 = 0.02;

/// A corner of a triangle that is there, or that an edit would make.
pub(crate) type Corner<'a> = (Vec3, &'a Wedge);

impl SimMesh<'_> {
    /// How bad a triangle with these corners is: 0 good, 1 degenerate or folded over in space, 2 the wrong way round in
    /// UV. No edit may make a triangle worse than what it replaces.
    #[inline(always)]
    pub(crate) fn defect(&self, [(a, pa), (b, pb), (c, pc)]: [Corner<'_>; 3]) -> u8 {
        if self.baseline.holds_uvs {
            let (u, v) = (pb.place.uv - pa.place.uv, pc.place.uv - pa.place.uv);
            if u.perp_dot(v) * pa.sense <= 0.0 {
                return 2;
            }
        }
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(ac);
        let longest = ab.length_squared().max(ac.length_squared()).max(b.distance_squared(c));
        let surface = pa.normal + pb.normal + pc.normal;
        let least = 0.866 * MIN_SHAPE * longest;
        u8::from(normal.length_squared() <= least * least || normal.dot(surface) <= 0.0)
    }

    /// The least cosine between a triangle with these corners and the surface at one of them.
    #[inline(always)]
    pub(crate) fn alignment(&self, corners: [Corner<'_>; 3]) -> f32 {
        let [(a, p), (b, q), (c, r)] = corners;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        normal.dot(p.normal).min(normal.dot(q.normal)).min(normal.dot(r.normal))
    }

    /// Position and site of a corner.
    #[inline(always)]
    pub(crate) fn corner(&self, corner: CornerId) -> Corner<'_> {
        (self.points[self.topology.vertex(corner)], self.wedge(corner))
    }

    /// The corners of a triangle from one of them on.
    #[inline(always)]
    pub(crate) fn corners(&self, corner: CornerId) -> [Corner<'_>; 3] {
        [self.corner(corner), self.corner(next(corner)), self.corner(prev(corner))]
    }

    /// How bad the triangle of a corner is.
    pub(crate) fn face_defect(&self, corner: CornerId) -> u8 {
        self.defect(self.corners(corner))
    }
}
