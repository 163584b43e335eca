//! Reordering and submeshes. Elements near each other on the baseline get near numbers, which keeps passes in the cache.

use super::SimMesh;
use tailor_mesh::connectivity::{CornerId, FaceId, IdVec, Submesh, VertexId};

impl SimMesh<'_> {
    /// Orders triangles by their baseline triangles and vertices by their triangles, and drops gaps. Returns the old vertex
    /// of each new one.
    pub(super) fn reorder(&mut self) -> IdVec<VertexId, VertexId> {
        let submesh = self.topology.reordered(&self.faces_by_location());
        let old_vertex = submesh.old_vertex.clone();
        *self = self.submesh(submesh);
        old_vertex
    }

    /// Everything that this mesh carries, for some of its triangles.
    pub(super) fn submesh(&self, submesh: Submesh) -> Self {
        let Submesh { mesh: topology, old_vertex, old_corner } = submesh;
        let mut mesh = Self {
            points: old_vertex.iter().map(|&v| self.points[v]).collect(),
            target: old_vertex.iter().map(|&v| self.target[v]).collect(),
            constraint: old_vertex.iter().map(|&v| self.constraint[v]).collect(),
            wedges: IdVec::with_capacity(old_vertex.len()),
            ..Self::empty(self.baseline, topology)
        };
        for (half, &old) in old_corner.enumerated() {
            if let (None, Some(span)) = (mesh.corner_span[half], self.span(old)) {
                mesh.add_span(half, span);
            }
        }
        mesh.make_wedges(|c| *self.wedge(old_corner[c]));
        mesh
    }

    /// The triangles, sorted by the baseline triangle of their first corner, then by id.
    fn faces_by_location(&self) -> Vec<FaceId> {
        let key = |f: FaceId| (self.place(CornerId::new(3 * f.index())).location.face, f);
        let mut faces: Vec<(FaceId, FaceId)> = self.topology.faces().map(key).collect();
        faces.sort_unstable();
        faces.into_iter().map(|(_, f)| f).collect()
    }
}
