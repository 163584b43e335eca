//! A triangle mesh that can be edited: split, collapse and flip.
//!
//! Half-edges are corners: corner `c` leaves its vertex towards the next corner of its triangle. Every edit documents the
//! corners that it makes or removes, so that attributes can follow; nothing here knows positions.

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

/// The new half-edges of [`EditMesh::split`].
#[derive(Clone, Copy, Debug)]
pub struct Split {
    /// The half-edge from the new vertex to the old end; its triangle is new.
    pub ahead: CornerId,
    /// The half-edge from the new vertex to the old start, in a new triangle; none at a border.
    pub behind: Option<CornerId>,
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

    /// Inserts a vertex in an edge. The triangle `(a, b, c)` of the half-edge becomes `(a, m, c)` and gains `(m, b, c)`;
    /// on the other side `(b, a, d)` becomes `(b, m, d)` and gains `(m, a, d)`.
    pub fn split(&mut self, half: CornerId) -> Split {
        let m = self.vertex_corner.push(None);
        let other = self.twin[half];
        let ahead = self.split_side(half, m);
        let behind = other.map(|o| self.split_side(o, m));
        if let (Some(o), Some(behind)) = (other, behind) {
            self.pair_up(half, behind);
            self.pair_up(ahead, o);
        }
        // At a border the half-edge ahead leaves along it.
        self.vertex_corner[m] = Some(ahead);
        Split { ahead, behind }
    }

    /// One side of a split: `half` now ends at `m`; returns the half-edge from `m` on, in the new triangle.
    fn split_side(&mut self, half: CornerId, m: VertexId) -> CornerId {
        let (n, p) = (next(half), prev(half));
        let (b, c) = (self.corner_vertex[n], self.corner_vertex[p]);
        let f = self.alive.push(true);
        self.corner_vertex.extend([m, b, c]);
        self.twin.extend([None, None, None]);
        let [ahead, edge_bc, edge_cm] = [0, 1, 2].map(|k| CornerId::new(f.index() * 3 + k));
        self.corner_vertex[n] = m;
        match self.twin[n] {
            Some(t) => self.pair_up(edge_bc, t),
            None => self.twin[edge_bc] = None,
        }
        self.pair_up(n, edge_cm);
        self.twin[half] = None;
        if self.vertex_corner[b] == Some(n) {
            self.vertex_corner[b] = Some(edge_bc);
        }
        ahead
    }

    /// Whether collapsing an edge keeps the mesh manifold (link condition, borders included).
    pub fn may_collapse(&self, half: CornerId) -> bool {
        let (a, b) = (self.vertex(half), self.target(half));
        let is_border_edge = self.twin[half].is_none();
        if !is_border_edge && self.is_border_vertex(a) && self.is_border_vertex(b) {
            return false;
        }
        let apex = self.vertex(prev(half));
        let other_apex = self.twin[half].map(|t| self.vertex(prev(t)));
        let mut count = 0;
        for v in self.ring(b).filter(|&v| self.ring(a).any(|w| w == v)) {
            if v != apex && Some(v) != other_apex {
                return false;
            }
            count += 1;
        }
        let sides = 1 + usize::from(other_apex.is_some());
        // A lone triangle, or two glued along their borders, would vanish.
        let vanishes = |c: CornerId| self.twin[next(c)].is_none() && self.twin[prev(c)].is_none();
        let closed_pair =
            |c: CornerId| matches!((self.twin[next(c)], self.twin[prev(c)]), (Some(x), Some(y)) if face(x) == face(y));
        count == sides
            && other_apex != Some(apex)
            && !vanishes(half)
            && !closed_pair(half)
            && self.twin[half].is_none_or(|t| !vanishes(t) && !closed_pair(t))
    }

    /// Collapses one end of an edge, `removed`, into the other and removes the triangles beside the edge. The caller has
    /// checked [`Self::may_collapse`].
    pub fn collapse(&mut self, half: CornerId, removed: VertexId) {
        let b = if removed == self.vertex(half) { self.target(half) } else { self.vertex(half) };
        let other = self.twin[half];
        let mut at = self.vertex_corner[removed];
        let first = at;
        while let Some(corner) = at {
            self.corner_vertex[corner] = b;
            at = self.twin[prev(corner)].filter(|&c| Some(c) != first);
        }
        let is_border = self.is_border_vertex(b) || first.is_some_and(|c| self.twin[c].is_none());
        self.vertex_corner[removed] = None;
        for side in std::iter::once(half).chain(other) {
            self.alive[face(side)] = false;
            let apex = self.vertex(prev(side));
            let (x, y) = (self.twin[next(side)], self.twin[prev(side)]);
            match (x, y) {
                (Some(x), Some(y)) => self.pair_up(x, y),
                (Some(x), None) => self.twin[x] = None,
                (None, Some(y)) => self.twin[y] = None,
                (None, None) => {}
            }
            // `x` leaves the apex towards b, `y` leaves b towards the apex.
            let (at_apex, at_b) = (x.or(y.map(next)), y.or(x.map(next)));
            let gone = |c: Option<CornerId>| c.is_none_or(|c| face(c) == face(side));
            if gone(self.vertex_corner[apex]) {
                self.vertex_corner[apex] = at_apex;
                self.begin_at_border(apex);
            }
            self.vertex_corner[b] = at_b.or(self.vertex_corner[b]);
        }
        if is_border {
            self.begin_at_border(b);
        }
    }

    /// Whether flipping an edge makes a new edge.
    pub fn may_flip(&self, half: CornerId) -> bool {
        let Some(t) = self.twin[half] else { return false };
        let (c, d) = (self.vertex(prev(half)), self.vertex(prev(t)));
        c != d && self.find(c, d).is_none()
    }

    /// Whether a split connects no two vertices twice, as it would between two triangles on the same vertices.
    pub fn may_split(&self, half: CornerId) -> bool {
        self.twin[half].is_none_or(|t| self.vertex(prev(half)) != self.vertex(prev(t)))
    }

    /// Flips an interior edge: triangles `(a, b, c)` and `(b, a, d)` become `(c, d, b)` and `(d, c, a)`, in the same
    /// places; the corners `half` and its twin become `c` and `d`. Returns the corners, now
    /// `[c, d, b]` and `[d, c, a]`.
    pub fn flip(&mut self, half: CornerId) -> Option<[[CornerId; 3]; 2]> {
        let other = self.twin[half]?;
        let (hn, hp, on, op) = (next(half), prev(half), next(other), prev(other));
        let (a, b) = (self.vertex(half), self.vertex(other));
        let (c, d) = (self.vertex(hp), self.vertex(op));
        let (bc, ca, ad, db) = (self.twin[hn], self.twin[hp], self.twin[on], self.twin[op]);
        self.set_quad(
            [(half, c), (hn, d), (hp, b), (other, d), (on, c), (op, a)],
            [(hn, db), (hp, bc), (on, ca), (op, ad)],
            [(a, [half, on], op), (b, [other, hn], hp), (c, [hp, hp], on), (d, [op, op], hn)],
        );
        Some([[half, hn, hp], [other, on, op]])
    }

    /// Undoes a flip, as three more flips would.
    pub fn unflip(&mut self, half: CornerId) {
        let Some(other) = self.twin[half] else { return };
        let (hn, hp, on, op) = (next(half), prev(half), next(other), prev(other));
        let (c, d, b, a) = (self.vertex(half), self.vertex(other), self.vertex(hp), self.vertex(op));
        let (db, bc, ca, ad) = (self.twin[hn], self.twin[hp], self.twin[on], self.twin[op]);
        self.set_quad(
            [(half, a), (hn, b), (hp, c), (other, b), (on, a), (op, d)],
            [(hn, bc), (hp, ca), (on, ad), (op, db)],
            [(a, [op, op], on), (b, [hp, hp], hn), (c, [half, on], hp), (d, [other, hn], op)],
        );
    }

    /// Sets the vertices at the corners of two triangles, the twins of their rim, and for each vertex the corner that
    /// replaces its lost ones. Half-edges of the rim keep their vertex but change their corner, so border vertices still
    /// begin at their borders.
    #[inline]
    fn set_quad(
        &mut self,
        corners: [(CornerId, VertexId); 6],
        rim: [(CornerId, Option<CornerId>); 4],
        starts: [(VertexId, [CornerId; 2], CornerId); 4],
    ) {
        for (corner, v) in corners {
            self.corner_vertex[corner] = v;
        }
        for (corner, twin) in rim {
            self.twin[corner] = twin;
            if let Some(t) = twin {
                self.twin[t] = Some(corner);
            }
        }
        for (v, gone, corner) in starts {
            if self.vertex_corner[v].is_some_and(|k| gone.contains(&k)) {
                self.vertex_corner[v] = Some(corner);
            }
        }
    }

    fn pair_up(&mut self, a: CornerId, b: CornerId) {
        self.twin[a] = Some(b);
        self.twin[b] = Some(a);
    }

    /// Sets a vertex's corner to the one that leaves along the border, if there is one.
    fn begin_at_border(&mut self, vertex: VertexId) {
        let Some(first) = self.vertex_corner[vertex] else { return };
        let mut corner = first;
        while let Some(t) = self.twin[corner] {
            corner = next(t);
            if corner == first {
                break;
            }
        }
        self.vertex_corner[vertex] = Some(corner);
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
