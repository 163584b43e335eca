//! A bounding volume hierarchy, four boxes to a node, over boxes in Morton order.

use super::simd::{Aabbx4, WIDTH, bits};
use glam::{Vec3, Vec3A};
use rayon::prelude::*;
use tailor_mesh::connectivity::{FaceId, Faces, IdVec, VertexId};

/// Nodes that one task builds at least.
const NODES_BUILT_PER_TASK: usize = 256;
/// Bits of each coordinate in a Morton code.
const MORTON_BITS: u32 = 10;
/// Points in one cell of these codes that keep the order of their indices.
const MOST_IN_CELL: usize = 64;

/// An axis-aligned bounding box.
#[derive(Clone, Copy, Debug)]
pub struct Aabb {
    /// Least corner.
    pub low: Vec3A,
    /// Largest corner.
    pub high: Vec3A,
}

impl Aabb {
    /// The box of no point.
    pub const EMPTY: Self = Self { low: Vec3A::INFINITY, high: Vec3A::NEG_INFINITY };

    /// The box of some points.
    pub fn of(points: impl IntoIterator<Item = Vec3A>) -> Self {
        points.into_iter().fold(Self::EMPTY, |all, p| all.merged(&Self { low: p, high: p }))
    }

    /// The box of both.
    pub fn merged(&self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// The box that both have in common. Where they are apart, `low` exceeds `high`.
    pub fn intersection(&self, other: &Self) -> Self {
        Self { low: self.low.max(other.low), high: self.high.min(other.high) }
    }

    /// The box with a margin on each side.
    pub fn expanded(&self, by: f32) -> Self {
        Self { low: self.low - by, high: self.high + by }
    }

    /// The box of this one and its translate.
    pub fn swept(&self, by: Vec3) -> Self {
        let by = Vec3A::from(by);
        self.merged(&Self { low: self.low + by, high: self.high + by })
    }

    /// The squared distance of a point.
    pub fn distance_squared(&self, point: Vec3A) -> f32 {
        point.distance_squared(point.clamp(self.low, self.high))
    }

    /// Length of the longest side.
    pub fn longest_side(&self) -> f32 {
        (self.high - self.low).max_element()
    }
}

/// Faces sorted by the Morton codes of their centres, so that neighbours in space are near in memory.
pub fn morton_order(faces: &Faces, points: &IdVec<VertexId, Vec3>) -> Vec<FaceId> {
    let centre = |face: FaceId| {
        let vertices = faces.vertices_of(face);
        vertices.iter().map(|&v| Vec3A::from(points[v])).sum::<Vec3A>() / vertices.len() as f32
    };
    let centres: Vec<Vec3A> = (0..faces.len()).into_par_iter().map(|face| centre(FaceId::new(face))).collect();
    morton_sorted(&centres).into_iter().map(FaceId::new).collect()
}

/// The indices of points, sorted by their Morton codes.
pub fn morton_sorted(centres: &[Vec3A]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..centres.len()).collect();
    sort_by_morton(&mut order, centres);
    order
}

/// Sorts indices of points by their Morton codes, and those of a cell that holds many by codes of their own.
fn sort_by_morton(indices: &mut [usize], centres: &[Vec3A]) {
    let all = Aabb::of(indices.iter().map(|&i| centres[i]));
    let scale = ((1u32 << MORTON_BITS) - 1) as f32 / all.longest_side().max(f32::MIN_POSITIVE);
    let code = |&i: &usize| {
        let cell = ((centres[i] - all.low) * scale).as_uvec3();
        (spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2, i)
    };
    let mut keys: Vec<(u32, usize)> = indices.par_iter().map(code).collect();
    keys.par_sort_unstable();
    indices.iter_mut().zip(&keys).for_each(|(index, key)| *index = key.1);
    let mut rest = indices;
    for cell in keys.chunk_by(|a, b| a.0 == b.0) {
        let (of_cell, after) = rest.split_at_mut(cell.len());
        if of_cell.len() > MOST_IN_CELL && of_cell.len() < keys.len() {
            sort_by_morton(of_cell, centres);
        }
        rest = after;
    }
}

/// A hierarchy of boxes. Box `i` is element `i % 4` of leaf node `i / 4`.
pub struct Bvh {
    /// The nodes of each level, from the leaves to the root.
    levels: Vec<Vec<Aabbx4>>,
}

impl Bvh {
    /// The hierarchy of `count` boxes, which are in an order in which neighbours in space are close.
    pub fn new(count: usize, aabb: impl Fn(usize) -> Aabb + Sync) -> Self {
        let mut levels = vec![nodes(count, aabb)];
        while let Some(below) = levels.last().filter(|nodes| nodes.len() > 1) {
            levels.push(nodes(below.len(), |node| below[node].whole()));
        }
        Self { levels }
    }

    /// The box of all.
    pub(super) fn bounds(&self) -> Aabb {
        self.levels[self.levels.len() - 1][0].whole()
    }

    /// The box of a node by its height: leaves have height 1.
    pub(super) fn box_of(&self, height: usize, node: usize) -> Aabb {
        self.levels[height - 1][node].whole()
    }

    /// Updates the hierarchy to boxes that have changed, in ascending order.
    pub fn refit(&mut self, changed: &[usize], aabb: impl Fn(usize) -> Aabb) {
        let mut changed: Vec<(usize, Aabb)> = changed.iter().map(|&i| (i, aabb(i))).collect();
        for nodes in &mut self.levels {
            changed.iter().for_each(|(i, aabb)| nodes[i / WIDTH].set(i % WIDTH, aabb));
            changed.dedup_by_key(|(i, _)| *i / WIDTH);
            changed.iter_mut().for_each(|(i, aabb)| {
                *i /= WIDTH;
                *aabb = nodes[*i].whole();
            });
        }
    }

    /// The leaf nodes.
    pub(super) fn leaves(&self) -> &[Aabbx4] {
        &self.levels[0]
    }

    /// Passes boxes that intersect `aabb` to `sink` as long as it returns true; whether it always did.
    pub fn visit_while(&self, aabb: &Aabb, sink: &mut impl FnMut(usize) -> bool) -> bool {
        let query = Aabbx4::splat(aabb);
        self.visit_leaves(aabb, &mut |leaf| {
            bits(self.levels[0][leaf].intersecting(&query)).all(|i| sink(WIDTH * leaf + i))
        })
    }

    /// Passes the leaf nodes that intersect `aabb` to `sink` as long as it returns true; whether it always did.
    pub(super) fn visit_leaves(&self, aabb: &Aabb, sink: &mut impl FnMut(usize) -> bool) -> bool {
        self.visit_below(self.levels.len() - 1, 0, &Aabbx4::splat(aabb), sink)
    }

    fn visit_below(&self, level: usize, node: usize, query: &Aabbx4, sink: &mut impl FnMut(usize) -> bool) -> bool {
        if level == 0 {
            return sink(node);
        }
        bits(self.levels[level][node].intersecting(query))
            .all(|i| self.visit_below(level - 1, WIDTH * node + i, query, sink))
    }
}

/// The nodes over `count` boxes, at least one.
fn nodes(count: usize, aabb: impl Fn(usize) -> Aabb + Sync) -> Vec<Aabbx4> {
    let node = |number: usize| {
        let (mut node, first) = (Aabbx4::EMPTY, WIDTH * number);
        (first..count.min(first + WIDTH)).for_each(|i| node.set(i - first, &aabb(i)));
        node
    };
    let numbers = (0..count.div_ceil(WIDTH).max(1)).into_par_iter();
    numbers.with_min_len(NODES_BUILT_PER_TASK).map(node).collect()
}

/// The bits of a number, each followed by two zeros.
fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00FF;
    let x = (x | x << 8) & 0x0300_F00F;
    let x = (x | x << 4) & 0x030C_30C3;
    (x | x << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use super::super::pairs::{Pairs, WorkLimit};
    use super::*;

    fn intersect(a: &Aabb, b: &Aabb) -> bool {
        a.low.cmple(b.high).all() && b.low.cmple(a.high).all()
    }

    fn scattered(count: usize) -> Vec<Aabb> {
        let at = |i: usize| Vec3A::new((i * 7 % 13) as f32, (i * 5 % 11) as f32, (i % 3) as f32);
        (0..count).map(|i| Aabb { low: at(i), high: at(i) + 1.5 }).collect()
    }

    #[test]
    fn a_point_far_away_does_not_mix_up_the_others() {
        let mut points: Vec<Vec3A> = (0..900).map(|i| Vec3A::new((i * 7 % 30) as f32, (i / 30) as f32, 0.0)).collect();
        let sorted = morton_sorted(&points);
        points.push(Vec3A::splat(1e6));
        assert_eq!(morton_sorted(&points)[..900], sorted);
    }

    #[test]
    fn all_that_intersect_are_found() {
        let boxes = scattered(101);
        let tree = Bvh::new(boxes.len(), |i| boxes[i]);
        for b in &boxes {
            let mut found = Vec::new();
            tree.visit_while(b, &mut |i| {
                found.push(i);
                true
            });
            found.sort_unstable();
            assert!(found.into_iter().eq((0..boxes.len()).filter(|&i| intersect(&boxes[i], b))));
        }
    }

    fn has_all_pairs(tree: &Bvh, boxes: &[Aabb]) {
        let is_active = |i: usize| i % 4 == 1;
        let is_wanted = |i: usize, j: usize| (i + j).is_multiple_of(2);
        let active: Vec<usize> = (0..boxes.len()).filter(|&i| is_active(i)).collect();
        let Pairs { mut found, crowded } = tree.pairs(&active, is_wanted, |_, _| true, &WorkLimit::default());
        found.sort_unstable();
        assert!(crowded.is_empty());
        let all = (0..boxes.len()).flat_map(|i| (i..boxes.len()).map(move |j| [i, j]));
        let expected =
            |&[i, j]: &[usize; 2]| is_wanted(i, j) && (is_active(i) || is_active(j)) && intersect(&boxes[i], &boxes[j]);
        assert!(found.into_iter().eq(all.filter(expected)));
    }

    #[test]
    fn all_intersecting_pairs_with_an_active_box_are_found_once() {
        for count in [0, 1, 3, 5, 101] {
            let boxes = scattered(count);
            has_all_pairs(&Bvh::new(count, |i| boxes[i]), &boxes);
        }
    }

    #[test]
    fn a_tree_can_be_refitted_to_boxes_that_have_moved() {
        let mut boxes = scattered(101);
        let mut tree = Bvh::new(boxes.len(), |i| boxes[i]);
        let moved = [0, 17, 18, 63, 100];
        moved.iter().for_each(|&i| boxes[i].high += 4.0);
        tree.refit(&moved, |i| boxes[i]);
        has_all_pairs(&tree, &boxes);
    }
}
