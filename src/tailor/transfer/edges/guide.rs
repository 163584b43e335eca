//! Guides: unbranched paths of an edge set that are not constraints, and their curves on the baseline.

use super::polyline::Polyline;
use crate::sim::Baseline;
use crate::transfer::topology::edge_key;
use std::collections::{BTreeMap, BTreeSet};
use tailor_mesh::connectivity::{IdVec, VertexId};
use tailor_mesh::subdivide::Numbering;

/// An unbranched path of an edge set.
pub(super) struct Guide {
    /// Its vertices on the cage.
    cage: Vec<VertexId>,
    /// Whether it closes without an end.
    pub is_loop: bool,
    /// Its vertices on the baseline.
    pub vertices: Vec<VertexId>,
    pub curve: Polyline,
}

impl Guide {
    fn new(baseline: &Baseline, cage: Vec<VertexId>, is_loop: bool) -> Self {
        let vertices = refined_path(baseline, &cage);
        let curve = Polyline::new(&vertices, &baseline.points, cage.first() == cage.last());
        Self { cage, is_loop, vertices, curve }
    }

    /// The first and the last cage vertex.
    pub fn ends(&self) -> [VertexId; 2] {
        [self.cage[0], self.cage[self.cage.len() - 1]]
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
        let (mut path, mut here) = (vec![start, second], second);
        while !is_end(&here) && here != start {
            let Some(&next) = neighbours[&here].iter().find(|&&n| used.insert(edge_key([here, n]))) else { break };
            path.push(next);
            here = next;
        }
        Some(Guide::new(baseline, path, here == start && !is_end(&start)))
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
