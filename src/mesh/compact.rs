//! A mesh without the gaps that editing left.

use super::edit::{EditMesh, corners};
use super::{CornerId, IdVec, VertexId};

/// A mesh without gaps, and where its elements were before.
#[derive(Clone, Debug)]
pub struct Compact {
    /// The triangles.
    pub triangles: Vec<[VertexId; 3]>,
    /// The old vertex of each new one.
    pub old_vertex: IdVec<VertexId, VertexId>,
    /// The old corner of each new one.
    pub old_corner: IdVec<CornerId, CornerId>,
}

impl EditMesh {
    /// Drops the gaps.
    pub fn compact(&self) -> Compact {
        let mut new_of = IdVec::<VertexId, Option<VertexId>>::filled(None, self.vertex_slots());
        let mut old_of = IdVec::new();
        for v in self.vertices() {
            new_of[v] = Some(old_of.push(v));
        }
        let mut triangles = Vec::with_capacity(self.face_slots());
        let mut old_corner = IdVec::new();
        for f in self.faces() {
            let vertices = self.triangle(f).map(|v| new_of[v]);
            if let [Some(a), Some(b), Some(c)] = vertices {
                triangles.push([a, b, c]);
                old_corner.extend(corners(f));
            }
        }
        Compact { triangles, old_vertex: old_of, old_corner }
    }
}
