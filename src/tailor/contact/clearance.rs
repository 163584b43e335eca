//! How far it is from each face of a cage to the next layer.

use super::bvh::Aabb;
use super::face::{self, ChildBlock, RefinedFace};
use super::faces::RefinedFaces;
use super::simd::bits;
use glam::Vec3;
use rayon::prelude::*;
use tailor_mesh::connectivity::{FaceId, IdVec};

/// Cosine between normals below which faces with a common vertex are two sides of a fold.
const FOLDED: f32 = -0.3;
/// Share of a face's size within which points of faces with a common vertex count as common.
const COMMON: f32 = 1e-3;
/// Cosine between a triangle's normal and the direction below which it is seen edge on, and has no height.
const EDGE_ON: f32 = 1e-2;
/// Faces over and under a face after which it is crowded where it has no clearance on either side.
const MOST_OVER: usize = 256;
/// Share of the reach below which there is no clearance.
const NO_CLEARANCE: f32 = 0.01;
/// Part of a triangle's area by which a point may be outside it.
const ROUNDING: f32 = 1e-6;

/// Distance to the next layer against and along the normal. \[mesh units\]
pub type Clearance = [f32; 2];

/// No layer is near.
pub const UNBOUNDED: Clearance = [f32::INFINITY; 2];

/// The smaller clearance on each side.
pub fn smaller(a: Clearance, b: Clearance) -> Clearance {
    [a[0].min(b[0]), a[1].min(b[1])]
}

/// A face in a frame whose last axis is its normal.
struct View<'a> {
    face: &'a RefinedFace,
    axes: [Vec3; 3],
    blocks: Vec<ChildBlock>,
    points: Vec<Vec3>,
    aabb: Aabb,
}

impl<'a> View<'a> {
    fn new(face: &'a RefinedFace) -> Self {
        let (u, v) = face.normal.try_normalize().unwrap_or(Vec3::Z).any_orthonormal_pair();
        let axes = [u, v, face.normal];
        let blocks: Vec<ChildBlock> = face.blocks().map(|block| block.in_frame(&axes)).collect();
        let (points, aabb) = (face::points(blocks.iter()).collect(), face::aabb(blocks.iter()));
        Self { face, axes, points, aabb, blocks }
    }

    /// Whether a box, in the frame of the cage, is beside the face: neither over nor under it.
    fn is_beside(&self, aabb: &Aabb) -> bool {
        let (middle, half) = (Vec3::from(0.5 * (aabb.low + aabb.high)), Vec3::from(0.5 * (aabb.high - aabb.low)));
        (0..2).any(|i| {
            let (at, radius) = (middle.dot(self.axes[i]), half.dot(self.axes[i].abs()));
            at + radius <= self.aabb.low[i] || at - radius >= self.aabb.high[i]
        })
    }
}

impl RefinedFaces<'_> {
    /// The clearance of each face, as far as it is within `reach`. A face in a crowd has none.
    pub fn clearances(&self, reach: f32) -> IdVec<FaceId, Clearance> {
        let of = |face: &RefinedFace| {
            let (mut clearance, view, mut blocks, mut over) = (UNBOUNDED, View::new(face), Vec::new(), 0);
            let is_known = self.tree().visit_while(&face.aabb.expanded(reach), &mut |other| {
                over += usize::from(self.narrow(&view, &self.faces[other], reach, &mut blocks, &mut clearance));
                over <= MOST_OVER || clearance[0].max(clearance[1]) > NO_CLEARANCE * reach
            });
            if is_known { clearance } else { [0.0; 2] }
        };
        let found: Vec<Clearance> = self.faces.par_iter().map(of).collect();
        let mut clearances = IdVec::filled(UNBOUNDED, found.len());
        self.faces.iter().zip(found).for_each(|(face, clearance)| clearances[face.face] = clearance);
        clearances
    }

    /// Narrows the clearance of a face to what another leaves of it; whether it may be over or under the face. `blocks` is
    /// scratch memory.
    fn narrow(
        &self,
        view: &View,
        other: &RefinedFace,
        reach: f32,
        blocks: &mut Vec<ChildBlock>,
        clearance: &mut Clearance,
    ) -> bool {
        if view.face.face == other.face || view.is_beside(&other.aabb) {
            return false;
        }
        let touch = self.touch(view.face, other);
        if touch && view.axes[2].dot(other.normal) > FOLDED {
            return false;
        }
        blocks.clear();
        blocks.extend(other.blocks().map(|block| block.in_frame(&view.axes)));
        let (own, its) = (view.aabb, face::aabb(blocks.iter()));
        // Nearer layers are known on both sides.
        let is_far =
            its.low.z - own.high.z > clearance[1].min(reach) || own.low.z - its.high.z > clearance[0].min(reach);
        if is_far || (0..2).any(|i| its.high[i] <= own.low[i] || its.low[i] >= own.high[i]) {
            return true;
        }
        let least = if touch { COMMON * view.face.aabb.longest_side() } else { 0.0 };
        let mut take = |height: f32| {
            if height.abs() >= least {
                let side = usize::from(height > 0.0);
                clearance[side] = clearance[side].min(height.abs());
            }
        };
        // From the points of each face to the other one, as either may have the finer ones.
        heights_over(&view.points.iter().copied(), blocks, &mut take);
        heights_over(&face::points(blocks.iter()), &view.blocks, &mut |height| take(-height));
        true
    }
}

/// The heights of the children over and under each of `points` above it, along the last axis.
fn heights_over(points: &(impl Iterator<Item = Vec3> + Clone), blocks: &[ChildBlock], take: &mut impl FnMut(f32)) {
    for block in blocks {
        let aabbs = block.aabbs();
        for p in points.clone() {
            let children = bits(aabbs.over_or_under(p) & block.mask());
            children.filter_map(|i| height_over(p, block.child(i))).for_each(&mut *take);
        }
    }
}

/// The height of a quad above `p` along the last axis; none where it is neither over nor under `p`.
fn height_over(p: Vec3, [a, b, c, d]: [Vec3; 4]) -> Option<f32> {
    [[a, b, c], [a, c, d]].into_iter().find_map(|[a, b, c]| {
        let normal = (b - a).cross(c - a);
        if normal.z.abs() < EDGE_ON * normal.length() {
            return None;
        }
        let part = |u: Vec3, v: Vec3| (v - u).truncate().perp_dot((p - u).truncate()) / normal.z;
        let parts = [part(b, c), part(c, a), part(a, b)];
        let inside = parts.iter().all(|&part| part >= -ROUNDING);
        inside.then(|| parts[0] * a.z + parts[1] * b.z + parts[2] * c.z - p.z)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::morton_order;
    use tailor_mesh::connectivity::{Faces, VertexId};
    use tailor_mesh::garment::Mesh;
    use tailor_testing::cage::Cage;

    /// `count` parallel quads, this far from each other.
    fn stack(count: usize, gap: f32) -> IdVec<FaceId, Clearance> {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let points = (0..count).flat_map(|i| corners.map(|[x, y]| Vec3::new(x, y, gap * i as f32)));
        let cage = Cage::new(Mesh {
            points: points.collect(),
            faces: Faces::quads((0..4 * count).map(VertexId::new).collect::<Vec<_>>()),
            ..Mesh::default()
        });
        let points = &cage.garment().points;
        let order = morton_order(&cage.garment().faces, points);
        RefinedFaces::new(cage.level(), cage.level().vertex_rows(), points, &order, None).clearances(1.0)
    }

    #[test]
    fn a_face_in_a_crowd_has_no_clearance_and_one_in_a_stack_has_the_gap() {
        let clearances = stack(1000, 1e-5);
        assert!(clearances.iter().all(|of| of[0].min(of[1]) < 1e-4));
        assert!(clearances.iter().filter(|of| **of == [0.0; 2]).count() > 500);
        let clearances = stack(1000, 0.02);
        let inner = &clearances.as_slice()[1..999];
        assert!(inner.iter().flatten().all(|gap| (gap - 0.02).abs() < 1e-4));
    }
}
