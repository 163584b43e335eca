//! Elements that are near each other on the baseline get numbers near each other, so that a pass finds most of what it
//! needs in the cache.

use crate::mesh::{CornerId, FaceId, IdVec, Part, VertexId, WedgeId};
use crate::sim::sim_mesh::SimMesh;

impl SimMesh<'_> {
    /// Numbers triangles by their places on the baseline and vertices by their triangles, and drops what is gone. Returns
    /// the old vertex of each new one.
    pub(crate) fn reorder(&mut self) -> IdVec<VertexId, VertexId> {
        let part = self.topology.reordered(&self.faces_by_place());
        let old_vertex = part.old_vertex.clone();
        *self = self.gathered(part);
        old_vertex
    }

    /// What this mesh has, for a part of it.
    pub(crate) fn gathered(&self, part: Part) -> Self {
        let Part { mesh: topology, old_vertex, old_corner } = part;
        let corners = topology.corner_slots();
        let mut mesh = Self {
            baseline: self.baseline,
            points: old_vertex.iter().map(|&v| self.points[v]).collect(),
            target: old_vertex.iter().map(|&v| self.target[v]).collect(),
            constraint: old_vertex.iter().map(|&v| self.constraint[v]).collect(),
            mark: IdVec::filled(None, corners),
            spans: IdVec::new(),
            corner_wedge: IdVec::filled(WedgeId::new(0), corners),
            wedges: IdVec::with_capacity(old_vertex.len()),
            patch_vertices: IdVec::new(),
            topology,
        };
        for (half, &old) in old_corner.enumerated() {
            if let (None, Some(span)) = (mesh.mark[half], self.span(old)) {
                mesh.add_span(half, span);
            }
        }
        mesh.make_wedges(|c| *self.wedge(old_corner[c]));
        mesh
    }

    /// The triangles by the baseline's triangle at their first corners; of equals the older first.
    fn faces_by_place(&self) -> Vec<FaceId> {
        let place = |f: FaceId| (self.place(CornerId::new(3 * f.index())).location.face, f);
        let mut faces: Vec<(FaceId, FaceId)> = self.topology.faces().map(place).collect();
        faces.sort_unstable();
        faces.into_iter().map(|(_, f)| f).collect()
    }
}
