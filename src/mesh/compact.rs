//! A mesh without the gaps that editing left.

use super::edit::{EditMesh, face};
use super::{CornerId, FaceId, IdVec, VertexId};

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

/// A mesh in another order, and where its elements were before.
#[derive(Clone, Debug)]
pub struct Reordered {
    /// The mesh.
    pub mesh: EditMesh,
    /// The old vertex of each new one.
    pub old_vertex: IdVec<VertexId, VertexId>,
    /// The old corner of each new one.
    pub old_corner: IdVec<CornerId, CornerId>,
}

impl EditMesh {
    /// Drops the gaps, and puts triangles in the order of `faces`, which are all that are there, and vertices in that of
    /// their first triangles.
    pub fn reordered(&self, faces: &[FaceId]) -> Reordered {
        let mut new_face = IdVec::<FaceId, Option<FaceId>>::filled(None, self.face_slots());
        faces.iter().enumerate().for_each(|(new, &old)| new_face[old] = Some(FaceId::new(new)));
        let new_corner = |c: CornerId| Some(CornerId::new(3 * new_face[face(c)]?.index() + c.index() % 3));
        let mut new_vertex = IdVec::<VertexId, Option<VertexId>>::filled(None, self.vertex_slots());
        let mut old_vertex = IdVec::with_capacity(faces.len() / 2 + 2);
        let mut old_corner = IdVec::with_capacity(3 * faces.len());
        let mut corner_vertex = IdVec::with_capacity(3 * faces.len());
        let mut twin = IdVec::with_capacity(3 * faces.len());
        for c in faces.iter().flat_map(|f| (0..3).map(|k| CornerId::new(3 * f.index() + k))) {
            let v = self.vertex(c);
            corner_vertex.push(*new_vertex[v].get_or_insert_with(|| old_vertex.push(v)));
            twin.push(self.twin(c).and_then(new_corner));
            old_corner.push(c);
        }
        let vertex_corner = old_vertex.iter().map(|&v| self.fan(v).next().and_then(new_corner)).collect();
        let mesh = Self::from_parts(corner_vertex, twin, vertex_corner);
        Reordered { mesh, old_vertex, old_corner }
    }

    /// Drops the gaps.
    pub fn compact(&self) -> Compact {
        let mut new_of = IdVec::<VertexId, Option<VertexId>>::filled(None, self.vertex_slots());
        let mut old_of = IdVec::new();
        for v in self.vertices() {
            new_of[v] = Some(old_of.push(v));
        }
        let mut triangles = Vec::with_capacity(self.face_slots());
        let mut corners = IdVec::new();
        for f in self.faces() {
            let vertices = self.triangle(f).map(|v| new_of[v]);
            if let [Some(a), Some(b), Some(c)] = vertices {
                triangles.push([a, b, c]);
                corners.extend((0..3).map(|k| CornerId::new(f.index() * 3 + k)));
            }
        }
        Compact { triangles, old_vertex: old_of, old_corner: corners }
    }
}
