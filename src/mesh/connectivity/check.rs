//! Every invariant of an edited mesh, for debug builds and tests.

use super::edit::{EditMesh, prev};
use super::{IdVec, VertexId};

impl EditMesh {
    /// Panics where a half-edge, a fan or a handle is inconsistent.
    pub fn assert_consistent(&self) {
        let mut at_vertex = IdVec::<VertexId, usize>::filled(0, self.vertex_slots());
        for c in self.corners() {
            at_vertex[self.vertex(c)] += 1;
            assert_ne!(self.vertex(c), self.target(c), "{c:?} connects two vertices");
            if let Some(t) = self.twin(c) {
                assert!(self.is_alive(t), "the twin of {c:?} exists");
                assert_eq!(self.twin(t), Some(c), "{c:?} is its twin's twin");
                assert_eq!(
                    (self.vertex(t), self.target(t)),
                    (self.target(c), self.vertex(c)),
                    "{c:?} and its twin are opposite"
                );
            }
        }
        for (v, &count) in at_vertex.enumerated() {
            assert_eq!(self.fan(v).count(), count, "the corners of {v:?} are one fan");
            assert!(
                self.fan(v)
                    .next()
                    .is_none_or(|c| self.twin(c).is_none() || self.fan(v).all(|c| self.twin(prev(c)).is_some())),
                "the fan of {v:?} begins at its border"
            );
            assert!(self.fan(v).all(|c| self.vertex(c) == v && self.is_alive(c)), "the fan of {v:?} is its own");
        }
    }
}
