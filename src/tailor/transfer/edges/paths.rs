//! The paths of one edge set along its guides, in their order. A path avoids those before it where the mesh has vertices
//! for that; paths that meet are counted.

use super::corridor::{Corridor, CorridorScratch, CorridorVertex};
use super::guide::Guide;
use super::path::EdgePath;
use super::vertex_locator::VertexLocator;
use crate::transfer::topology::edge_key;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeMap;
use tailor_mesh::connectivity::VertexId;

/// Widths of corridors, in target lengths: a wider one is used where a narrower one has no path.
const WIDTHS: [f32; 4] = [1.0, 1.5, 2.5, 4.0];

/// A search for the paths of a set.
pub(super) struct PathSearch<'a> {
    locator: &'a VertexLocator<'a>,
    /// The vertex at each end of a guide, by its cage vertex.
    ends: &'a BTreeMap<VertexId, VertexId>,
    /// Vertices at ends, on chains of the set, and on paths that are found.
    used: FxHashSet<VertexId>,
    scratch: &'a mut CorridorScratch,
}

impl<'a> PathSearch<'a> {
    /// `on_chains` are the edges of the set on chains.
    pub fn new(
        locator: &'a VertexLocator<'a>,
        ends: &'a BTreeMap<VertexId, VertexId>,
        on_chains: &[[VertexId; 2]],
        scratch: &'a mut CorridorScratch,
    ) -> Self {
        let used = on_chains.iter().flatten().chain(ends.values()).copied().collect();
        Self { locator, ends, used, scratch }
    }

    /// The best path of a guide in the narrowest corridor that has one.
    pub fn find(&mut self, guide: &Guide) -> Option<EdgePath> {
        let ends = guide.ends().map(|end| self.ends.get(&end).copied());
        if !guide.curve.is_closed && ends[0] == ends[1] {
            return None;
        }
        let path = WIDTHS.iter().find_map(|&width| self.find_within(guide, width, ends))?;
        self.used.extend(&path.vertices);
        Some(path)
    }

    fn find_within(&mut self, guide: &Guide, width: f32, ends: [Option<VertexId>; 2]) -> Option<EdgePath> {
        let corridor = Corridor::new(self.locator, guide, width, self.scratch);
        let is_occupied = |v: &CorridorVertex| self.locator.is_constrained[v.vertex] || self.used.contains(&v.vertex);
        let occupied: Vec<bool> = corridor.vertices.iter().map(is_occupied).collect();
        let ends = match guide.is_loop {
            true => [corridor.nearest(&occupied)?; 2],
            false => [ends[0]?, ends[1]?],
        };
        corridor.best_path(ends, if guide.curve.is_closed { 4 } else { 2 }, &occupied)
    }
}

/// The guides whose paths have a vertex or an edge in common with others or with `on_chains`, except where guides end.
pub(super) fn meeting<'a>(
    paths: &[(&'a Guide, &EdgePath)],
    ends: &BTreeMap<VertexId, VertexId>,
    on_chains: &[[VertexId; 2]],
) -> impl Iterator<Item = &'a Guide> {
    let mut users: FxHashMap<VertexId, usize> = FxHashMap::default();
    let mut edges: FxHashMap<[VertexId; 2], usize> = on_chains.iter().map(|&edge| (edge_key(edge), 1)).collect();
    for &end in ends.values() {
        *users.entry(end).or_default() += 1;
    }
    for &vertex in on_chains.iter().flatten() {
        users.insert(vertex, 1);
    }
    let at_ends: FxHashSet<VertexId> = ends.values().copied().collect();
    for (_, path) in paths {
        // Around a small hole the shortest loop may pass by the end of its guide.
        path.inner(!at_ends.contains(&path.vertices[0])).iter().for_each(|&v| *users.entry(v).or_default() += 1);
        path.vertices.windows(2).for_each(|pair| *edges.entry(edge_key([pair[0], pair[1]])).or_default() += 1);
    }
    let is_alone = move |path: &EdgePath| {
        path.vertices.iter().all(|v| users[v] == 1)
            && path.vertices.windows(2).all(|pair| edges[&edge_key([pair[0], pair[1]])] == 1)
    };
    paths.iter().filter(move |(_, path)| !is_alone(path)).map(|&(guide, _)| guide)
}
