//! Which children of a cage's faces may intersect on the next refinement.

use super::bvh::Bvh;
use super::face::{ChildId, RefinedFace};
use super::faces::RefinedFaces;
use super::intersect::{Motion, are_opposed, are_within_sharp, find_near_children};
use super::simd::bits;
use crate::mesh::FaceId;
use glam::Vec3;
use rayon::prelude::*;

/// Part of its size that any point of a face may move. Larger finds more pairs that do not intersect.
const SLACK: f32 = 1e-4;

/// How far the next refinement may move faces, and their bounds with that.
pub struct Proximity {
    motions: Vec<Motion>,
    tree: Bvh,
}

impl Proximity {
    /// The proximity of all faces.
    pub fn new(faces: &RefinedFaces) -> Self {
        let motions: Vec<Motion> = faces.faces.par_iter().map(next_motion).collect();
        let tree = Bvh::new(motions.len(), |slot| motions[slot].swept(&faces.faces[slot].aabb));
        Self { motions, tree }
    }

    /// Follows faces that have moved.
    pub fn update(&mut self, faces: &RefinedFaces, moved: &[FaceId]) {
        let slots = faces.slots_of(moved);
        slots.iter().for_each(|&slot| self.motions[slot] = next_motion(&faces.faces[slot]));
        self.tree.refit(&slots, |slot| self.motions[slot].swept(&faces.faces[slot].aabb));
    }

    /// Pairs of children that may intersect on the next refinement, of which at least one is of an active face.
    pub fn pairs(&self, faces: &RefinedFaces, active: &[FaceId]) -> Vec<[ChildId; 2]> {
        // Layers move together: only the difference of their motions counts.
        let motion = |a: usize, b: usize| self.motions[a].relative_to(&self.motions[b]);
        let may_intersect = |a: usize, b: usize| {
            let (f, g) = (&faces.faces[a], &faces.faces[b]);
            if a != b && faces.touch(f, g) {
                // Neighbours move together, but for the layers that a fold joins where it ends.
                let are_doubtful = f.may_overlap && g.may_overlap && !are_within_sharp(f, g) || are_opposed(f, g);
                are_doubtful && faces.may_touching_intersect(f, g)
            } else {
                faces.may_intersect(f, g, &motion(a, b))
            }
        };
        let near_children = |&[a, b]: &[usize; 2]| {
            let mut found = Vec::new();
            find_near_children(&faces.faces[a], &faces.faces[b], &motion(a, b), &mut |a, b| {
                found.push([a.id, b.id]);
                false
            });
            found.sort_unstable();
            found
        };
        let near = self.tree.pairs(&faces.slots_of(active), may_intersect);
        near.par_iter().flat_map_iter(near_children).collect()
    }
}

/// How far the next refinement moves a face's centre, and other points no further as a rule.
fn next_motion(face: &RefinedFace) -> Motion {
    // Catmull and Clark's mask of a vertex, at the face point.
    let (valence, centre) = (face.valence as f32, face.first.face_point);
    let (mut faces, mut edges) = (Vec3::ZERO, Vec3::ZERO);
    for block in face.blocks() {
        for i in bits(block.mask()) {
            let [vertex, edge, _, previous] = block.child(i);
            faces += 0.25 * (vertex + edge + centre + previous);
            edges += 0.5 * (centre + edge);
        }
    }
    let next = ((faces + 2.0 * edges) / valence + (valence - 3.0) * centre) / valence;
    Motion { by: next - centre, slack: SLACK * face.aabb.longest_side() }
}
