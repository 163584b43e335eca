//! A triangle mesh that can be edited: split, collapse and flip.
//!
//! Half-edges are corners: corner `c` leaves its vertex towards the next corner of its triangle. Every edit documents the
//! corners that it makes or removes, so that attributes can follow; nothing here knows positions.

mod operations;

use super::{CornerId, FaceId, IdVec, VertexId};
use std::collections::BTreeSet;

/// A manifold, oriented triangle mesh under edit. Removed triangles and vertices stay as gaps until [`compact`].
///
/// [`compact`]: EditMesh::compact
#[derive(Clone, Debug, Default)]
pub struct EditMesh {
    corner_vertex: IdVec<CornerId, VertexId>,
    twin: IdVec<CornerId, Option<CornerId>>,
    /// A corner of each vertex; for vertices on a border the one that leaves along it.
    vertex_corner: IdVec<VertexId, Option<CornerId>>,
    alive: IdVec<FaceId, bool>,
}

impl EditMesh {
    /// A mesh of `triangles` over `vertices` vertices.
    ///
    /// Half-edges are paired where exactly two meet in opposite directions; all others are borders.
    pub fn new(triangles: &[[VertexId; 3]], vertices: usize) -> Self {
        let corner_vertex: IdVec<CornerId, VertexId> = triangles.iter().flatten().copied().collect();
        let mut mesh = Self {
            twin: IdVec::filled(None, corner_vertex.len()),
            vertex_corner: IdVec::filled(None, vertices),
            alive: IdVec::filled(true, triangles.len()),
            corner_vertex,
        };
        mesh.pair();
        mesh.set_vertex_corners();
        mesh
    }

    /// A mesh of consistent half-edges over `vertices` vertices.
    pub(super) fn from_parts(
        corner_vertex: IdVec<CornerId, VertexId>,
        twin: IdVec<CornerId, Option<CornerId>>,
        vertices: usize,
    ) -> Self {
        let alive = IdVec::filled(true, corner_vertex.len() / 3);
        let mut mesh = Self { corner_vertex, twin, vertex_corner: IdVec::filled(None, vertices), alive };
        mesh.set_vertex_corners();
        mesh
    }

    fn set_vertex_corners(&mut self) {
        for corner in self.corner_vertex.ids() {
            let slot = &mut self.vertex_corner[self.corner_vertex[corner]];
            if slot.is_none() || self.twin[corner].is_none() {
                *slot = Some(corner);
            }
        }
    }

    fn pair(&mut self) {
        // The first half-edge between two vertices is in a list at the one with fewer corners: the other may be a pole of all.
        // On a planar graph these lists have a linear sum (Chiba and Nishizeki 1985, *Arboricity and Subgraph Listing*).
        let mut corners = IdVec::<VertexId, u32>::filled(0, self.vertex_corner.len());
        self.corner_vertex.iter().for_each(|&v| corners[v] += 1);
        let mut first = IdVec::<VertexId, Option<CornerId>>::filled(None, self.vertex_corner.len());
        let mut after = IdVec::<CornerId, Option<CornerId>>::filled(None, self.corner_vertex.len());
        // Edges of more than two half-edges, or of two in the same direction.
        let mut crowded = BTreeSet::new();
        for half in self.corner_vertex.ids() {
            let (a, b) = (self.corner_vertex[half], self.corner_vertex[next(half)]);
            let [list, other] = if (corners[a], a) < (corners[b], b) { [a, b] } else { [b, a] };
            let mut at = first[list];
            while let Some(c) = at.filter(|&c| self.vertex(c) != other && self.target(c) != other) {
                at = after[c];
            }
            match at {
                None => after[half] = first[list].replace(half),
                Some(c) if self.twin[c].is_none() && !crowded.contains(&c) && self.corner_vertex[c] != a => {
                    self.pair_up(c, half);
                }
                Some(c) => {
                    crowded.insert(c);
                    if let Some(t) = self.twin[c].take() {
                        self.twin[t] = None;
                    }
                }
            }
        }
    }

    /// All corners of triangles that exist.
    pub fn corners(&self) -> impl Iterator<Item = CornerId> + '_ {
        self.corner_vertex.ids().filter(|&c| self.alive[face(c)])
    }

    /// All triangles that exist.
    pub fn faces(&self) -> impl Iterator<Item = FaceId> + '_ {
        self.alive.enumerated().filter(|(_, a)| **a).map(|(f, _)| f)
    }

    /// One half-edge of each edge: the lower of two.
    pub fn edges(&self) -> impl Iterator<Item = CornerId> + '_ {
        self.corners().filter(|&c| self.twin[c].is_none_or(|t| c < t))
    }

    /// Whether a half-edge exists and represents its edge: the lower of two.
    #[inline]
    pub fn is_edge(&self, half: CornerId) -> bool {
        self.alive[face(half)] && self.twin[half].is_none_or(|t| half < t)
    }

    /// All vertices that have a triangle.
    pub fn vertices(&self) -> impl Iterator<Item = VertexId> + '_ {
        self.vertex_corner.enumerated().filter(|(_, c)| c.is_some()).map(|(v, _)| v)
    }

    /// Whether a vertex has a triangle.
    #[inline]
    pub fn has_faces(&self, vertex: VertexId) -> bool {
        self.vertex_corner[vertex].is_some()
    }

    /// Number of vertex slots, gaps included.
    pub fn vertex_slots(&self) -> usize {
        self.vertex_corner.len()
    }

    /// Number of corner slots, gaps included.
    pub fn corner_slots(&self) -> usize {
        self.corner_vertex.len()
    }

    /// Number of triangle slots, gaps included.
    pub fn face_slots(&self) -> usize {
        self.alive.len()
    }

    /// Number of triangles.
    pub fn face_count(&self) -> usize {
        self.alive.iter().filter(|a| **a).count()
    }

    /// Whether the corner's triangle exists.
    #[inline]
    pub fn is_alive(&self, corner: CornerId) -> bool {
        self.alive[face(corner)]
    }

    /// The vertex of a corner.
    #[inline]
    pub fn vertex(&self, corner: CornerId) -> VertexId {
        self.corner_vertex[corner]
    }

    /// The vertex that a half-edge goes to.
    #[inline]
    pub fn target(&self, corner: CornerId) -> VertexId {
        self.corner_vertex[next(corner)]
    }

    /// The vertices at the start and end of a half-edge.
    #[inline]
    pub fn ends(&self, half: CornerId) -> [VertexId; 2] {
        [self.vertex(half), self.target(half)]
    }

    /// The end of an edge that is not `vertex`.
    #[inline]
    pub fn other_end(&self, half: CornerId, vertex: VertexId) -> VertexId {
        if self.vertex(half) == vertex { self.target(half) } else { self.vertex(half) }
    }

    /// The vertices of a triangle.
    #[inline]
    pub fn triangle(&self, f: FaceId) -> [VertexId; 3] {
        let own = &self.corner_vertex.as_slice()[3 * f.index()..3 * f.index() + 3];
        [own[0], own[1], own[2]]
    }

    /// The opposite half-edge; none at a border.
    #[inline]
    pub fn twin(&self, corner: CornerId) -> Option<CornerId> {
        self.twin[corner]
    }

    /// Whether a vertex is on a border.
    pub fn is_border_vertex(&self, vertex: VertexId) -> bool {
        self.vertex_corner[vertex].is_some_and(|c| self.twin[c].is_none())
    }

    /// The corners at a vertex, counter-clockwise; from border to border where there is one.
    #[inline]
    pub fn fan(&self, vertex: VertexId) -> impl Iterator<Item = CornerId> + '_ {
        let first = self.vertex_corner[vertex];
        std::iter::successors(first, move |&c| self.twin[prev(c)].filter(|&c| Some(c) != first))
    }

    /// The neighbours of a vertex, each once.
    #[inline]
    pub fn ring(&self, vertex: VertexId) -> impl Iterator<Item = VertexId> + '_ {
        self.spokes(vertex).map(move |c| self.other_end(c, vertex))
    }

    /// A half-edge of each edge at a vertex: those that leave it, and at a border the last one, which arrives.
    #[inline]
    pub fn spokes(&self, vertex: VertexId) -> impl Iterator<Item = CornerId> + '_ {
        let first = self.vertex_corner[vertex];
        let mut at = first;
        let mut leaves = true;
        std::iter::from_fn(move || {
            let own = at?;
            if !leaves {
                at = None;
                return Some(own);
            }
            let arriving = prev(own);
            match self.twin[arriving] {
                Some(twin) => at = Some(twin).filter(|_| Some(twin) != first),
                None => (at, leaves) = (Some(arriving), false),
            }
            Some(own)
        })
    }

    /// The half-edge between two vertices, in either direction.
    pub fn find(&self, a: VertexId, b: VertexId) -> Option<CornerId> {
        self.fan(a).find_map(|c| {
            if self.target(c) == b {
                Some(c)
            } else if self.vertex(prev(c)) == b {
                Some(prev(c))
            } else {
                None
            }
        })
    }
}

/// The next corner of the triangle.
#[inline]
pub fn next(corner: CornerId) -> CornerId {
    let c = corner.index();
    CornerId::new(if c % 3 == 2 { c - 2 } else { c + 1 })
}

/// The previous corner of the triangle.
#[inline]
pub fn prev(corner: CornerId) -> CornerId {
    let c = corner.index();
    CornerId::new(if c.is_multiple_of(3) { c + 2 } else { c - 1 })
}

/// The corners of a triangle.
#[inline]
pub fn corners(f: FaceId) -> impl Iterator<Item = CornerId> {
    (0..3).map(move |k| CornerId::new(3 * f.index() + k))
}

/// The triangle of a corner.
#[inline]
pub fn face(corner: CornerId) -> FaceId {
    FaceId::new(corner.index() / 3)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of `n` by `n` squares, each two triangles.
    fn grid(n: usize) -> EditMesh {
        let v = |x: usize, y: usize| VertexId::new(y * (n + 1) + x);
        let mut triangles = Vec::new();
        for y in 0..n {
            for x in 0..n {
                triangles.push([v(x, y), v(x + 1, y), v(x + 1, y + 1)]);
                triangles.push([v(x, y), v(x + 1, y + 1), v(x, y + 1)]);
            }
        }
        EditMesh::new(&triangles, (n + 1) * (n + 1))
    }

    fn euler(mesh: &EditMesh) -> i64 {
        mesh.vertices().count() as i64 - mesh.edges().count() as i64 + mesh.face_count() as i64
    }

    #[test]
    fn every_edit_keeps_the_mesh_consistent() {
        let mut mesh = grid(4);
        mesh.assert_consistent();
        for round in 0..400usize {
            let halves: Vec<CornerId> = mesh.corners().collect();
            let half = halves[(round * 7919) % halves.len()];
            match round % 3 {
                0 => {
                    mesh.split(half);
                }
                1 if mesh.may_collapse(half) => {
                    mesh.collapse(half, if round % 2 == 0 { mesh.vertex(half) } else { mesh.target(half) });
                }
                2 if mesh.may_flip(half) => {
                    mesh.flip(half);
                }
                _ => {}
            }
            mesh.assert_consistent();
            assert_eq!(euler(&mesh), 1, "still a disc after edit {round}");
        }
    }

    #[test]
    fn an_edge_turns_back_as_if_it_went_all_the_way_round() {
        let mesh = grid(4);
        let three = |mesh: &mut EditMesh, half| (0..3).for_each(|_| assert!(mesh.flip(half).is_some()));
        let pairs = mesh.corners().flat_map(|a| mesh.corners().map(move |b| [a, b]));
        for [first, second] in pairs.filter(|&[a, b]| a != b && mesh.may_flip(a)) {
            // The second edge turns there and back in between, which may change where its vertices begin.
            let (mut back, mut round) = (mesh.clone(), mesh.clone());
            [&mut back, &mut round].into_iter().for_each(|m| assert!(m.flip(first).is_some()));
            if back.may_flip(second) {
                [&mut back, &mut round].into_iter().for_each(|m| assert!(m.flip(second).is_some()));
                back.unflip(second);
                three(&mut round, second);
            }
            back.unflip(first);
            three(&mut round, first);
            back.assert_consistent();
            assert!(mesh.corners().all(|c| back.vertex(c) == mesh.vertex(c) && back.twin(c) == mesh.twin(c)));
            assert_eq!(back.vertex_corner, round.vertex_corner);
        }
    }

    #[test]
    fn a_lone_triangle_is_not_collapsed() {
        let mesh = EditMesh::new(&[[0, 1, 2].map(VertexId::new)], 3);
        assert!(mesh.corners().all(|c| !mesh.may_collapse(c)));
    }
}
