//! Boxes around faces in a tree, to find those that may touch.

use crate::mesh::{FaceId, IdVec};
use glam::{Vec3, Vec3A};
use rayon::prelude::*;

/// Faces of a leaf. More makes fewer nodes and more boxes to compare.
const LEAF: usize = 4;
/// Pairs of nodes among which a search is parted.
const PARTS: usize = 256;
/// Bits of a place in each direction by which faces are ordered.
const BITS: u32 = 10;

/// A box along the axes.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// Least corner.
    pub low: Vec3A,
    /// Largest corner.
    pub high: Vec3A,
}

impl Bounds {
    /// The box of nothing.
    pub const EMPTY: Self = Self { low: Vec3A::MAX, high: Vec3A::MIN };

    /// The box of points.
    pub fn of(points: &[Vec3]) -> Self {
        points.iter().map(|&p| Vec3A::from(p)).fold(Self::EMPTY, |b, p| Self { low: b.low.min(p), high: b.high.max(p) })
    }

    /// Whether two boxes have a place in common.
    #[inline]
    pub fn meets(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }

    /// The box of what is in both.
    pub fn common(&self, other: &Self) -> Self {
        Self { low: self.low.max(other.low), high: self.high.min(other.high) }
    }

    /// The box with all that is within a distance of it.
    pub fn grown(&self, by: f32) -> Self {
        Self { low: self.low - by, high: self.high + by }
    }

    /// The box of two.
    pub fn and(&self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }
}

/// A complete binary tree over faces in an order in which neighbours are near.
pub struct Tree {
    order: Vec<FaceId>,
    /// The boxes of the faces in that order.
    boxes: Vec<Bounds>,
    /// The root is 1, the children of `i` are `2 i` and `2 i + 1`.
    nodes: Vec<Bounds>,
    leaves: usize,
}

impl Tree {
    /// The tree of faces with their boxes.
    pub fn new(boxes: &IdVec<FaceId, Bounds>) -> Self {
        let all = boxes.iter().fold(Bounds::EMPTY, |a, b| a.and(b));
        let scale = ((1u32 << BITS) - 1) as f32 / (all.high - all.low).max_element().max(f32::MIN_POSITIVE);
        let code = |b: &Bounds| {
            let cell = ((0.5 * (b.low + b.high) - all.low) * scale).as_uvec3();
            spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2
        };
        let mut keys: Vec<(u32, FaceId)> = boxes.enumerated().map(|(f, b)| (code(b), f)).collect();
        keys.par_sort_unstable_by_key(|&(code, face)| (code, face.index()));
        let leaves = keys.len().div_ceil(LEAF).next_power_of_two();
        let order = keys.into_iter().map(|(_, face)| face).collect();
        let (of_faces, nodes) = (vec![Bounds::EMPTY; boxes.len()], vec![Bounds::EMPTY; 2 * leaves]);
        let mut tree = Self { order, boxes: of_faces, nodes, leaves };
        tree.refit(boxes);
        tree
    }

    /// Fits the nodes to boxes that have changed.
    pub fn refit(&mut self, boxes: &IdVec<FaceId, Bounds>) {
        self.boxes.iter_mut().zip(&self.order).for_each(|(own, &face)| *own = boxes[face]);
        for (leaf, boxes) in self.boxes.chunks(LEAF).enumerate() {
            self.nodes[self.leaves + leaf] = boxes.iter().fold(Bounds::EMPTY, |all, b| all.and(b));
        }
        for node in (1..self.leaves).rev() {
            self.nodes[node] = self.nodes[2 * node].and(&self.nodes[2 * node + 1]);
        }
    }

    /// The faces of a leaf with their boxes.
    fn leaf(&self, node: usize) -> impl Iterator<Item = (FaceId, &Bounds)> {
        let first = LEAF * (node - self.leaves);
        let faces = first.min(self.order.len())..(first + LEAF).min(self.order.len());
        self.order[faces.clone()].iter().copied().zip(&self.boxes[faces])
    }

    /// The pairs of faces that pass a test, the first not after the second, of all whose boxes meet and of which one is
    /// active. `S` is what the test keeps from one pair to the next.
    pub fn pairs<S: Default>(
        &self,
        is_active: &IdVec<FaceId, bool>,
        test: impl Fn(FaceId, FaceId, &mut S) -> bool + Sync,
    ) -> Vec<[FaceId; 2]> {
        let search = Search { tree: self, is_active, has_active: self.nodes_with(is_active), test };
        let mut parts = vec![[1, 1]];
        while parts.len() < PARTS && parts.iter().any(|[node, _]| *node < self.leaves) {
            parts = parts.iter().flat_map(|&pair| search.below(pair)).collect();
        }
        let found = |&pair: &[usize; 2]| {
            let (mut found, mut state) = (Vec::new(), S::default());
            search.descend(pair, &mut state, &mut found);
            found
        };
        parts.par_iter().flat_map_iter(found).collect()
    }

    /// Which nodes have an active face.
    fn nodes_with(&self, is_active: &IdVec<FaceId, bool>) -> Vec<bool> {
        let mut nodes = vec![false; self.nodes.len()];
        for (leaf, faces) in self.order.chunks(LEAF).enumerate() {
            nodes[self.leaves + leaf] = faces.iter().any(|&face| is_active[face]);
        }
        (1..self.leaves).rev().for_each(|node| nodes[node] = nodes[2 * node] || nodes[2 * node + 1]);
        nodes
    }

    /// Passes each face whose box meets `bounds` to `sink`, with its box.
    pub fn visit(&self, bounds: &Bounds, sink: &mut impl FnMut(FaceId, &Bounds)) {
        let mut stack = [0usize; 64];
        let mut depth = usize::from(self.nodes[1].meets(bounds));
        stack[0] = 1;
        while depth > 0 {
            depth -= 1;
            let node = stack[depth];
            if node >= self.leaves {
                self.leaf(node).filter(|(_, b)| b.meets(bounds)).for_each(|(f, b)| sink(f, b));
                continue;
            }
            for child in [2 * node + 1, 2 * node] {
                if self.nodes[child].meets(bounds) {
                    stack[depth] = child;
                    depth += 1;
                }
            }
        }
    }
}

/// A search for pairs, from pairs of nodes of a depth to those below them.
struct Search<'a, T> {
    tree: &'a Tree,
    is_active: &'a IdVec<FaceId, bool>,
    has_active: Vec<bool>,
    test: T,
}

impl<T> Search<'_, T> {
    fn is_asked(&self, [a, b]: [usize; 2]) -> bool {
        (self.has_active[a] || self.has_active[b]) && self.tree.nodes[a].meets(&self.tree.nodes[b])
    }

    /// The pairs of children that may have what is looked for, of nodes that are no leaves.
    fn below(&self, [a, b]: [usize; 2]) -> impl Iterator<Item = [usize; 2]> {
        let (left, right) = (2 * a, 2 * b);
        let all = [[left, right], [left, right + 1], [left + 1, right], [left + 1, right + 1]];
        // A node with itself has one pair of its two children.
        let pairs = all.into_iter().enumerate().filter(move |(i, _)| a != b || *i != 2).map(|(_, pair)| pair);
        pairs.filter(|&pair| self.is_asked(pair))
    }

    fn descend<S>(&self, pair: [usize; 2], state: &mut S, found: &mut Vec<[FaceId; 2]>)
    where
        T: Fn(FaceId, FaceId, &mut S) -> bool,
    {
        if pair[0] < self.tree.leaves {
            self.below(pair).for_each(|pair| self.descend(pair, state, found));
            return;
        }
        let b = &self.tree.nodes[pair[1]];
        for (i, (f, of_f)) in self.tree.leaf(pair[0]).enumerate().filter(|(_, (_, of_f))| of_f.meets(b)) {
            let first = if pair[0] == pair[1] { i } else { 0 };
            for (g, of_g) in self.tree.leaf(pair[1]).skip(first) {
                let is_asked = of_f.meets(of_g) && (self.is_active[f] || self.is_active[g]);
                let ordered = if f <= g { [f, g] } else { [g, f] };
                if is_asked && (self.test)(ordered[0], ordered[1], state) {
                    found.push(ordered);
                }
            }
        }
    }
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
    use super::*;

    fn scattered(count: usize) -> IdVec<FaceId, Bounds> {
        let at = |i: usize| Vec3::new((i * 7 % 13) as f32, (i * 5 % 11) as f32, (i % 3) as f32);
        (0..count).map(|i| Bounds::of(&[at(i), at(i) + 1.5])).collect()
    }

    #[test]
    fn all_that_meet_are_found() {
        let boxes = scattered(101);
        let tree = Tree::new(&boxes);
        for b in boxes.iter() {
            let mut found = Vec::new();
            tree.visit(b, &mut |f, _| found.push(f));
            found.sort_unstable();
            let expected: Vec<FaceId> = boxes.ids().filter(|&f| boxes[f].meets(b)).collect();
            assert_eq!(found, expected);
        }
    }

    #[test]
    fn all_pairs_that_meet_and_have_an_active_one_are_found_once() {
        for count in [0, 1, 3, 5, 101] {
            let boxes = scattered(count);
            let is_active: IdVec<FaceId, bool> = (0..count).map(|i| i % 4 == 1).collect();
            let is_even = |f: FaceId, g: FaceId, _: &mut ()| (f.index() + g.index()).is_multiple_of(2);
            let mut found = Tree::new(&boxes).pairs(&is_active, is_even);
            found.sort_unstable();
            let all = boxes.ids().flat_map(|f| boxes.ids().map(move |g| [f, g]));
            let expected = |&[f, g]: &[FaceId; 2]| {
                f <= g && is_even(f, g, &mut ()) && (is_active[f] || is_active[g]) && boxes[f].meets(&boxes[g])
            };
            assert_eq!(found, all.filter(expected).collect::<Vec<_>>());
        }
    }
}
