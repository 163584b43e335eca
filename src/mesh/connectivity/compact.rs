//! Removal of the gaps that edits leave.

use super::edit::EditMesh;
use super::{CornerId, IdVec, VertexId};

/// A mesh without gaps, and the elements behind its own.
#[derive(Clone, Debug)]
pub struct Compact {
    /// The triangles.
    pub triangles: Vec<[VertexId; 3]>,
    /// The old vertex behind each vertex.
    pub old_vertex: IdVec<VertexId, VertexId>,
    /// The old corner behind each corner.
    pub old_corner: IdVec<CornerId, CornerId>,
}

impl EditMesh {
    /// The mesh without gaps, in the same order.
    pub fn compact(&self) -> Compact {
        let old_vertex: IdVec<VertexId, VertexId> = self.vertices().collect();
        let mut new_vertex: IdVec<VertexId, VertexId> = (0..self.vertex_slots()).map(VertexId::new).collect();
        old_vertex.enumerated().for_each(|(new, &old)| new_vertex[old] = new);
        let triangles = self.faces().map(|f| self.triangle(f).map(|v| new_vertex[v])).collect();
        Compact { triangles, old_vertex, old_corner: self.corners().collect() }
    }
}
