//! Every invariant of the mesh, for debug builds and tests.

use super::{SimMesh, VertexConstraint};
use tailor_mesh::connectivity::{CornerId, VertexId};

/// Distance of a vertex from its location and its curve, as a share of the target length.
const SLACK: f32 = 1e-3;
/// Rounding of that distance, as a share of the largest coordinate. Of a mesh of many small pieces, the target length may be no more
/// than some thousand times the step between two floats.
const ROUNDING: f32 = 8.0 * f32::EPSILON;

impl SimMesh<'_> {
    /// Panics where an invariant of the mesh is broken.
    pub fn assert_consistent(&self) {
        self.topology.assert_consistent();
        for half in self.topology.corners() {
            self.assert_span(half);
            let own = self.topology.vertex(half);
            let off = self.baseline.position(self.place(half).location).distance(self.points[own]);
            assert!(off <= self.slack(own), "{own:?} is at its corner's location: off by {off}");
        }
        for vertex in self.topology.vertices().filter(|&v| self.constraint[v] == VertexConstraint::Free) {
            let mut wedges = self.topology.fan(vertex).map(|c| self.corner_wedge[c]);
            let first = wedges.next();
            assert!(wedges.all(|s| Some(s) == first), "{vertex:?} is free and has one wedge");
        }
    }

    fn assert_span(&self, half: CornerId) {
        let ends = self.topology.ends(half);
        let twin = self.topology.twin(half);
        let Some(span) = self.span(half) else {
            assert!(
                self.is_patch_border(half) || twin.is_some_and(|t| self.span(t).is_none()),
                "borders are chains, and both halves are free"
            );
            return;
        };
        let chain = self.chain(span.chain);
        let count = (chain.count_to(span.to) - chain.count_to(span.from)).abs();
        assert!((span.count() - count).abs() <= SLACK * count.max(1.0), "{half:?} counts {} of {count}", span.count());
        for (v, s) in ends.into_iter().zip([span.from, span.to]) {
            assert!(self.constraint[v] != VertexConstraint::Free, "chain ends are constrained");
            let p = self.on_curve(span.chain, s);
            let off = p.distance(self.points[v]);
            assert!(off <= self.slack(v), "{v:?} is on its curve: off by {off}");
        }
        if let Some(t) = twin {
            assert_eq!(self.span(t), Some(span.reversed()), "the twin of {half:?} has the same span");
        }
    }

    /// The largest distance of a vertex from where it should be. \[mesh units\]
    fn slack(&self, vertex: VertexId) -> f32 {
        SLACK * self.target[vertex] + ROUNDING * self.points[vertex].abs().max_element()
    }

    /// Checks every invariant in debug builds.
    pub fn debug_check(&self) {
        if cfg!(debug_assertions) {
            self.assert_consistent();
        }
    }
}
