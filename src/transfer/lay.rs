//! The paths of the runs of one edge set: apart from each other, as far as the mesh has vertices for that.

use super::curve::{Corridor, Found, Scratch};
use super::edge::{Run, Runs};
use super::snap::{Surface, sorted};
use crate::mesh::{Topology, VertexId};
use rustc_hash::FxHashMap;

/// How far from its curve a path may be, in target lengths: wider only where there is no narrower one.
const REACHES: [f32; 4] = [1.0, 1.5, 2.5, 4.0];
/// Times that the paths of a set are found again where some run into others.
const RETRIES: usize = 4;
/// Vertices that are tried for an end of a run that meets another: more hardly help, and take time.
const MAX_ENDS: usize = 6;

/// An end of runs and the vertex that it is to have.
type Move = (VertexId, VertexId);

/// The runs of a set and what was found of them.
pub(super) struct Laid<'a> {
    surface: &'a Surface<'a>,
    topology: &'a Topology,
    pub runs: Runs,
    /// The path of each run.
    pub found: Vec<Option<Found>>,
    /// The vertices within the least reach of each, once they have been looked for.
    corridors: Vec<Option<Corridor>>,
    /// How many runs pass each vertex; the ends that are there are one more, unless it takes several of them.
    passed: FxHashMap<VertexId, u32>,
    /// How many go along each edge whose ends are theirs.
    direct: FxHashMap<[VertexId; 2], u32>,
    /// Runs without a path, or whose path meets another's elsewhere than at an end that both have.
    pub crowded: Vec<usize>,
}

impl<'a> Laid<'a> {
    /// Finds a path for each run. Runs that share an end share its vertex, and keep apart elsewhere as far as they can:
    /// those that run into others are found again before them, or get other ends.
    pub fn new(surface: &'a Surface<'a>, topology: &'a Topology, runs: Runs, scratch: &mut Scratch) -> Self {
        let (is_chained, is_free): (Vec<_>, Vec<_>) =
            runs.snapped.iter().partition(|(end, _)| surface.is_on_chain(**end));
        let of_chains = runs.on_chains.iter().flatten().chain(is_chained.into_iter().map(|(_, vertex)| vertex));
        let mut passed: FxHashMap<VertexId, u32> = of_chains.map(|&v| (v, 1)).collect();
        is_free.into_iter().for_each(|(_, &vertex)| *passed.entry(vertex).or_default() += 1);
        let direct = runs.on_chains.iter().map(|&[a, b]| (sorted(a, b), 1)).collect();
        let found = runs.runs.iter().map(|_| None).collect();
        let corridors = runs.runs.iter().map(|_| None).collect();
        let mut laid = Self { surface, topology, runs, found, corridors, passed, direct, crowded: Vec::new() };
        let all: Vec<usize> = (0..laid.found.len()).collect();
        laid.lay(&all, scratch);
        for _ in 0..RETRIES {
            // Only these, the last first: the others are in nobody's way.
            let again: Vec<usize> = laid.crowded.iter().rev().copied().collect();
            if again.is_empty() || !laid.improves(&again, scratch) {
                break;
            }
        }
        laid.move_ends(scratch);
        laid
    }

    /// Finds the paths of some runs, which have none, in their order.
    fn lay(&mut self, which: &[usize], scratch: &mut Scratch) {
        for &i in which {
            let found = self.path(i, scratch);
            self.put(i, found);
        }
        self.crowded = (0..self.found.len()).filter(|&i| self.is_crowded(i)).collect();
    }

    /// Finds the paths of some runs again. Returns whether fewer run into others then; else all is as it was.
    fn improves(&mut self, again: &[usize], scratch: &mut Scratch) -> bool {
        let before: Vec<Option<Found>> = again.iter().map(|&i| self.take(i)).collect();
        let crowded = self.crowded.clone();
        self.lay(again, scratch);
        if self.crowded.len() < crowded.len() {
            return true;
        }
        again.iter().for_each(|&i| drop(self.take(i)));
        again.iter().zip(before).for_each(|(&i, found)| self.put(i, found));
        self.crowded = crowded;
        false
    }

    fn put(&mut self, i: usize, found: Option<Found>) {
        self.found[i] = found;
        self.count(i, |n| *n += 1);
    }

    fn take(&mut self, i: usize) -> Option<Found> {
        self.count(i, |n| *n -= 1);
        self.found[i].take()
    }

    /// Changes the counts of what a run passes.
    fn count(&mut self, i: usize, change: impl Fn(&mut u32)) {
        let Some(found) = &self.found[i] else { return };
        for &vertex in found.inner(self.runs.runs[i].is_loop) {
            change(self.passed.entry(vertex).or_default());
        }
        if let [a, b] = found.vertices[..] {
            change(self.direct.entry(sorted(a, b)).or_default());
        }
    }

    fn is_crowded(&self, i: usize) -> bool {
        let Some(found) = &self.found[i] else { return true };
        let is_shared = |[a, b]: [VertexId; 2]| self.direct.get(&sorted(a, b)) != Some(&1);
        let meets = found.vertices.iter().any(|v| self.passed.get(v) != Some(&1));
        meets || found.vertices[..].try_into().is_ok_and(is_shared)
    }

    fn is_passed(&self, vertex: VertexId) -> bool {
        self.passed.get(&vertex).is_some_and(|n| *n > 0)
    }

    /// Gives ends other vertices near by, where fewer runs then run into others: the ends of those that still do, and ends
    /// that they run through.
    fn move_ends(&mut self, scratch: &mut Scratch) {
        for i in self.crowded.clone() {
            let ends = self.ends_in_the_way(i);
            let is_done = |laid: &Self| !laid.crowded.contains(&i);
            for &end in &ends {
                let _ = is_done(self) || self.move_end(end, scratch);
            }
            for &end in &ends {
                let _ = is_done(self) || self.swap_end(end, scratch);
            }
        }
    }

    /// The ends of a run, and those of others on its way; none on chains, which have no choice.
    fn ends_in_the_way(&self, i: usize) -> Vec<VertexId> {
        let run = &self.runs.runs[i];
        let own = run.ends().into_iter().filter(|_| !run.is_loop);
        let passed = self.found[i].as_ref().map_or(&[][..], |found| &found.vertices);
        let others = self.runs.snapped.iter().filter(|(_, vertex)| passed.contains(vertex)).map(|(&end, _)| end);
        let mut ends: Vec<VertexId> = Vec::new();
        for end in own.chain(others).filter(|&end| !self.surface.is_on_chain(end)) {
            if !ends.contains(&end) {
                ends.push(end);
            }
        }
        ends
    }

    /// Gives an end the first vertex near by that helps. Returns whether there is one.
    fn move_end(&mut self, end: VertexId, scratch: &mut Scratch) -> bool {
        self.others_near(end).into_iter().any(|vertex| self.try_moves(&[(end, vertex)], scratch))
    }

    /// Gives an end the vertex of another end near by, and that one another. Returns whether that helps.
    fn swap_end(&mut self, end: VertexId, scratch: &mut Scratch) -> bool {
        for vertex in self.others_near(end) {
            let at_vertex =
                self.runs.snapped.iter().find(|(other, v)| **v == vertex && !self.surface.is_on_chain(**other));
            let Some((&other, _)) = at_vertex else { continue };
            if self.others_near(other).into_iter().any(|to| self.try_moves(&[(end, vertex), (other, to)], scratch)) {
                return true;
            }
        }
        false
    }

    /// The vertices near an end, without its own.
    fn others_near(&self, end: VertexId) -> Vec<VertexId> {
        let own = self.runs.snapped.get(&end);
        let near = self.surface.vertices_near(end).into_iter();
        near.filter(|v| Some(v) != own).take(MAX_ENDS).collect()
    }

    /// Gives some ends other vertices that no run passes, if fewer runs then run into others. Returns whether they do.
    fn try_moves(&mut self, moves: &[Move], scratch: &mut Scratch) -> bool {
        let ends_here = |i: &usize| {
            let run: &Run = &self.runs.runs[*i];
            !run.is_loop && run.ends().iter().any(|end| moves.iter().any(|m| m.0 == *end))
        };
        let mut again: Vec<usize> = (0..self.found.len()).filter(ends_here).collect();
        again.extend(self.crowded.iter().filter(|i| !ends_here(i)));
        let back: Vec<Move> = moves.iter().filter_map(|m| Some((m.0, *self.runs.snapped.get(&m.0)?))).collect();
        let before: Vec<Option<Found>> = again.iter().map(|&i| self.take(i)).collect();
        self.snap(&back, moves);
        let is_free = moves.iter().all(|m| self.passed.get(&m.1) == Some(&1));
        let crowded = self.crowded.clone();
        if is_free {
            self.lay(&again, scratch);
            if self.crowded.len() < crowded.len() {
                return true;
            }
            again.iter().for_each(|&i| drop(self.take(i)));
        }
        self.snap(moves, &back);
        again.iter().zip(before).for_each(|(&i, found)| self.put(i, found));
        self.crowded = crowded;
        false
    }

    /// Moves ends from their vertices to others.
    fn snap(&mut self, from: &[Move], to: &[Move]) {
        from.iter().for_each(|m| *self.passed.entry(m.1).or_default() -= 1);
        for &(end, vertex) in to {
            *self.passed.entry(vertex).or_default() += 1;
            self.runs.snapped.insert(end, vertex);
        }
    }

    fn path(&mut self, i: usize, scratch: &mut Scratch) -> Option<Found> {
        let corridor = self.corridors[i].take().unwrap_or_else(|| self.corridor(i, REACHES[0], scratch));
        let (is_loop, ends) = (self.runs.curves[i].is_loop, self.runs.runs[i].ends());
        let ends = ends.map(|end| self.runs.snapped.get(&end).copied());
        let is_taken = |a, b| self.direct.get(&sorted(a, b)).is_some_and(|n| *n > 0);
        let least = if is_loop { 4 } else { 2 };
        // Not along an edge that is another run's, as long as there is another way near by.
        let apart = match ends {
            [Some(a), Some(b)] if !is_loop && is_taken(a, b) => self.path_within(i, &corridor, ends, 3),
            _ => None,
        };
        let near = apart.or_else(|| self.path_within(i, &corridor, ends, least));
        self.corridors[i] = Some(corridor);
        let mut wider = REACHES[1..].iter();
        near.or_else(|| wider.find_map(|&r| self.path_within(i, &self.corridor(i, r, scratch), ends, least)))
    }

    /// The vertices beside a run.
    fn corridor(&self, i: usize, reach: f32, scratch: &mut Scratch) -> Corridor {
        let along = (&self.runs.curves[i], &self.runs.paths[i][..]);
        Corridor::new(self.surface, self.topology, along, reach, scratch)
    }

    /// The best path of a run in a corridor, of at least so many vertices.
    fn path_within(&self, i: usize, beside: &Corridor, ends: [Option<VertexId>; 2], least: usize) -> Option<Found> {
        let passed = beside.passed(|v| self.is_passed(v));
        let ends = match self.runs.runs[i].is_loop {
            true => [beside.nearest(&passed)?; 2],
            false => [ends[0]?, ends[1]?],
        };
        beside.best_path(ends, least, &passed)
    }
}
