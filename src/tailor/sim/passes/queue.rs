//! Edges in the order of a key, with a total order, so that every run edits equal keys in the same order.
//!
//! A sweep edits the edges with a key, the largest key first; edges that change enter the next sweep. One sort costs a
//! quarter of a heap, and the meshes are as good.

use crate::sim::sim_mesh::SimMesh;
use rayon::iter::Either;
use rayon::prelude::*;
use std::cmp::Ordering;
use tailor_mesh::connectivity::{CornerId, VertexId};

/// Sweeps of one pass; later ones find next to nothing.
const MAX_SWEEPS: usize = 8;

/// An edge with its key, as it was when it was found.
#[derive(Clone, Copy)]
pub struct QueuedEdge {
    key: f32,
    /// The lower vertex first.
    ends: [VertexId; 2],
    half: CornerId,
}

impl QueuedEdge {
    fn new(mesh: &SimMesh<'_>, half: CornerId, key: f32) -> Self {
        Self { key, ends: sorted_ends(mesh, half), half }
    }

    fn order(&self, other: &Self) -> Ordering {
        other.key.total_cmp(&self.key).then_with(|| self.ends.cmp(&other.ends))
    }

    /// The edge, if it still exists.
    fn find(&self, mesh: &SimMesh<'_>) -> Option<CornerId> {
        match mesh.topology.is_alive(self.half) && sorted_ends(mesh, self.half) == self.ends {
            true => Some(self.half),
            false => mesh.topology.find(self.ends[0], self.ends[1]),
        }
    }
}

fn sorted_ends(mesh: &SimMesh<'_>, half: CornerId) -> [VertexId; 2] {
    let [a, b] = mesh.topology.ends(half);
    [a.min(b), a.max(b)]
}

/// Edits `queue`, the largest key first, and then the edges around that have a key afterwards, until none can be edited.
/// `edit` returns a vertex around which edges changed, or nothing if it refused. Returns the number of edits.
pub fn edit_in_order<'a>(
    mesh: &mut SimMesh<'a>,
    mut queue: Vec<QueuedEdge>,
    key: impl Fn(&SimMesh<'a>, CornerId) -> Option<f32>,
    mut edit: impl FnMut(&mut SimMesh<'a>, CornerId) -> Option<VertexId>,
) -> usize {
    let mut count = 0;
    let mut changed: Vec<VertexId> = Vec::new();
    for _ in 0..MAX_SWEEPS {
        queue.par_sort_unstable_by(QueuedEdge::order);
        queue.dedup_by_key(|edge| edge.ends);
        for edge in &queue {
            let half = edge.find(mesh).filter(|&half| key(mesh, half).is_some());
            if let Some(vertex) = half.and_then(|half| edit(mesh, half)) {
                changed.push(vertex);
                count += 1;
            }
        }
        changed.sort_unstable();
        changed.dedup();
        queue.clear();
        queue.extend(keyed_around(mesh, changed.drain(..), &key));
        if queue.is_empty() {
            break;
        }
    }
    mesh.debug_check();
    count
}

/// One half-edge of each edge, in ascending order.
pub fn edges(mesh: &SimMesh<'_>) -> impl ParallelIterator<Item = CornerId> {
    let all = (0..mesh.topology.corner_slots()).into_par_iter().map(CornerId::new);
    all.filter(|&half| mesh.topology.is_edge(half))
}

/// The edges with a first key, and of the others those with a second one. One search for both saves as much time as the
/// edits of a late round take.
pub fn keyed_by_both<'a>(
    mesh: &SimMesh<'a>,
    first: impl Fn(&SimMesh<'a>, CornerId) -> Option<f32> + Sync,
    second: impl Fn(&SimMesh<'a>, CornerId) -> Option<f32> + Sync,
) -> (Vec<QueuedEdge>, Vec<QueuedEdge>) {
    let keyed = edges(mesh).filter_map(|half| match first(mesh, half) {
        Some(key) => Some(Either::Left(QueuedEdge::new(mesh, half, key))),
        None => Some(Either::Right(QueuedEdge::new(mesh, half, second(mesh, half)?))),
    });
    keyed.partition_map(|edge| edge)
}

/// The edges at some vertices that have a key. Edges between two of the vertices come twice.
pub fn keyed_around<'a>(
    mesh: &SimMesh<'a>,
    vertices: impl Iterator<Item = VertexId>,
    key: &impl Fn(&SimMesh<'a>, CornerId) -> Option<f32>,
) -> impl Iterator<Item = QueuedEdge> {
    let keyed = move |half| Some(QueuedEdge::new(mesh, half, key(mesh, half)?));
    vertices.flat_map(move |v| mesh.topology.spokes(v).filter_map(keyed))
}
