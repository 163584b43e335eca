//! Other vertices for the ends of paths that meet.

use super::path_set::{PathSet, SnappedEnd};
use crate::mesh::VertexId;
use rustc_hash::FxHashSet;
use std::collections::BTreeSet;

/// Vertices that are tried for an end of a conflicting path: more hardly help, and take time.
const MAX_ENDS: usize = 6;
/// Conflicting paths that are all searched again with each change. Of more, only those that meet the path are.
const FEW: usize = 16;

impl PathSet<'_> {
    /// Gives the ends of conflicting paths, and ends on their way, other vertices near by where that leaves fewer
    /// conflicts: first a free vertex, then that of another end.
    pub(super) fn change_ends(&mut self) {
        for i in Vec::from_iter(self.conflicting.clone()) {
            let ends = self.ends_in_the_way(i);
            for change in [Self::change_end, Self::exchange_end] {
                for &end in &ends {
                    if self.conflicting.contains(&i) && !self.is_spent(i) {
                        change(self, i, end);
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
        let others: BTreeSet<VertexId> = path.iter().filter_map(|v| self.ends_at.get(v)).flatten().copied().collect();
        let mut seen = FxHashSet::default();
        let free = own.chain(others).filter(|&end| self.locator.on_chain(end).is_none());
        free.filter(|&end| seen.insert(end)).collect()
    }

    /// Moves an end to the first vertex near by that helps path `i`. Returns whether there is one.
    fn change_end(&mut self, i: usize, end: VertexId) -> bool {
        self.others_near(end).into_iter().any(|vertex| self.try_moves(i, &[(end, vertex)]))
    }

    /// Moves an end to the vertex of another end near by, and that end elsewhere. Returns whether that helps path `i`.
    fn exchange_end(&mut self, i: usize, end: VertexId) -> bool {
        self.others_near(end).into_iter().any(|vertex| {
            let mut others = self.ends_at.get(&vertex).into_iter().flatten().copied();
            let Some(other) = others.find(|&other| self.locator.on_chain(other).is_none()) else { return false };
            self.others_near(other).into_iter().any(|to| self.try_moves(i, &[(end, vertex), (other, to)]))
        })
    }

    /// The vertices near an end, without its own.
    fn others_near(&mut self, end: VertexId) -> Vec<VertexId> {
        let locator = self.locator;
        let near = self.near.entry(end).or_insert_with(|| locator.near(end).into_iter().take(MAX_ENDS + 1).collect());
        let own = self.ends.get(&end);
        near.iter().copied().filter(|v| Some(v) != own).take(MAX_ENDS).collect()
    }

    /// Moves ends to vertices that no path uses, if that leaves fewer conflicts. Returns whether they are moved.
    fn try_moves(&mut self, i: usize, moves: &[SnappedEnd]) -> bool {
        let mut again: Vec<usize> = moves.iter().flat_map(|m| self.guides_at(m.0)).copied().collect();
        again.sort_unstable();
        again.dedup();
        if self.is_spent(i) || again.iter().any(|&moved| self.is_spent(moved)) {
            return false;
        }
        let others = if self.conflicting.len() <= FEW { self.conflicting.clone() } else { self.rivals(i) };
        let moved = again.clone();
        again.extend(others.into_iter().filter(|other| !self.is_spent(*other) && moved.binary_search(other).is_err()));
        self.retry(&again, moves)
    }

    /// A conflicting path, and the first others that it meets.
    fn rivals(&self, i: usize) -> BTreeSet<usize> {
        let path = self.found[i].as_ref().map_or(&[][..], |path| &path.vertices);
        let others = path.iter().flat_map(|&v| self.occupancy.paths_at(v)).copied();
        let others = others.filter(|other| self.conflicting.contains(other));
        std::iter::once(i).chain(others.take(FEW)).collect()
    }
}
