//! A priority queue of edges with a total order, so that equal lengths come out in the same order on every run.

use super::mesh::SimMesh;
use crate::mesh::{CornerId, VertexId};
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Corners that one task looks at.
const CORNERS_PER_TASK: usize = 8192;

struct Entry {
    key: f32,
    /// The lower vertex first.
    ends: [VertexId; 2],
    /// Where the edge was when it was added.
    half: CornerId,
}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> Ordering {
        self.key.total_cmp(&other.key).then_with(|| other.ends.cmp(&self.ends))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Entry {}

/// Edges, that of the largest key first; of equal keys that of the lowest vertices.
pub struct EdgeQueue(BinaryHeap<Entry>);

impl EdgeQueue {
    /// The edges of a mesh that have a key.
    pub fn of(mesh: &SimMesh<'_>, key: impl Fn(&SimMesh<'_>, CornerId) -> Option<f32> + Sync) -> Self {
        let slots = mesh.topology.corner_slots();
        let tasks = 0..slots.div_ceil(CORNERS_PER_TASK);
        let found: Vec<Entry> = tasks
            .into_par_iter()
            .flat_map_iter(|task| {
                let own = task * CORNERS_PER_TASK..slots.min((task + 1) * CORNERS_PER_TASK);
                let edges = own.map(CornerId::new).filter(|&half| mesh.topology.is_edge(half));
                let key = &key;
                edges.filter_map(move |half| Some(entry(mesh, half, key(mesh, half)?)))
            })
            .collect();
        Self(found.into())
    }

    /// Adds an edge that has a key; edges may be in the queue more than once.
    pub fn push(&mut self, mesh: &SimMesh<'_>, half: CornerId, key: Option<f32>) {
        self.0.extend(key.map(|key| entry(mesh, half, key)));
    }

    /// The first edge that is still there.
    pub fn pop(&mut self, mesh: &SimMesh<'_>) -> Option<CornerId> {
        while let Some(Entry { ends: [a, b], half, .. }) = self.0.pop() {
            let found = match mesh.topology.is_alive(half) && ends(mesh, half) == [a, b] {
                true => Some(half),
                false => mesh.topology.find(a, b),
            };
            if found.is_some() {
                return found;
            }
        }
        None
    }
}

fn ends(mesh: &SimMesh<'_>, half: CornerId) -> [VertexId; 2] {
    let (a, b) = (mesh.topology.vertex(half), mesh.topology.target(half));
    [a.min(b), a.max(b)]
}

fn entry(mesh: &SimMesh<'_>, half: CornerId, key: f32) -> Entry {
    Entry { key, ends: ends(mesh, half), half }
}
