//! Boxes around faces in a tree, to find those that may touch.

use super::lanes::{Boxes, Lanes, each};
use crate::mesh::{FaceId, Faces, IdVec, VertexId};
use glam::{Vec3, Vec3A};
use rayon::prelude::*;

/// Boxes of a group.
const WIDTH: usize = 4;
/// Groups that are searched in one go.
const PART: usize = 16;
/// Bits of a centre in each direction by which faces are ordered.
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
    pub const EMPTY: Self = Self { low: Vec3A::INFINITY, high: Vec3A::NEG_INFINITY };

    /// The box of what is in both.
    pub fn common(&self, other: &Self) -> Self {
        Self { low: self.low.max(other.low), high: self.high.min(other.high) }
    }

    /// The box with all that is within a distance of it.
    pub fn grown(&self, by: f32) -> Self {
        Self { low: self.low - by, high: self.high + by }
    }

    /// The box with where a move takes it.
    pub fn swept(&self, by: Vec3) -> Self {
        let by = Vec3A::from(by);
        self.and(&Self { low: self.low + by, high: self.high + by })
    }

    /// The box of two.
    pub fn and(&self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }
}

/// The faces of a mesh in an order in which neighbours are near: along a curve that fills space.
pub fn order(faces: &Faces, points: &IdVec<VertexId, Vec3>) -> Vec<FaceId> {
    let centre = |face: FaceId| {
        let vertices = faces.vertices_of(face);
        vertices.iter().map(|&v| Vec3A::from(points[v])).sum::<Vec3A>() / vertices.len() as f32
    };
    let centres: Vec<Vec3A> = (0..faces.len()).into_par_iter().map(|face| centre(FaceId::new(face))).collect();
    let all = centres.iter().fold(Bounds::EMPTY, |b, &p| Bounds { low: b.low.min(p), high: b.high.max(p) });
    let scale = ((1u32 << BITS) - 1) as f32 / (all.high - all.low).max_element().max(f32::MIN_POSITIVE);
    let code = |&p: &Vec3A| {
        let cell = ((p - all.low) * scale).as_uvec3();
        spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2
    };
    let mut keys: Vec<(u32, FaceId)> =
        centres.par_iter().map(code).enumerate().map(|(face, code)| (code, FaceId::new(face))).collect();
    keys.par_sort_unstable();
    keys.into_iter().map(|(_, face)| face).collect()
}

/// A tree over boxes in an order in which neighbours are near: each of its groups has the boxes of four groups below.
pub struct Tree {
    /// Groups of each level, from the boxes up to a single group.
    levels: Vec<Vec<Boxes>>,
}

impl Tree {
    /// The tree of so many boxes.
    pub fn new(count: usize, bounds: impl Fn(usize) -> Bounds + Sync) -> Self {
        let mut levels = vec![groups(count, bounds)];
        while let Some(below) = levels.last().filter(|groups| groups.len() > 1) {
            levels.push(groups(below.len(), |group| below[group].whole()));
        }
        Self { levels }
    }

    /// Fits it to boxes that have changed, given in their order.
    pub fn refit(&mut self, changed: &[usize], bounds: impl Fn(usize) -> Bounds) {
        let mut changed: Vec<(usize, Bounds)> = changed.iter().map(|&place| (place, bounds(place))).collect();
        for groups in &mut self.levels {
            changed.iter().for_each(|(place, bounds)| groups[place / WIDTH].set(place % WIDTH, bounds));
            changed.dedup_by_key(|(place, _)| *place / WIDTH);
            changed.iter_mut().for_each(|(place, bounds)| {
                *place /= WIDTH;
                *bounds = groups[*place].whole();
            });
        }
    }

    /// The pairs of places that pass a test, the first not after the second, of all whose boxes meet and of which one is
    /// active.
    pub fn pairs(&self, active: &[usize], test: impl Fn(usize, usize) -> bool + Sync) -> Vec<[usize; 2]> {
        let lowest = &self.levels[0];
        let mut lanes: Vec<Lanes> = vec![0; lowest.len()];
        active.iter().for_each(|&place| lanes[place / WIDTH] |= 1 << (place % WIDTH));
        let of_group = |found: &mut Vec<[usize; 2]>, a: usize| {
            let of_a = &lowest[a];
            let all = each(lanes[a]).fold(Bounds::EMPTY, |all, i| all.and(&of_a.at(i)));
            self.visit_groups(&all, &mut |b| {
                for i in each(lanes[a]) {
                    // Two that are active are found from the first one.
                    let found_before = lanes[b] & lanes_before(WIDTH * a + i, b);
                    let near = lowest[b].that_meet(&Boxes::splat(&of_a.at(i))) & !found_before;
                    let places = each(near).map(|j| [WIDTH * a + i, WIDTH * b + j]);
                    found.extend(places.filter(|&[i, j]| test(i, j)).map(|[i, j]| [i.min(j), i.max(j)]));
                }
            });
        };
        let of_part = |groups: &[usize]| {
            let mut found = Vec::new();
            groups.iter().for_each(|&group| of_group(&mut found, group));
            found
        };
        let searched: Vec<usize> = (0..lowest.len()).filter(|&group| lanes[group] != 0).collect();
        searched.par_chunks(PART).flat_map_iter(of_part).collect()
    }

    /// Passes each place whose box meets `bounds` to `sink`.
    pub fn visit(&self, bounds: &Bounds, sink: &mut impl FnMut(usize)) {
        let there = Boxes::splat(bounds);
        self.visit_groups(bounds, &mut |group| {
            each(self.levels[0][group].that_meet(&there)).for_each(|lane| sink(WIDTH * group + lane));
        });
    }

    /// Passes each group of boxes whose box meets `bounds` to `sink`.
    fn visit_groups(&self, bounds: &Bounds, sink: &mut impl FnMut(usize)) {
        self.visit_below(self.levels.len() - 1, 0, &Boxes::splat(bounds), sink);
    }

    fn visit_below(&self, level: usize, group: usize, there: &Boxes, sink: &mut impl FnMut(usize)) {
        if level == 0 {
            return sink(group);
        }
        for lane in each(self.levels[level][group].that_meet(there)) {
            self.visit_below(level - 1, WIDTH * group + lane, there, sink);
        }
    }
}

/// The lanes of a group that are before a place.
fn lanes_before(place: usize, group: usize) -> Lanes {
    (1 << place.saturating_sub(WIDTH * group).min(WIDTH)) - 1
}

/// Boxes in groups.
fn groups(count: usize, bounds: impl Fn(usize) -> Bounds + Sync) -> Vec<Boxes> {
    let group = |number: usize| {
        let (mut boxes, first) = (Boxes::EMPTY, WIDTH * number);
        (first..count.min(first + WIDTH)).for_each(|i| boxes.set(i - first, &bounds(i)));
        boxes
    };
    (0..count.div_ceil(WIDTH).max(1)).into_par_iter().with_min_len(PART * PART).map(group).collect()
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

    fn meet(a: &Bounds, b: &Bounds) -> bool {
        a.low.cmple(b.high).all() && b.low.cmple(a.high).all()
    }

    fn scattered(count: usize) -> Vec<Bounds> {
        let at = |i: usize| Vec3A::new((i * 7 % 13) as f32, (i * 5 % 11) as f32, (i % 3) as f32);
        (0..count).map(|i| Bounds { low: at(i), high: at(i) + 1.5 }).collect()
    }

    #[test]
    fn all_that_meet_are_found() {
        let boxes = scattered(101);
        let tree = Tree::new(boxes.len(), |i| boxes[i]);
        for b in &boxes {
            let mut found = Vec::new();
            tree.visit(b, &mut |i| found.push(i));
            found.sort_unstable();
            assert!(found.into_iter().eq((0..boxes.len()).filter(|&i| meet(&boxes[i], b))));
        }
    }

    fn has_all_pairs(tree: &Tree, boxes: &[Bounds]) {
        let is_active = |i: usize| i % 4 == 1;
        let is_even = |i: usize, j: usize| (i + j).is_multiple_of(2);
        let active: Vec<usize> = (0..boxes.len()).filter(|&i| is_active(i)).collect();
        let mut found = tree.pairs(&active, is_even);
        found.sort_unstable();
        let all = (0..boxes.len()).flat_map(|i| (i..boxes.len()).map(move |j| [i, j]));
        let expected =
            |&[i, j]: &[usize; 2]| is_even(i, j) && (is_active(i) || is_active(j)) && meet(&boxes[i], &boxes[j]);
        assert!(found.into_iter().eq(all.filter(expected)));
    }

    #[test]
    fn all_pairs_that_meet_and_have_an_active_one_are_found_once() {
        for count in [0, 1, 3, 5, 101] {
            let boxes = scattered(count);
            has_all_pairs(&Tree::new(count, |i| boxes[i]), &boxes);
        }
    }

    #[test]
    fn a_tree_can_be_fitted_to_what_has_moved() {
        let mut boxes = scattered(101);
        let mut tree = Tree::new(boxes.len(), |i| boxes[i]);
        let moved = [0, 17, 18, 63, 100];
        moved.iter().for_each(|&i| boxes[i].high += 4.0);
        tree.refit(&moved, |i| boxes[i]);
        has_all_pairs(&tree, &boxes);
    }
}
