//! The paths of one edge set, kept apart as far as the mesh has vertices for that.
//!
//! All searches of a path together visit no more than a number of triangles in proportion to its curve, so that a set costs
//! in proportion to its edges. Paths that still meet are reported.

use super::corridor::{Corridor, CorridorScratch, CorridorVertex};
use super::guide::Guide;
use super::occupancy::Occupancy;
use super::path::EdgePath;
use super::vertex_locator::VertexLocator;
use crate::mesh::VertexId;
use rustc_hash::FxHashMap;
use std::cell::{Cell, OnceCell, RefCell};
use std::collections::{BTreeMap, BTreeSet};

/// Widths of corridors, in target lengths: a wider one is used where a narrower one has no path.
const REACHES: [f32; 4] = [1.0, 1.5, 2.5, 4.0];
/// Rounds in which conflicting paths are searched again.
const RETRIES: usize = 4;
/// Triangles that the searches of a path may visit for each segment of its curve before the path stays as it is. More hardly
/// lay further paths apart.
const VISITS_PER_SEGMENT: usize = 2048;
/// Triangles that the searches of a set may visit besides: in a small set each path has many tries.
const VISITS_PER_SET: usize = 1 << 19;

/// An end of guides, by its cage vertex, and its vertex on the simulation mesh.
pub(super) type SnappedEnd = (VertexId, VertexId);

/// The guides of a set and their paths.
pub(super) struct PathSet<'a> {
    pub(super) locator: &'a VertexLocator<'a>,
    pub guides: Vec<Guide>,
    /// The vertex at each end of a guide, by its cage vertex.
    pub(super) ends: BTreeMap<VertexId, VertexId>,
    /// The ends at each vertex.
    pub(super) ends_at: FxHashMap<VertexId, BTreeSet<VertexId>>,
    /// The vertices near each end, once they are needed.
    pub(super) near: FxHashMap<VertexId, Vec<VertexId>>,
    /// The guides at each end, ascending; twice where a guide ends where it begins.
    guides_at: FxHashMap<VertexId, Vec<usize>>,
    /// The path of each guide.
    pub found: Vec<Option<EdgePath>>,
    /// The narrowest corridor of each guide, once it is needed.
    corridors: Vec<OnceCell<Corridor>>,
    pub(super) occupancy: Occupancy,
    /// Guides without a path, or whose path meets another except at a common end.
    pub conflicting: BTreeSet<usize>,
    /// Triangles that searches for the path of each guide have visited, and those from which on it is not searched again.
    visits: Vec<Cell<usize>>,
    most_visits: Vec<usize>,
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
        let mut occupancy = Occupancy::new(guides.len(), on_chains);
        let (at_chains, free): (Vec<_>, Vec<_>) = ends.iter().partition(|(end, _)| locator.on_chain(**end).is_some());
        at_chains.into_iter().for_each(|(_, &vertex)| occupancy.use_on_chain(vertex));
        free.into_iter().for_each(|(_, &vertex)| occupancy.use_vertex(vertex));
        let mut ends_at = FxHashMap::<VertexId, BTreeSet<VertexId>>::default();
        for (&end, &vertex) in &ends {
            ends_at.entry(vertex).or_default().insert(end);
        }
        let mut guides_at = FxHashMap::<VertexId, Vec<usize>>::default();
        for (i, guide) in guides.iter().enumerate().filter(|(_, guide)| !guide.is_loop) {
            guide.ends().into_iter().for_each(|end| guides_at.entry(end).or_default().push(i));
        }
        let all: Vec<usize> = (0..guides.len()).collect();
        let share = VISITS_PER_SET / guides.len().max(1);
        let most_visits = guides.iter().map(|g| VISITS_PER_SEGMENT * g.vertices.len() + share).collect();
        let mut set = Self {
            found: all.iter().map(|_| None).collect(),
            corridors: all.iter().map(|_| OnceCell::new()).collect(),
            conflicting: all.iter().copied().collect(),
            scratch: RefCell::new(scratch),
            locator,
            guides,
            ends,
            ends_at,
            near: FxHashMap::default(),
            guides_at,
            occupancy,
            visits: vec![Cell::new(0); all.len()],
            most_visits,
        };
        set.search(&all);
        for _ in 0..RETRIES {
            let again: Vec<usize> = set.conflicting.iter().rev().copied().filter(|&i| !set.is_spent(i)).collect();
            if again.is_empty() || !set.retry(&again, &[]) {
                break;
            }
        }
        set.change_ends();
        set
    }

    /// The guides at an end.
    pub(super) fn guides_at(&self, end: VertexId) -> &[usize] {
        self.guides_at.get(&end).map_or(&[], Vec::as_slice)
    }

    /// Whether the path of a guide is not searched again.
    pub(super) fn is_spent(&self, i: usize) -> bool {
        self.visits[i].get() >= self.most_visits[i]
    }

    /// Triangles that all searches have visited.
    #[cfg(feature = "internals")]
    pub fn visited(&self) -> usize {
        self.visits.iter().map(Cell::get).sum()
    }

    fn spend(&self, i: usize, visits: usize) {
        self.visits[i].set(self.visits[i].get() + visits);
    }

    /// Finds the paths of some guides without one, in this order.
    fn search(&mut self, which: &[usize]) {
        for &i in which {
            let found = self.path(i);
            self.insert(i, found);
        }
        self.update_conflicts();
    }

    /// Moves ends to other vertices and finds some paths again. Returns whether fewer paths conflict; else all is
    /// restored.
    pub(super) fn retry(&mut self, which: &[usize], moves: &[SnappedEnd]) -> bool {
        let back: Vec<SnappedEnd> = moves.iter().map(|&(end, _)| (end, self.ends[&end])).collect();
        let before = self.conflicting.len();
        let paths: Vec<Option<EdgePath>> = which.iter().map(|&i| self.remove(i)).collect();
        self.move_ends(&back, moves);
        if moves.iter().all(|m| self.occupancy.is_used_once(m.1)) {
            self.search(which);
            if self.conflicting.len() < before {
                return true;
            }
            which.iter().for_each(|&i| drop(self.remove(i)));
        }
        self.move_ends(moves, &back);
        which.iter().zip(paths).for_each(|(&i, path)| self.insert(i, path));
        self.update_conflicts();
        false
    }

    fn insert(&mut self, i: usize, path: Option<EdgePath>) {
        if let Some(path) = &path {
            self.occupancy.insert(i, path, self.guides[i].is_loop);
        }
        self.found[i] = path;
    }

    fn remove(&mut self, i: usize) -> Option<EdgePath> {
        let path = self.found[i].take()?;
        self.spend(i, path.vertices.len());
        self.occupancy.remove(i, &path, self.guides[i].is_loop);
        Some(path)
    }

    fn update_conflicts(&mut self) {
        for i in self.occupancy.changed() {
            if self.found[i].is_none() || self.occupancy.is_shared(i) {
                self.conflicting.insert(i);
            } else {
                self.conflicting.remove(&i);
            }
        }
    }

    fn move_ends(&mut self, from: &[SnappedEnd], to: &[SnappedEnd]) {
        for &(end, vertex) in from {
            self.occupancy.free_vertex(vertex);
            self.ends_at.entry(vertex).or_default().remove(&end);
        }
        for &(end, vertex) in to {
            self.occupancy.use_vertex(vertex);
            self.ends_at.entry(vertex).or_default().insert(end);
            self.ends.insert(end, vertex);
        }
    }

    /// The best path of a guide in the narrowest corridor that has one.
    fn path(&self, i: usize) -> Option<EdgePath> {
        let guide = &self.guides[i];
        let ends = guide.ends().map(|end| self.ends.get(&end).copied());
        let is_closed = guide.curve.is_closed;
        if !is_closed && ends[0] == ends[1] {
            return None;
        }
        let narrow = self.corridors[i].get_or_init(|| self.corridor(i, REACHES[0]));
        // A way around an edge that is another path comes first.
        let apart = match ends {
            [Some(a), Some(b)] if !is_closed && self.occupancy.is_single_edge([a, b]) => {
                self.path_within(i, narrow, ends, 3)
            }
            _ => None,
        };
        let least = if is_closed { 4 } else { 2 };
        let near = apart.or_else(|| self.path_within(i, narrow, ends, least));
        near.or_else(|| REACHES[1..].iter().find_map(|&r| self.path_within(i, &self.corridor(i, r), ends, least)))
    }

    fn corridor(&self, i: usize, reach: f32) -> Corridor {
        let corridor = Corridor::new(self.locator, &self.guides[i], reach, &mut self.scratch.borrow_mut());
        self.spend(i, corridor.visited);
        corridor
    }

    /// The best path of a guide in a corridor, of at least `least` vertices.
    fn path_within(
        &self,
        i: usize,
        corridor: &Corridor,
        ends: [Option<VertexId>; 2],
        least: usize,
    ) -> Option<EdgePath> {
        self.spend(i, corridor.vertices.len());
        let is_occupied =
            |v: &CorridorVertex| self.locator.is_constrained[v.vertex] || self.occupancy.is_used(v.vertex);
        let occupied: Vec<bool> = corridor.vertices.iter().map(is_occupied).collect();
        let ends = match self.guides[i].is_loop {
            true => [corridor.nearest(&occupied)?; 2],
            false => [ends[0]?, ends[1]?],
        };
        corridor.best_path(ends, least, &occupied)
    }
}
