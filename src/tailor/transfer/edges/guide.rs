//! Guides: unbranched paths of an edge set between its ends and corners, with their curves on the baseline.

use crate::sim::Baseline;
use crate::transfer::topology::edge_key;
use std::collections::{BTreeMap, BTreeSet};
use tailor_mesh::connectivity::{IdVec, VertexId};
use tailor_mesh::subdivide::Numbering;

/// An unbranched path of an edge set.
pub(super) struct Guide {
    /// Its vertices on the cage; a loop repeats its first.
    cage: Vec<VertexId>,
    /// Its vertices on the baseline.
    pub vertices: Vec<VertexId>,
}

impl Guide {
    /// The first and the last cage vertex.
    pub fn ends(&self) -> [VertexId; 2] {
        [self.cage[0], self.cage[self.cage.len() - 1]]
    }

    /// Whether it comes back to its first vertex.
    pub fn is_closed(&self) -> bool {
        self.cage[0] == self.cage[self.cage.len() - 1]
    }

    /// Its edges on the garment, whose point of each cage vertex is in `sources`.
    pub fn edges(&self, sources: &IdVec<VertexId, VertexId>) -> impl Iterator<Item = [VertexId; 2]> {
        self.cage.windows(2).map(|pair| [sources[pair[0]], sources[pair[1]]])
    }
}

/// Joins the cage edges between `neighbours` into paths between ends, and loops.
pub(super) fn guides(
    baseline: &Baseline,
    neighbours: &BTreeMap<VertexId, Vec<VertexId>>,
    is_end: impl Fn(&VertexId) -> bool,
) -> Vec<Guide> {
    let mut used: BTreeSet<[VertexId; 2]> = BTreeSet::new();
    let mut walk = |start: VertexId, second: VertexId| -> Option<Guide> {
        if !used.insert(edge_key([start, second])) {
            return None;
        }
        let (mut cage, mut here) = (vec![start, second], second);
        while !is_end(&here) && here != start {
            let Some(&next) = neighbours[&here].iter().find(|&&n| used.insert(edge_key([here, n]))) else { break };
            cage.push(next);
            here = next;
        }
        Some(Guide { vertices: refined_path(baseline, &cage), cage })
    };
    let mut guides = Vec::new();
    for from_ends in [true, false] {
        for (&vertex, others) in neighbours.iter().filter(|(v, _)| is_end(v) == from_ends) {
            guides.extend(others.iter().filter_map(|&other| walk(vertex, other)));
        }
    }
    guides
}

/// The vertices of the baseline along a path of the cage.
pub(super) fn refined_path(baseline: &Baseline, cage: &[VertexId]) -> Vec<VertexId> {
    let mut path = cage.to_vec();
    for parent in baseline.parents() {
        let numbering = Numbering::new(parent);
        let mut fine = Vec::with_capacity(2 * path.len());
        for pair in path.windows(2) {
            fine.push(pair[0]);
            fine.extend(parent.topology.find_edge(pair[0], pair[1]).map(|e| numbering.of_edge(e)));
        }
        fine.extend(path.last());
        path = fine;
    }
    path
}
