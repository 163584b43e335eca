//! Submeshes: some triangles of a mesh as a mesh of its own, and meshes joined again.

use super::edit::{EditMesh, corners, face, next, prev};
use super::{CornerId, FaceId, IdVec, VertexId};

/// Some triangles of a mesh as a mesh, and the elements behind its own.
#[derive(Clone, Debug)]
pub struct Submesh {
    /// The triangles.
    pub mesh: EditMesh,
    /// The old vertex behind each vertex. Fans that only touch have vertices of their own.
    pub old_vertex: IdVec<VertexId, VertexId>,
    /// The old corner behind each corner.
    pub old_corner: IdVec<CornerId, CornerId>,
}

/// Joined meshes, and the elements behind their own.
#[derive(Clone, Debug)]
pub struct JoinedMesh {
    /// The mesh. Its corners are those of the parts in sequence.
    pub mesh: EditMesh,
    /// The part and the vertex in it behind each vertex.
    pub old_vertex: IdVec<VertexId, (usize, VertexId)>,
    /// Half-edges that were joined to each other.
    pub seams: Vec<[CornerId; 2]>,
    /// The vertices that parts may share.
    pub shared: Vec<VertexId>,
}

impl EditMesh {
    /// The mesh without gaps. Triangles are in the order of `faces`, which lists them all, vertices in that of their first
    /// triangles.
    pub fn reordered(&self, faces: &[FaceId]) -> Submesh {
        let mut place = IdVec::<FaceId, Option<FaceId>>::filled(None, self.face_slots());
        faces.iter().enumerate().for_each(|(new, &old)| place[old] = Some(FaceId::new(new)));
        self.submesh(faces, |f| place[f].map(FaceId::index))
    }

    /// The triangles `faces` in their order; `place` is the index of a triangle among them. Edges to others become borders.
    pub fn submesh(&self, faces: &[FaceId], place: impl Fn(FaceId) -> Option<usize>) -> Submesh {
        let local = |c: CornerId| Some(CornerId::new(3 * place(face(c))? + c.index() % 3));
        let old_corner: IdVec<CornerId, CornerId> = faces.iter().flat_map(|&f| corners(f)).collect();
        let twin: IdVec<CornerId, Option<CornerId>> =
            old_corner.iter().map(|&c| self.twin(c).and_then(local)).collect();
        let mut vertex: IdVec<CornerId, Option<VertexId>> = IdVec::filled(None, old_corner.len());
        let mut old_vertex = IdVec::with_capacity(faces.len() / 2 + 2);
        for first in old_corner.ids() {
            if vertex[first].is_some() {
                continue;
            }
            let own = Some(old_vertex.push(self.vertex(old_corner[first])));
            let mut at = Some(first);
            while let Some(c) = at.filter(|&c| vertex[c].is_none()) {
                vertex[c] = own;
                at = twin[prev(c)];
            }
            at = twin[first].map(next);
            while let Some(c) = at.filter(|&c| vertex[c].is_none()) {
                vertex[c] = own;
                at = twin[c].map(next);
            }
        }
        let vertex = vertex.iter().flatten().copied().collect();
        Submesh { mesh: Self::from_parts(vertex, twin, old_vertex.len()), old_vertex, old_corner }
    }
}

/// Joins meshes without gaps at the vertices with equal names, all below `names`. None if more than two half-edges meet
/// between the same two vertices.
pub fn join_meshes(parts: &[(&EditMesh, &IdVec<VertexId, Option<VertexId>>)], names: usize) -> Option<JoinedMesh> {
    let slots = parts.iter().map(|(mesh, _)| mesh.corner_slots()).sum();
    let mut named = IdVec::<VertexId, Option<VertexId>>::filled(None, names);
    let mut old_vertex = IdVec::with_capacity(slots / 6 + 2);
    let (mut vertex, mut twin) = (IdVec::with_capacity(slots), IdVec::with_capacity(slots));
    let mut rim: Vec<([VertexId; 2], CornerId)> = Vec::new();
    for (i, &(mesh, names)) in parts.iter().enumerate() {
        let first = vertex.len();
        let new: IdVec<VertexId, VertexId> = names
            .enumerated()
            .map(|(v, name)| match *name {
                Some(name) => *named[name].get_or_insert_with(|| old_vertex.push((i, v))),
                None => old_vertex.push((i, v)),
            })
            .collect();
        for c in (0..mesh.corner_slots()).map(CornerId::new) {
            let own = vertex.push(new[mesh.vertex(c)]);
            twin.push(mesh.twin(c).map(|t| CornerId::new(first + t.index())));
            if let (None, Some(a), Some(b)) = (mesh.twin(c), names[mesh.vertex(c)], names[mesh.target(c)]) {
                rim.push(([a.min(b), a.max(b)], own));
            }
        }
    }
    rim.sort_unstable();
    let mut seams = Vec::with_capacity(rim.len() / 2);
    for group in rim.chunk_by(|a, b| a.0 == b.0) {
        match *group {
            [_] => {}
            [(_, a), (_, b)] if vertex[a] == vertex[next(b)] => {
                (twin[a], twin[b]) = (Some(b), Some(a));
                seams.push([a, b]);
            }
            _ => return None,
        }
    }
    let mesh = EditMesh::from_parts(vertex, twin, old_vertex.len());
    Some(JoinedMesh { mesh, old_vertex, seams, shared: named.iter().flatten().copied().collect() })
}
