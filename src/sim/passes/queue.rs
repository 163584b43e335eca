//! Edges in the order of a key, with a total order, so that equal keys come out in the same order on every run.
//!
//! A sweep takes the edges that are there, those with the largest key first; what an edit changes comes in the next
//! sweep. Sorting once costs a quarter of a heap, and the meshes are as good.

use crate::mesh::{CornerId, VertexId};
use crate::sim::sim_mesh::SimMesh;
use rayon::prelude::*;
use std::cmp::Ordering;

/// Corners that one task looks at.
const CORNERS_PER_TASK: usize = 8192;
/// Sweeps of one pass; later ones find next to nothing.
const MAX_SWEEPS: usize = 8;

/// An edge, where it was when it was found.
#[derive(Clone, Copy)]
pub(crate) struct QueuedEdge {
    key: f32,
    /// The lower vertex first.
    ends: [VertexId; 2],
    half: CornerId,
}

impl QueuedEdge {
    fn new(mesh: &SimMesh<'_>, half: CornerId, key: f32) -> Self {
        Self { key, ends: ends(mesh, half), half }
    }

    fn order(&self, other: &Self) -> Ordering {
        other.key.total_cmp(&self.key).then_with(|| self.ends.cmp(&other.ends))
    }

    /// The edge, if it is still there.
    fn find(&self, mesh: &SimMesh<'_>) -> Option<CornerId> {
        let [a, b] = self.ends;
        match mesh.topology.is_alive(self.half) && ends(mesh, self.half) == [a, b] {
            true => Some(self.half),
            false => mesh.topology.find(a, b),
        }
    }
}

fn ends(mesh: &SimMesh<'_>, half: CornerId) -> [VertexId; 2] {
    let (a, b) = (mesh.topology.vertex(half), mesh.topology.target(half));
    [a.min(b), a.max(b)]
}

/// Edits `entries`, the largest key first, and then what has a key after that, until none is left that can be edited.
/// `edit` returns a vertex around which edges changed, or nothing where it refused. Returns the number of edits.
pub(crate) fn edit_in_order<'a>(
    mesh: &mut SimMesh<'a>,
    mut entries: Vec<QueuedEdge>,
    key: impl Fn(&SimMesh<'a>, CornerId) -> Option<f32>,
    mut edit: impl FnMut(&mut SimMesh<'a>, CornerId) -> Option<VertexId>,
) -> usize {
    let mut count = 0;
    let mut changed: Vec<VertexId> = Vec::new();
    for _ in 0..MAX_SWEEPS {
        entries.par_sort_unstable_by(QueuedEdge::order);
        entries.dedup_by_key(|entry| entry.ends);
        for entry in &entries {
            let half = entry.find(mesh).filter(|&half| key(mesh, half).is_some());
            if let Some(vertex) = half.and_then(|half| edit(mesh, half)) {
                changed.push(vertex);
                count += 1;
            }
        }
        changed.sort_unstable();
        changed.dedup();
        entries.clear();
        entries.extend(keyed_around(mesh, changed.drain(..), &key));
        if entries.is_empty() {
            break;
        }
    }
    count
}

/// The edges of a mesh that have a key.
pub(crate) fn keyed<'a>(
    mesh: &SimMesh<'a>,
    key: impl Fn(&SimMesh<'a>, CornerId) -> Option<f32> + Sync,
) -> Vec<QueuedEdge> {
    let [found, _] = keyed_by_both(mesh, key, |_, _| None);
    found
}

/// The edges of a mesh that have a key by the first of two, and of the others those that have one by the second: looking
/// at all edges costs as much as a late round's edits.
pub(crate) fn keyed_by_both<'a>(
    mesh: &SimMesh<'a>,
    first: impl Fn(&SimMesh<'a>, CornerId) -> Option<f32> + Sync,
    second: impl Fn(&SimMesh<'a>, CornerId) -> Option<f32> + Sync,
) -> [Vec<QueuedEdge>; 2] {
    let slots = mesh.topology.corner_slots();
    let tasks = (0..slots.div_ceil(CORNERS_PER_TASK)).into_par_iter();
    let found = tasks.map(|task| {
        let own = task * CORNERS_PER_TASK..slots.min((task + 1) * CORNERS_PER_TASK);
        let mut found = [Vec::new(), Vec::new()];
        for half in own.map(CornerId::new).filter(|&half| mesh.topology.is_edge(half)) {
            if let Some(key) = first(mesh, half) {
                found[0].push(QueuedEdge::new(mesh, half, key));
            } else if let Some(key) = second(mesh, half) {
                found[1].push(QueuedEdge::new(mesh, half, key));
            }
        }
        found
    });
    found.collect::<Vec<_>>().into_iter().fold([Vec::new(), Vec::new()], |[mut a, mut b], [c, d]| {
        a.extend(c);
        b.extend(d);
        [a, b]
    })
}

/// The edges at some vertices that have a key; those between two of them twice.
pub(crate) fn keyed_around<'a>(
    mesh: &SimMesh<'a>,
    vertices: impl Iterator<Item = VertexId>,
    key: &impl Fn(&SimMesh<'a>, CornerId) -> Option<f32>,
) -> impl Iterator<Item = QueuedEdge> {
    let keyed = move |half| Some(QueuedEdge::new(mesh, half, key(mesh, half)?));
    vertices.flat_map(move |v| mesh.topology.spokes(v).filter_map(keyed))
}
