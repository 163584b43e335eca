//! The edits of a triangle mesh: split, collapse and flip.

use super::{EditMesh, face, next, prev};
use crate::connectivity::{CornerId, VertexId};

/// The new half-edges of [`EditMesh::split`].
#[derive(Clone, Copy, Debug)]
pub struct Split {
    /// The half-edge from the new vertex to the old end; its triangle is new.
    pub ahead: CornerId,
    /// The half-edge from the new vertex to the old start, in a new triangle; none at a border.
    pub behind: Option<CornerId>,
}

impl EditMesh {
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

    pub(super) fn pair_up(&mut self, a: CornerId, b: CornerId) {
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
