//! The pairs of boxes that meet, in time that a crowd of boxes in one place does not multiply.
//!
//! A box that meets very many others is *crowded*. It is searched for from the others, each of which meets few, so that only
//! pairs of two crowded boxes are left. Those are not tested: their boxes are returned, to be treated as in contact.

use super::bvh::{Aabb, Bvh};
use super::simd::{Aabbx4, Mask, WIDTH, bits};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use tailor_mesh::meter;

/// Leaf nodes that one task searches.
const NODES_PER_TASK: usize = 16;
/// Boxes that one task searches for among crowded ones.
const BOXES_PER_TASK: usize = 256;
/// Boxes that a box which is not crowded meets at most. Neighbours at a pole meet each other, and few of them are near.
const MOST_MET: usize = 4096;
/// Boxes that a box which is not crowded is near, by the cheap test, at most.
const MOST_NEAR: usize = 256;

/// The work of a test of two faces with their children, in cheap tests of two boxes that meet.
pub const TEST: usize = 16;

/// A bound on the work of searches for contacts, and the work so far. A search that passes the bound ends early, and its
/// result is incomplete. Whether it passes the bound does not depend on the number of threads. \[cheap tests of two boxes\]
pub struct WorkLimit {
    most: usize,
    spent: AtomicUsize,
}

impl WorkLimit {
    /// A bound of so much work.
    pub fn new(most: usize) -> Self {
        Self { most, spent: AtomicUsize::new(0) }
    }

    /// Adds work that is about to be done; false beyond the bound, where it is to be left undone.
    pub fn take(&self, work: usize) -> bool {
        self.spent.fetch_add(work, Ordering::Relaxed).saturating_add(work) <= self.most
    }

    /// The work that is left.
    pub fn left(&self) -> usize {
        self.most.saturating_sub(self.spent())
    }

    /// The work so far, with that which was left undone.
    pub fn spent(&self) -> usize {
        self.spent.load(Ordering::Relaxed)
    }

    /// Whether some work was left undone.
    pub fn is_over(&self) -> bool {
        self.spent() > self.most
    }
}

impl Default for WorkLimit {
    /// Without a bound.
    fn default() -> Self {
        Self::new(usize::MAX)
    }
}

/// Pairs of boxes.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Pairs {
    /// Pairs `[i, j]`, `i <= j`, that pass the test.
    pub found: Vec<[usize; 2]>,
    /// Active boxes that meet others which they were not tested against, ascending.
    pub crowded: Vec<usize>,
}

/// How many boxes one box has met.
#[derive(Clone, Copy, Default)]
struct Count {
    met: usize,
    near: usize,
}

impl Count {
    fn is_over(self) -> bool {
        self.met > MOST_MET || self.near > MOST_NEAR
    }
}

/// A search among boxes.
struct Search<'a, N, T> {
    tree: &'a Bvh,
    /// The active boxes of each leaf node.
    is_active: Vec<Mask>,
    /// Whether two boxes that meet are near, by a cheap test.
    is_near: N,
    test: T,
    work: &'a WorkLimit,
}

impl Bvh {
    /// The pairs of boxes that meet, that are near, that pass a test, and of which at least one is active. `is_near` is cheap, and
    /// takes two boxes in either order. The pairs are incomplete beyond the bound of `work`.
    pub fn pairs(
        &self,
        active: &[usize],
        is_near: impl Fn(usize, usize) -> bool + Sync,
        test: impl Fn(usize, usize) -> bool + Sync,
        work: &WorkLimit,
    ) -> Pairs {
        let mut is_active: Vec<Mask> = vec![0; self.leaves().len()];
        active.iter().for_each(|&i| is_active[i / WIDTH] |= 1 << (i % WIDTH));
        let search = Search { tree: self, is_active, is_near, test, work };
        let mut pairs = search.of_active();
        if !pairs.crowded.is_empty() {
            search.complete(&mut pairs);
        }
        pairs
    }
}

impl<N: Fn(usize, usize) -> bool + Sync, T: Fn(usize, usize) -> bool + Sync> Search<'_, N, T> {
    /// The pairs of active boxes that are not crowded, and those that are.
    fn of_active(&self) -> Pairs {
        let searched: Vec<usize> = (0..self.is_active.len()).filter(|&leaf| self.is_active[leaf] != 0).collect();
        let of_task = |leaves: &[usize]| {
            let (mut pairs, mut near) = (Pairs::default(), Vec::new());
            leaves.iter().for_each(|&leaf| self.of_leaf(leaf, &mut near, &mut pairs));
            pairs
        };
        let tasks: Vec<Pairs> = searched.par_chunks(NODES_PER_TASK).map(of_task).collect();
        joined(tasks)
    }

    /// Adds the pairs of the active boxes of a leaf node. `near` is scratch memory.
    fn of_leaf(&self, a: usize, near: &mut Vec<[usize; 2]>, pairs: &mut Pairs) {
        meter::check();
        if self.work.is_over() {
            return;
        }
        let (of_a, active) = (&self.tree.leaves()[a], self.is_active[a]);
        let all = bits(active).fold(Aabb::EMPTY, |all, i| all.merged(&of_a.at(i)));
        let (mut counts, mut open) = ([Count::default(); WIDTH], active);
        near.clear();
        self.tree.visit_leaves(&all, &mut |b| {
            for i in bits(open) {
                // A pair of active boxes is found from the first of them.
                let found_before = self.is_active[b] & before(WIDTH * a + i, b);
                let met = self.tree.leaves()[b].intersecting(&Aabbx4::splat(&of_a.at(i))) & !found_before;
                let first = near.len();
                let all = bits(met).map(|j| [WIDTH * a + i, WIDTH * b + j]);
                near.extend(all.filter(|&[i, j]| (self.is_near)(i, j)));
                counts[i].met += met.count_ones() as usize;
                counts[i].near += near.len() - first;
                open &= !(Mask::from(counts[i].is_over()) << i);
            }
            open != 0
        });
        pairs.crowded.extend(bits(active & !open).map(|i| WIDTH * a + i));
        near.retain(|[i, _]| open & 1 << (i % WIDTH) != 0);
        if !self.work.take(counts.iter().map(|count| count.met).sum::<usize>() + TEST * near.len()) {
            return;
        }
        let kept = near.iter().filter(|[i, j]| (self.test)(*i, *j));
        pairs.found.extend(kept.map(|&[i, j]| [i.min(j), i.max(j)]));
    }

    /// Adds the pairs of crowded boxes with others, and leaves those crowded that meet one another.
    fn complete(&self, pairs: &mut Pairs) {
        let mut crowded = std::mem::take(&mut pairs.crowded);
        let tree = self.among(&crowded);
        let others: Vec<usize> =
            (0..WIDTH * self.is_active.len()).filter(|i| crowded.binary_search(i).is_err()).collect();
        let of_task = |others: &[usize]| {
            let mut pairs = Pairs::default();
            for &i in others {
                if self.work.is_over() {
                    break;
                }
                // An active box has found the boxes after it already.
                let is_new = |&j: &usize| !self.is_active(i) || j < i;
                match self.near_among(&tree, &crowded, i, is_new) {
                    Some(near) if !self.work.take(TEST * near.len()) => break,
                    Some(near) => {
                        let passed = near.into_iter().filter(|&j| (self.test)(i, j));
                        pairs.found.extend(passed.map(|j| [i.min(j), i.max(j)]));
                    }
                    None => pairs.crowded.push(i),
                }
            }
            pairs
        };
        let added = joined(others.par_chunks(BOXES_PER_TASK).map(of_task).collect());
        pairs.found.extend(added.found);
        crowded.extend(added.crowded);
        crowded.sort_unstable();
        let tree = self.among(&crowded);
        let meets_crowded = |&i: &usize| self.has_near_among(&tree, &crowded, i);
        let active: Vec<usize> = crowded.iter().copied().filter(|&i| self.is_active(i)).collect();
        let (left, alone): (Vec<usize>, Vec<usize>) = active.par_iter().copied().partition(meets_crowded);
        let crosses_itself = |&i: &usize| (self.is_near)(i, i) && (self.test)(i, i);
        pairs.found.extend(alone.into_iter().filter(crosses_itself).map(|i| [i, i]));
        pairs.crowded = left;
    }

    /// The hierarchy of some boxes, ascending.
    fn among(&self, boxes: &[usize]) -> Bvh {
        Bvh::new(boxes.len(), |k| self.aabb(boxes[k]))
    }

    /// The boxes of `boxes` that box `i` is near, of those that `is_asked` admits; none if box `i` is crowded. `tree` is the
    /// hierarchy of `boxes`.
    fn near_among(
        &self,
        tree: &Bvh,
        boxes: &[usize],
        i: usize,
        is_asked: impl Fn(&usize) -> bool,
    ) -> Option<Vec<usize>> {
        let (mut count, mut near) = (Count::default(), Vec::new());
        let is_whole = tree.visit_while(&self.aabb(i), &mut |k| {
            let j = boxes[k];
            if is_asked(&j) {
                count.met += 1;
                if (self.is_near)(i, j) {
                    near.push(j);
                    count.near += 1;
                }
            }
            !count.is_over()
        });
        self.work.take(count.met);
        is_whole.then_some(near)
    }

    /// Whether a box is near another of `boxes`, in a hierarchy, or meets too many of them to tell.
    fn has_near_among(&self, tree: &Bvh, boxes: &[usize], i: usize) -> bool {
        if self.work.is_over() {
            return true;
        }
        let mut met = 0;
        let has_near = !tree.visit_while(&self.aabb(i), &mut |k| {
            met += 1;
            boxes[k] == i || met <= MOST_MET && !(self.is_near)(i, boxes[k])
        });
        self.work.take(met);
        has_near
    }

    fn aabb(&self, i: usize) -> Aabb {
        self.tree.leaves()[i / WIDTH].at(i % WIDTH)
    }

    fn is_active(&self, i: usize) -> bool {
        self.is_active[i / WIDTH] & 1 << (i % WIDTH) != 0
    }
}

fn joined(tasks: Vec<Pairs>) -> Pairs {
    let mut all = Pairs::default();
    for of_task in tasks {
        all.found.extend(of_task.found);
        all.crowded.extend(of_task.crowded);
    }
    all
}

/// The elements of a leaf that come before box `i`.
fn before(i: usize, leaf: usize) -> Mask {
    (1 << i.saturating_sub(WIDTH * leaf).min(WIDTH)) - 1
}

#[cfg(test)]
mod tests {
    use super::super::bvh::morton_sorted;
    use super::*;
    use glam::Vec3A;

    /// Boxes in the order of a hierarchy.
    fn ordered(boxes: &[Aabb]) -> Vec<Aabb> {
        let centres: Vec<Vec3A> = boxes.iter().map(|b| 0.5 * (b.low + b.high)).collect();
        morton_sorted(&centres).into_iter().map(|i| boxes[i]).collect()
    }

    /// The boxes of the faces of a sheet whose points are moved.
    fn sheet(n: usize, moved: impl Fn(usize, Vec3A) -> Vec3A) -> Vec<Aabb> {
        let at = |x: usize, y: usize| moved(y * (n + 1) + x, Vec3A::new(x as f32, y as f32, 0.0));
        let face = |x: usize, y: usize| {
            let corners = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
            Aabb::of(corners.iter().copied())
        };
        ordered(&(0..n * n).map(|i| face(i % n, i / n)).collect::<Vec<_>>())
    }

    fn random(i: usize) -> Vec3A {
        let hash = |seed: usize| ((i * 4 + seed).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40) as f32 / (1 << 24) as f32;
        Vec3A::new(hash(1), hash(2), hash(3))
    }

    /// The pairs of all boxes, and the tests that they took, cheap and costly.
    fn searched(boxes: &[Aabb]) -> (Pairs, [usize; 2]) {
        let tests = [0; 2].map(AtomicUsize::new);
        let all: Vec<usize> = (0..boxes.len()).collect();
        let counted = |kind: usize| {
            let tests = &tests;
            move |_, _| tests[kind].fetch_add(1, Ordering::Relaxed) < usize::MAX
        };
        let pairs = Bvh::new(boxes.len(), |i| boxes[i]).pairs(&all, counted(0), counted(1), &WorkLimit::default());
        (pairs, tests.map(AtomicUsize::into_inner))
    }

    fn meet(a: &Aabb, b: &Aabb) -> bool {
        a.low.cmple(b.high).all() && b.low.cmple(a.high).all()
    }

    #[test]
    fn tests_grow_as_the_boxes_do_where_crowds_lie_in_one_place() {
        let half = |n: usize| move |i: usize, p: Vec3A| if i % (n + 1) <= n / 2 { Vec3A::ONE } else { p };
        let jittered = |n: usize| move |i: usize, p: Vec3A| half(n)(i, p) + 1e-4 * random(i);
        let crumpled = |n: usize| move |i: usize, _: Vec3A| 1e-3 * n as f32 * random(i);
        type Sheet<'a> = &'a dyn Fn(usize) -> Vec<Aabb>;
        let cases: [(&str, Sheet); 5] = [
            ("flat", &|n| sheet(n, |_, p| p)),
            ("coincident", &|n| sheet(n, |_, _| Vec3A::ONE)),
            ("half in one point", &|n| sheet(n, half(n))),
            ("half nearly in one point", &|n| sheet(n, jittered(n))),
            ("crumpled", &|n| sheet(n, crumpled(n))),
        ];
        for (name, boxes) in cases {
            let [small, large] = [48, 96].map(|n| searched(&boxes(n)).1);
            for (small, large) in small.into_iter().zip(large) {
                assert!(large as f64 <= 4.0 * 1.4 * small.max(4 * 48 * 48) as f64, "{name}: {small} grow to {large}");
            }
            assert!(large[1] <= MOST_NEAR * 96 * 96, "{name}: {large:?}");
        }
    }

    #[test]
    fn a_search_ends_at_its_bound_of_work() {
        let boxes = sheet(48, |i, _| 0.048 * random(i));
        let all: Vec<usize> = (0..boxes.len()).collect();
        let tree = Bvh::new(boxes.len(), |i| boxes[i]);
        let search = |most: usize, threads: usize| {
            let (tests, work) = (AtomicUsize::new(0), WorkLimit::new(most));
            let count = |_, _| tests.fetch_add(1, Ordering::Relaxed) < usize::MAX;
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| tree.pairs(&all, |_, _| true, count, &work));
            (tests.into_inner(), work)
        };
        let whole = search(usize::MAX, 1).1.spent();
        for threads in [1, 4] {
            for most in [whole / 100, whole / 3, whole - 1] {
                let (tests, work) = search(most, threads);
                assert!(work.is_over() && TEST * tests <= most, "{tests} tests of {most} with {threads}");
            }
            assert!(!search(whole, threads).1.is_over());
        }
    }

    #[test]
    fn a_pair_is_tested_unless_both_of_it_are_told() {
        // A crowd, what is around it, and a sheet with one large box over all of it.
        let crowd = (0..700).map(|i| Aabb { low: 0.2 * random(i), high: 0.2 * random(i) + 1.0 });
        let around = (0..300).map(|i| Aabb { low: 4.0 * random(i), high: 4.0 * random(i) + 0.3 });
        let sheet = (0..900).map(|i| Vec3A::new((i % 30) as f32 + 9.0, (i / 30) as f32, 0.0));
        let sheet = sheet.map(|low| Aabb { low, high: low + 1.0 });
        let large = Aabb { low: Vec3A::new(9.0, 0.0, -1.0), high: Vec3A::new(39.0, 30.0, 1.0) };
        let boxes = ordered(&crowd.chain(around).chain(sheet).chain([large]).collect::<Vec<_>>());
        let tree = Bvh::new(boxes.len(), |i| boxes[i]);
        let large = boxes.iter().position(|b| b.high.x == 39.0).expect("it is there");
        for step in [1, 3] {
            let active: Vec<usize> = (0..boxes.len()).filter(|&i| i % step == 0 || i == large).collect();
            let is_active = |i: usize| active.binary_search(&i).is_ok();
            let is_near = |i: usize, j: usize| (i + j) % 8 != 7;
            let Pairs { mut found, crowded } = tree.pairs(&active, is_near, |_, _| true, &WorkLimit::default());
            found.sort_unstable();
            assert!(found.windows(2).all(|pair| pair[0] != pair[1]), "each once");
            assert!(crowded.len() > 150 && crowded.iter().all(|&i| is_active(i) && boxes[i].high.x < 2.0));
            let is_told = |i: usize| crowded.binary_search(&i).is_ok();
            for i in 0..boxes.len() {
                for j in (i..boxes.len()).filter(|&j| is_near(i, j) && meet(&boxes[i], &boxes[j])) {
                    let is_asked = is_active(i) || is_active(j);
                    let is_found = found.binary_search(&[i, j]).is_ok();
                    assert!(is_asked || !is_found);
                    assert!(!is_asked || is_found || is_told(i) || is_told(j), "{i} and {j} of {step}");
                }
            }
        }
    }
}
