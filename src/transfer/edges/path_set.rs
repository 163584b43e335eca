//! The paths of one edge set, kept apart as far as the mesh has vertices for that.

use super::corridor::{Corridor, CorridorScratch, CorridorVertex};
use super::guide::Guide;
use super::path::EdgePath;
use super::vertex_locator::VertexLocator;
use crate::mesh::VertexId;
use crate::transfer::topology::edge_key;
use rustc_hash::FxHashMap;
use std::cell::{OnceCell, RefCell};
use std::collections::BTreeMap;

/// Widths of corridors, in target lengths: a wider one is used where a narrower one has no path.
const REACHES: [f32; 4] = [1.0, 1.5, 2.5, 4.0];
/// Rounds in which conflicting paths are searched again.
const RETRIES: usize = 4;
/// Vertices that are tried for an end of a conflicting path: more hardly help, and take time.
const MAX_ENDS: usize = 6;

/// An end of guides, by its cage vertex, and its vertex on the simulation mesh.
type SnappedEnd = (VertexId, VertexId);

/// The guides of a set and their paths.
pub(super) struct PathSet<'a> {
    locator: &'a VertexLocator<'a>,
    pub guides: Vec<Guide>,
    /// The vertex at each end of a guide, by its cage vertex.
    ends: BTreeMap<VertexId, VertexId>,
    /// The path of each guide.
    pub found: Vec<Option<EdgePath>>,
    /// The narrowest corridor of each guide, once it is needed.
    corridors: Vec<OnceCell<Corridor>>,
    /// Number of paths through each vertex; all paths that end there count as one.
    uses: FxHashMap<VertexId, u32>,
    /// Number of paths that are one edge, by that edge.
    single_edges: FxHashMap<[VertexId; 2], u32>,
    /// Guides without a path, or whose path meets another except at a common end.
    pub conflicting: Vec<usize>,
    scratch: RefCell<&'a mut CorridorScratch>,
}

impl<'a> PathSet<'a> {
    /// Finds a path for each guide. Guides with a common end share its vertex. Conflicting paths are searched again,
    /// before others and with other ends. `on_chains` are the edges of the set on chains.
    pub fn new(
        locator: &'a VertexLocator<'a>,
        guides: Vec<Guide>,
        ends: BTreeMap<VertexId, VertexId>,
        on_chains: &[[VertexId; 2]],
        scratch: &'a mut CorridorScratch,
    ) -> Self {
        let (at_chains, free): (Vec<_>, Vec<_>) = ends.iter().partition(|(end, _)| locator.on_chain(**end).is_some());
        let of_chains = on_chains.iter().flatten().chain(at_chains.into_iter().map(|(_, vertex)| vertex));
        let mut uses: FxHashMap<VertexId, u32> = of_chains.map(|&v| (v, 1)).collect();
        free.into_iter().for_each(|(_, &vertex)| *uses.entry(vertex).or_default() += 1);
        let single_edges = on_chains.iter().map(|&edge| (edge_key(edge), 1)).collect();
        let all: Vec<usize> = (0..guides.len()).collect();
        let found = all.iter().map(|_| None).collect();
        let corridors = all.iter().map(|_| OnceCell::new()).collect();
        let (conflicting, scratch) = (Vec::new(), RefCell::new(scratch));
        let mut set = Self { locator, guides, ends, found, corridors, uses, single_edges, conflicting, scratch };
        set.search(&all);
        for _ in 0..RETRIES {
            let again: Vec<usize> = set.conflicting.iter().rev().copied().collect();
            if again.is_empty() || !set.retry(&again, &[]) {
                break;
            }
        }
        set.change_ends();
        set
    }

    /// Finds the paths of some guides without one, in this order.
    fn search(&mut self, which: &[usize]) {
        for &i in which {
            let found = self.path(i);
            self.insert(i, found);
        }
        self.conflicting = (0..self.found.len()).filter(|&i| self.is_conflicting(i)).collect();
    }

    /// Moves ends to other vertices and finds some paths again. Returns whether fewer paths conflict; else all is
    /// restored.
    fn retry(&mut self, which: &[usize], moves: &[SnappedEnd]) -> bool {
        let back: Vec<SnappedEnd> = moves.iter().map(|&(end, _)| (end, self.ends[&end])).collect();
        let paths: Vec<Option<EdgePath>> = which.iter().map(|&i| self.remove(i)).collect();
        let conflicting = self.conflicting.clone();
        self.move_ends(&back, moves);
        if moves.iter().all(|m| self.uses.get(&m.1) == Some(&1)) {
            self.search(which);
            if self.conflicting.len() < conflicting.len() {
                return true;
            }
            which.iter().for_each(|&i| drop(self.remove(i)));
        }
        self.move_ends(moves, &back);
        which.iter().zip(paths).for_each(|(&i, path)| self.insert(i, path));
        self.conflicting = conflicting;
        false
    }

    fn insert(&mut self, i: usize, path: Option<EdgePath>) {
        self.found[i] = path;
        self.count(i, |n| *n += 1);
    }

    fn remove(&mut self, i: usize) -> Option<EdgePath> {
        self.count(i, |n| *n -= 1);
        self.found[i].take()
    }

    /// Changes the counts of the vertices and the edge that a path uses.
    fn count(&mut self, i: usize, change: impl Fn(&mut u32)) {
        let Some(path) = &self.found[i] else { return };
        for &vertex in path.inner(self.guides[i].is_loop) {
            change(self.uses.entry(vertex).or_default());
        }
        if let [a, b] = path.vertices[..] {
            change(self.single_edges.entry(edge_key([a, b])).or_default());
        }
    }

    fn is_conflicting(&self, i: usize) -> bool {
        let Some(path) = &self.found[i] else { return true };
        let is_shared = |edge| self.single_edges.get(&edge_key(edge)) != Some(&1);
        let meets = path.vertices.iter().any(|v| self.uses.get(v) != Some(&1));
        meets || path.vertices[..].try_into().is_ok_and(is_shared)
    }

    /// Gives the ends of conflicting paths, and ends on their way, other vertices near by where that leaves fewer
    /// conflicts: first a free vertex, then that of another end.
    fn change_ends(&mut self) {
        for i in self.conflicting.clone() {
            let ends = self.ends_in_the_way(i);
            for change in [Self::change_end, Self::exchange_end] {
                for &end in &ends {
                    if self.conflicting.contains(&i) {
                        change(self, end);
                    }
                }
            }
        }
    }

    /// The ends of a guide and those that its path meets, by their cage vertices; none on chains, which have no choice.
    fn ends_in_the_way(&self, i: usize) -> Vec<VertexId> {
        let guide = &self.guides[i];
        let own = guide.ends().into_iter().filter(|_| !guide.is_loop);
        let path = self.found[i].as_ref().map_or(&[][..], |path| &path.vertices);
        let others = self.ends.iter().filter(|(_, vertex)| path.contains(vertex)).map(|(&end, _)| end);
        let mut ends: Vec<VertexId> = Vec::new();
        for end in own.chain(others).filter(|&end| self.locator.on_chain(end).is_none()) {
            if !ends.contains(&end) {
                ends.push(end);
            }
        }
        ends
    }

    /// Moves an end to the first vertex near by that helps. Returns whether there is one.
    fn change_end(&mut self, end: VertexId) -> bool {
        self.others_near(end).into_iter().any(|vertex| self.try_moves(&[(end, vertex)]))
    }

    /// Moves an end to the vertex of another end near by, and that end elsewhere. Returns whether that helps.
    fn exchange_end(&mut self, end: VertexId) -> bool {
        self.others_near(end).into_iter().any(|vertex| {
            let mut others = self.ends.iter().filter(|(other, _)| self.locator.on_chain(**other).is_none());
            let Some(other) = others.find(|(_, v)| **v == vertex).map(|(&other, _)| other) else { return false };
            self.others_near(other).into_iter().any(|to| self.try_moves(&[(end, vertex), (other, to)]))
        })
    }

    /// The vertices near an end, without its own.
    fn others_near(&self, end: VertexId) -> Vec<VertexId> {
        let own = self.ends.get(&end);
        self.locator.near(end).into_iter().filter(|v| Some(v) != own).take(MAX_ENDS).collect()
    }

    /// Moves ends to vertices that no path uses, if that leaves fewer conflicts. Returns whether they are moved.
    fn try_moves(&mut self, moves: &[SnappedEnd]) -> bool {
        let is_moved = |i: &usize| {
            let guide = &self.guides[*i];
            !guide.is_loop && guide.ends().iter().any(|end| moves.iter().any(|m| m.0 == *end))
        };
        let mut again: Vec<usize> = (0..self.found.len()).filter(is_moved).collect();
        again.extend(self.conflicting.iter().filter(|i| !is_moved(i)));
        self.retry(&again, moves)
    }

    fn move_ends(&mut self, from: &[SnappedEnd], to: &[SnappedEnd]) {
        from.iter().for_each(|m| *self.uses.entry(m.1).or_default() -= 1);
        for &(end, vertex) in to {
            *self.uses.entry(vertex).or_default() += 1;
            self.ends.insert(end, vertex);
        }
    }

    /// The best path of a guide in the narrowest corridor that has one.
    fn path(&self, i: usize) -> Option<EdgePath> {
        let guide = &self.guides[i];
        let ends = guide.ends().map(|end| self.ends.get(&end).copied());
        let is_taken = |edge| self.single_edges.get(&edge_key(edge)).is_some_and(|n| *n > 0);
        let least = if guide.curve.is_closed { 4 } else { 2 };
        let corridor = |reach| Corridor::new(self.locator, guide, reach, &mut self.scratch.borrow_mut());
        let narrow = self.corridors[i].get_or_init(|| corridor(REACHES[0]));
        // A way around an edge that is another path comes first.
        let apart = match ends {
            [Some(a), Some(b)] if !guide.curve.is_closed && is_taken([a, b]) => self.path_within(i, narrow, ends, 3),
            _ => None,
        };
        let near = apart.or_else(|| self.path_within(i, narrow, ends, least));
        near.or_else(|| REACHES[1..].iter().find_map(|&r| self.path_within(i, &corridor(r), ends, least)))
    }

    /// The best path of a guide in a corridor, of at least `least` vertices.
    fn path_within(
        &self,
        i: usize,
        corridor: &Corridor,
        ends: [Option<VertexId>; 2],
        least: usize,
    ) -> Option<EdgePath> {
        let is_used = |v: VertexId| self.uses.get(&v).is_some_and(|n| *n > 0);
        let is_occupied = |v: &CorridorVertex| self.locator.is_constrained[v.vertex] || is_used(v.vertex);
        let occupied: Vec<bool> = corridor.vertices.iter().map(is_occupied).collect();
        let ends = match self.guides[i].is_loop {
            true => [corridor.nearest(&occupied)?; 2],
            false => [ends[0]?, ends[1]?],
        };
        corridor.best_path(ends, least, &occupied)
    }
}
