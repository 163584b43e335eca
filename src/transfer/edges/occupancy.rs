//! Which paths of an edge set meet: counts at vertices and edges that follow each path as it comes and goes.
//!
//! A path costs its length, and the paths that begin or cease to meet it.

use super::path::EdgePath;
use crate::mesh::VertexId;
use crate::transfer::topology::edge_key;
use rustc_hash::{FxHashMap, FxHashSet};

/// The vertices and edges that the paths of a set use. Paths go by their index.
pub(super) struct Occupancy {
    /// Number of paths through each vertex; all paths that end there count as one.
    uses: FxHashMap<VertexId, u32>,
    /// The paths at each vertex, those that end there included.
    paths_at: FxHashMap<VertexId, Vec<usize>>,
    /// The paths that are one edge, by that edge.
    single_edges: FxHashMap<[VertexId; 2], Vec<usize>>,
    /// Edges of the set on chains.
    on_chains: FxHashSet<[VertexId; 2]>,
    /// Number of vertices and edges that each path has in common with others, except common ends.
    shared: Vec<u32>,
    /// Paths whose number has changed since the last call of [`Self::changed`].
    changed: Vec<usize>,
}

impl Occupancy {
    /// For `count` paths, none of which is there yet. `on_chains` are edges of the set on chains.
    pub fn new(count: usize, on_chains: &[[VertexId; 2]]) -> Self {
        Self {
            uses: on_chains.iter().flatten().map(|&v| (v, 1)).collect(),
            paths_at: FxHashMap::default(),
            single_edges: FxHashMap::default(),
            on_chains: on_chains.iter().map(|&edge| edge_key(edge)).collect(),
            shared: vec![0; count],
            changed: Vec::new(),
        }
    }

    /// Whether a path uses a vertex.
    pub fn is_used(&self, vertex: VertexId) -> bool {
        self.uses.get(&vertex).is_some_and(|n| *n > 0)
    }

    /// Whether one path, or all that end there, use a vertex.
    pub fn is_used_once(&self, vertex: VertexId) -> bool {
        self.uses.get(&vertex) == Some(&1)
    }

    /// Whether an edge is a path, or on a chain.
    pub fn is_single_edge(&self, edge: [VertexId; 2]) -> bool {
        let edge = edge_key(edge);
        self.on_chains.contains(&edge) || self.single_edges.get(&edge).is_some_and(|paths| !paths.is_empty())
    }

    /// Whether a path meets others except at common ends.
    pub fn is_shared(&self, path: usize) -> bool {
        self.shared[path] > 0
    }

    /// The paths at a vertex.
    pub fn paths_at(&self, vertex: VertexId) -> &[usize] {
        self.paths_at.get(&vertex).map_or(&[], Vec::as_slice)
    }

    /// Takes the paths whose conflicts may have changed.
    pub fn changed(&mut self) -> Vec<usize> {
        std::mem::take(&mut self.changed)
    }

    /// Uses a vertex that a chain has once, however often it is called.
    pub fn use_on_chain(&mut self, vertex: VertexId) {
        self.uses.insert(vertex, 1);
    }

    pub fn use_vertex(&mut self, vertex: VertexId) {
        self.change_uses(vertex, |n| *n += 1);
    }

    pub fn free_vertex(&mut self, vertex: VertexId) {
        self.change_uses(vertex, |n| *n -= 1);
    }

    fn change_uses(&mut self, vertex: VertexId, change: impl Fn(&mut u32)) {
        let uses = self.uses.entry(vertex).or_default();
        let before = *uses == 1;
        change(uses);
        let after = *uses == 1;
        if before != after {
            for &path in self.paths_at.get(&vertex).into_iter().flatten() {
                let shared = &mut self.shared[path];
                *shared = if after { *shared - 1 } else { *shared + 1 };
                self.changed.push(path);
            }
        }
    }

    /// Adds a path.
    pub fn insert(&mut self, i: usize, path: &EdgePath, is_loop: bool) {
        path.inner(is_loop).iter().for_each(|&v| self.use_vertex(v));
        let mut shared = 0;
        for &vertex in &path.vertices {
            shared += u32::from(!self.is_used_once(vertex));
            self.paths_at.entry(vertex).or_default().push(i);
        }
        if let Some(edge) = single_edge(path) {
            let others = self.single_edges.entry(edge).or_default();
            if let [other] = others[..] {
                self.shared[other] += 1;
                self.changed.push(other);
            }
            // Where it is on a chain, its ends are of the chain and of the path: a conflict that others do not change.
            shared += u32::from(!others.is_empty()) + u32::from(self.on_chains.contains(&edge));
            others.push(i);
        }
        self.shared[i] = shared;
        self.changed.push(i);
    }

    /// Removes a path.
    pub fn remove(&mut self, i: usize, path: &EdgePath, is_loop: bool) {
        for vertex in &path.vertices {
            let paths = self.paths_at.entry(*vertex).or_default();
            if let Some(at) = paths.iter().position(|&p| p == i) {
                paths.swap_remove(at);
            }
        }
        self.shared[i] = 0;
        path.inner(is_loop).iter().for_each(|&v| self.free_vertex(v));
        if let Some(edge) = single_edge(path) {
            let others = self.single_edges.entry(edge).or_default();
            others.retain(|&other| other != i);
            if let [other] = others[..] {
                self.shared[other] -= 1;
                self.changed.push(other);
            }
        }
        self.changed.push(i);
    }
}

/// The edge that a path is, if it is one.
fn single_edge(path: &EdgePath) -> Option<[VertexId; 2]> {
    path.vertices[..].try_into().ok().map(edge_key)
}
