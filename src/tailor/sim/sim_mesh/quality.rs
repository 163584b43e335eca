//! Quality of triangles, and edits that keep it.

use super::{SimMesh, Wedge};
use glam::Vec3;
use tailor_mesh::connectivity::CornerId;
use tailor_mesh::connectivity::edit::{next, prev};

/// A triangle with less than this share of the area of the equilateral triangle on its longest edge is degenerate.
const MIN_SHAPE: f32 = 0.02;

/// Least cosine between the normals of a triangle and of the surface at its corners that collapses and moves allow. Beyond
/// it a triangle bridges a sharp edge and erases it. Larger values keep more of it, but leave short edges along it.
pub const MIN_COSINE: f32 = 0.2;

/// The cosine that flips allow. Larger values keep more flips from turning edges out of a sharp edge.
const MIN_FLIP_COSINE: f32 = 0.85;

/// Position and wedge of a triangle's corner.
pub type TriangleCorner<'a> = (Vec3, &'a Wedge);

/// The fault of a triangle. No edit may replace triangles by worse ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Defect {
    /// None.
    Good,
    /// Degenerate, or facing away from the surface.
    Degenerate,
    /// Flipped in UV.
    Flipped,
}

impl SimMesh<'_> {
    /// The defect of a triangle with these corners.
    #[inline(always)]
    pub fn defect(&self, [(a, pa), (b, pb), (c, pc)]: [TriangleCorner<'_>; 3]) -> Defect {
        // Where the layout is free at a corner, it is flipped, or the triangle has UVs of two shells.
        if self.baseline.has_uvs && pa.sense * pb.sense * pc.sense != 0.0 {
            let (u, v) = (pb.place.uv - pa.place.uv, pc.place.uv - pa.place.uv);
            if u.perp_dot(v) * pa.sense <= 0.0 {
                return Defect::Flipped;
            }
        }
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(ac);
        let longest = ab.length_squared().max(ac.length_squared()).max(b.distance_squared(c));
        let surface = pa.normal + pb.normal + pc.normal;
        let least = 0.866 * MIN_SHAPE * longest;
        match normal.length_squared() <= least * least || normal.dot(surface) <= 0.0 {
            true => Defect::Degenerate,
            false => Defect::Good,
        }
    }

    /// The least cosine between a triangle with these corners and the surface at one of them.
    #[inline(always)]
    pub fn alignment(&self, corners: [TriangleCorner<'_>; 3]) -> f32 {
        let [(a, p), (b, q), (c, r)] = corners;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        normal.dot(p.normal).min(normal.dot(q.normal)).min(normal.dot(r.normal))
    }

    /// Position and wedge of a corner.
    #[inline(always)]
    pub fn corner(&self, corner: CornerId) -> TriangleCorner<'_> {
        (self.points[self.topology.vertex(corner)], self.wedge(corner))
    }

    /// The corners of a triangle from one of them on.
    #[inline(always)]
    pub fn corners(&self, corner: CornerId) -> [TriangleCorner<'_>; 3] {
        [self.corner(corner), self.corner(next(corner)), self.corner(prev(corner))]
    }

    /// The defect of a corner's triangle.
    pub fn face_defect(&self, corner: CornerId) -> Defect {
        self.defect(self.corners(corner))
    }

    /// Whether flipping an edge makes a new edge, in this patch and all others.
    pub fn may_flip(&self, half: CornerId) -> bool {
        let apexes = self.topology.twin(half).map(|t| [half, t].map(|h| self.topology.vertex(prev(h))));
        apexes.is_some_and(|[c, d]| self.may_connect(c, d)) && self.topology.may_flip(half)
    }

    /// Whether flipping an edge makes no triangle worse. One that turns far from the surface may turn no further than the
    /// old triangles did.
    pub fn flip_is_safe(&self, half: CornerId) -> bool {
        let Some(twin) = self.topology.twin(half) else { return false };
        let ([a, b, c], d) = (self.corners(half), self.corner(prev(twin)));
        let new = self.defect([c, d, b]).max(self.defect([d, c, a]));
        let is_aligned = || {
            let after = self.alignment([c, d, b]).min(self.alignment([d, c, a]));
            after >= MIN_FLIP_COSINE || after >= self.alignment([a, b, c]).min(self.alignment([b, a, d]))
        };
        (new == Defect::Good && is_aligned()) || new < self.face_defect(half).max(self.face_defect(twin))
    }
}
