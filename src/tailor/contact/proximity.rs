//! Which children of a cage's faces may intersect on the next refinement.

use super::bvh::Bvh;
use super::face::{ChildId, RefinedFace};
use super::faces::RefinedFaces;
use super::intersect::{Motion, are_opposed, are_within_sharp, find_near_children};
use super::pairs::{Pairs, TEST, WorkLimit};
use super::simd::bits;
use glam::Vec3;
use rayon::prelude::*;
use tailor_mesh::connectivity::FaceId;

/// Part of its size that any point of a face may move. Larger finds more pairs that do not intersect.
const SLACK: f32 = 1e-4;

/// The work of a test of two children that have to be refined for it.
const NEXT_TEST: usize = 2 * TEST;

/// The contacts that are possible on the next refinement.
pub struct NextContacts {
    /// Pairs of children.
    pub pairs: Vec<[ChildId; 2]>,
    /// Active faces in a crowd that is too close to be tested.
    pub crowded: Vec<FaceId>,
}

/// How far the next refinement may move faces, and their bounds with that.
pub struct Proximity {
    motions: Vec<Motion>,
    tree: Bvh,
}

impl Proximity {
    /// The proximity of all faces.
    pub fn new(faces: &RefinedFaces) -> Self {
        let motions: Vec<Motion> = faces.faces.par_iter().map(next_motion).collect();
        let tree = Bvh::new(motions.len(), |slot| motions[slot].swept(&faces.faces[slot].crossable()));
        Self { motions, tree }
    }

    /// Follows faces that have moved.
    pub fn update(&mut self, faces: &RefinedFaces, moved: &[FaceId]) {
        let slots = faces.slots_of(moved);
        slots.iter().for_each(|&slot| self.motions[slot] = next_motion(&faces.faces[slot]));
        self.tree.refit(&slots, |slot| self.motions[slot].swept(&faces.faces[slot].crossable()));
    }

    /// Pairs of children that may intersect on the next refinement, of which at least one is of an active face, and crowds.
    /// Incomplete beyond the bound of `work`.
    pub fn contacts(&self, faces: &RefinedFaces, active: &[FaceId], work: &WorkLimit) -> NextContacts {
        // Layers move together: only the difference of their motions counts.
        let motion = |a: usize, b: usize| self.motions[a].relative_to(&self.motions[b]);
        let may_intersect = |a: usize, b: usize| {
            let (f, g) = (&faces.faces[a], &faces.faces[b]);
            if a != b && faces.touch(f, g) {
                // Neighbours move together, except for the layers that a fold joins where it ends.
                let are_doubtful = f.may_overlap && g.may_overlap && !are_within_sharp(f, g) || are_opposed(f, g);
                are_doubtful && faces.may_touching_intersect(f, g)
            } else {
                faces.may_intersect(f, g, &motion(a, b))
            }
        };
        let near_children = |&[a, b]: &[usize; 2]| {
            let mut found = Vec::new();
            if work.is_over() {
                return found;
            }
            find_near_children(&faces.faces[a], &faces.faces[b], &motion(a, b), &mut |a, b| {
                found.push([a.id, b.id]);
                false
            });
            work.take(NEXT_TEST * found.len());
            found.sort_unstable();
            found
        };
        let Pairs { found, crowded } = self.tree.pairs(&faces.slots_of(active), may_intersect, |_, _| true, work);
        NextContacts {
            pairs: found.par_iter().flat_map_iter(near_children).collect(),
            crowded: crowded.into_iter().map(|slot| faces.faces[slot].face).collect(),
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::morton_order;
    use std::collections::HashSet;
    use tailor_mesh::connectivity::{Faces, VertexId};
    use tailor_mesh::garment::Mesh;
    use tailor_testing::cage::Cage;

    /// A sheet of 40 x 40 quads, the first 20 columns of which are crumpled into a ball of this size.
    fn crumpled(size: f32) -> Cage {
        let n = 40;
        let random = |i: usize, axis: usize| {
            ((3 * i + axis + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40) as f32 / (1 << 24) as f32
        };
        let point = |i: usize| {
            let [x, y] = [i % (n + 1), i / (n + 1)];
            let ball = Vec3::from([0, 1, 2].map(|axis| size * random(i, axis)));
            if x <= n / 2 { ball } else { Vec3::new(x as f32, y as f32, 0.0) }
        };
        let first = (0..n * (n + 1)).filter(|i| i % (n + 1) < n);
        let corners = first.flat_map(|i| [i, i + 1, i + n + 2, i + n + 1]).map(VertexId::new);
        Cage::new(Mesh {
            points: (0..(n + 1) * (n + 1)).map(point).collect(),
            faces: Faces::quads(corners.collect::<Vec<_>>()),
            ..Mesh::default()
        })
    }

    #[test]
    fn no_face_of_a_crowd_passes_for_one_that_is_free() {
        for size in [1e-4, 1e-2, 1.0] {
            let cage = crumpled(size);
            let points = &cage.garment().points;
            let order = morton_order(&cage.garment().faces, points);
            let faces = RefinedFaces::new(cage.level(), cage.level().vertex_rows(), points, &order, None);
            let in_ball = |face: &&FaceId| {
                faces.level().topology.faces.vertices_of(**face).iter().all(|&v| points[v].max_element() <= size)
            };
            let all: Vec<FaceId> = cage.garment().faces.ids().collect();
            let ball: Vec<FaceId> = all.iter().filter(in_ball).copied().collect();
            assert_eq!(ball.len(), 20 * 40);
            let told: HashSet<FaceId> =
                faces.intersecting_pairs(&all, &WorkLimit::default()).into_iter().flatten().collect();
            assert!(ball.iter().all(|face| told.contains(face)), "{size}");
            let NextContacts { pairs, crowded } = Proximity::new(&faces).contacts(&faces, &all, &WorkLimit::default());
            let near: HashSet<FaceId> = pairs.iter().flatten().map(|(face, _)| *face).chain(crowded).collect();
            assert!(ball.iter().all(|face| near.contains(face)), "{size}");
        }
    }

    #[test]
    fn faces_in_one_point_cross_none() {
        let cage = crumpled(0.0);
        let points = &cage.garment().points;
        let all: Vec<FaceId> = cage.garment().faces.ids().collect();
        let faces = RefinedFaces::new(cage.level(), cage.level().vertex_rows(), points, &all, None);
        assert!(faces.intersecting_pairs(&all, &WorkLimit::default()).is_empty());
    }
}
