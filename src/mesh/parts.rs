//! Parts of a mesh as meshes of their own, and parts joined again after they were edited.

use super::edit::{EditMesh, face, next, prev};
use super::{CornerId, FaceId, IdVec, VertexId};

/// Some triangles of a mesh as a mesh, and where its elements were.
#[derive(Clone, Debug)]
pub struct Part {
    /// The triangles.
    pub mesh: EditMesh,
    /// The old vertex of each new one. Fans that only touch have vertices of their own.
    pub old_vertex: IdVec<VertexId, VertexId>,
    /// The old corner of each new one.
    pub old_corner: IdVec<CornerId, CornerId>,
}

/// A part that is to be joined to others.
pub struct Piece<'a> {
    /// The part.
    pub mesh: &'a EditMesh,
    /// Its triangles, in the order that they shall have.
    pub order: Vec<FaceId>,
    /// What other parts call its vertices; none for those that no other part has, which may be left out at the end.
    pub names: &'a IdVec<VertexId, Option<VertexId>>,
}

/// Parts joined, and where their elements were.
#[derive(Clone, Debug)]
pub struct Joined {
    /// The mesh.
    pub mesh: EditMesh,
    /// The part of each vertex, and what it was there; of a shared one, the first part.
    pub old_vertex: IdVec<VertexId, (usize, VertexId)>,
    /// The same for corners.
    pub old_corner: IdVec<CornerId, (usize, CornerId)>,
}

impl EditMesh {
    /// The triangles `faces` in their order; `place` tells where there a triangle is, if it is one of them. Edges to
    /// others become borders.
    pub fn part(&self, faces: &[FaceId], place: impl Fn(FaceId) -> Option<usize>) -> Part {
        let local = |c: CornerId| Some(CornerId::new(3 * place(face(c))? + c.index() % 3));
        let old_corner: IdVec<CornerId, CornerId> = faces.iter().flat_map(|&f| corners_of(f)).collect();
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
        Part { mesh: Self::from_parts(vertex, twin, old_vertex.len()), old_vertex, old_corner }
    }
}

/// Joins parts where they have the same names, which are below `names`. None where more than two half-edges meet
/// between the same two vertices.
pub fn join(pieces: &[Piece<'_>], names: usize) -> Option<Joined> {
    let faces: usize = pieces.iter().map(|p| p.order.len()).sum();
    let mut named = IdVec::<VertexId, Option<VertexId>>::filled(None, names);
    let mut old_vertex = IdVec::with_capacity(faces / 2 + 2);
    let mut old_corner = IdVec::with_capacity(3 * faces);
    let mut vertex = IdVec::with_capacity(3 * faces);
    let mut twin = IdVec::with_capacity(3 * faces);
    let mut rim: Vec<([VertexId; 2], CornerId)> = Vec::new();
    for (i, piece) in pieces.iter().enumerate() {
        let mesh = piece.mesh;
        let name = |v: VertexId| piece.names.get(v.index()).copied().flatten();
        let mut new_face = IdVec::<FaceId, Option<FaceId>>::filled(None, mesh.face_slots());
        for (k, &f) in piece.order.iter().enumerate() {
            new_face[f] = Some(FaceId::new(old_corner.len() / 3 + k));
        }
        let new_corner = |c: CornerId| Some(CornerId::new(3 * new_face[face(c)]?.index() + c.index() % 3));
        let mut new_vertex = IdVec::<VertexId, Option<VertexId>>::filled(None, mesh.vertex_slots());
        for c in piece.order.iter().flat_map(|&f| corners_of(f)) {
            let v = mesh.vertex(c);
            let mut push = || old_vertex.push((i, v));
            let new = new_vertex[v].get_or_insert_with(|| match name(v) {
                Some(name) => *named[name].get_or_insert_with(push),
                None => push(),
            });
            let own = vertex.push(*new);
            twin.push(mesh.twin(c).and_then(new_corner));
            old_corner.push((i, c));
            if let (None, Some(a), Some(b)) = (mesh.twin(c), name(v), name(mesh.target(c))) {
                rim.push(([a.min(b), a.max(b)], own));
            }
        }
    }
    rim.sort_unstable();
    for group in rim.chunk_by(|a, b| a.0 == b.0) {
        match *group {
            [_] => {}
            [(_, a), (_, b)] if vertex[a] == vertex[next(b)] => (twin[a], twin[b]) = (Some(b), Some(a)),
            _ => return None,
        }
    }
    let mesh = EditMesh::from_parts(vertex, twin, old_vertex.len());
    Some(Joined { mesh, old_vertex, old_corner })
}

/// The corners of a triangle.
fn corners_of(f: FaceId) -> impl Iterator<Item = CornerId> {
    (0..3).map(move |k| CornerId::new(3 * f.index() + k))
}
