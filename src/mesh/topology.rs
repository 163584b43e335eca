//! Faces with their edges and adjacency.

use super::{CornerId, EdgeId, FaceId, Faces, Id, IdVec, VertexId};
use std::marker::PhantomData;

/// For each element of one kind a list of elements of another, in compressed rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Csr<K, V> {
    offsets: Vec<u32>,
    items: Vec<V>,
    key: PhantomData<fn(K)>,
}

impl<K: Id, V: Copy> Csr<K, V> {
    /// Rows from their offsets (one more than there are rows) and their items.
    pub fn from_parts(offsets: Vec<u32>, items: Vec<V>) -> Self {
        assert_eq!(offsets.last().copied().unwrap_or(0) as usize, items.len(), "offsets end at the items' end");
        Self { offsets, items, key: PhantomData }
    }

    /// Groups `items` by key, keeping their order within each row.
    pub fn group(rows: usize, items: impl Iterator<Item = (K, V)> + Clone, filler: V) -> Self {
        let mut offsets = vec![0u32; rows + 1];
        items.clone().for_each(|(k, _)| offsets[k.index() + 1] += 1);
        for row in 0..rows {
            offsets[row + 1] += offsets[row];
        }
        let mut next = offsets.clone();
        let mut out = vec![filler; offsets[rows] as usize];
        for (k, v) in items {
            out[next[k.index()] as usize] = v;
            next[k.index()] += 1;
        }
        Self::from_parts(offsets, out)
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Where each row begins, and one past the last.
    pub fn offsets(&self) -> &[u32] {
        &self.offsets
    }

    /// The items of all rows, one after the other.
    pub fn items(&self) -> &[V] {
        &self.items
    }

    /// The items of one row.
    #[inline]
    pub fn row(&self, key: K) -> &[V] {
        &self.items[self.offsets[key.index()] as usize..self.offsets[key.index() + 1] as usize]
    }
}

/// The connectivity of a mesh of any faces. Edges may have any number of faces and vertices any number of fans.
#[derive(Clone, Debug)]
pub struct Topology {
    /// The faces.
    pub faces: Faces,
    /// The edge that leaves each corner.
    pub corner_edge: IdVec<CornerId, EdgeId>,
    /// The vertices of each edge, in the direction of its first half-edge.
    pub edges: IdVec<EdgeId, [VertexId; 2]>,
    /// The half-edges of each edge.
    pub edge_corners: Csr<EdgeId, CornerId>,
    /// The corners at each vertex.
    pub vertex_corners: Csr<VertexId, CornerId>,
}

impl Topology {
    /// Finds the edges of `faces` over `vertices` vertices. Edges are numbered by their first half-edge.
    pub fn new(faces: Faces, vertices: usize) -> Self {
        let corners = faces.corners();
        let vertex_corners = Csr::group(vertices, corners.enumerated().map(|(c, &v)| (v, c)), CornerId::new(0));
        let mut corner_edge: IdVec<CornerId, Option<EdgeId>> = IdVec::filled(None, corners.len());
        let mut edges: IdVec<EdgeId, [VertexId; 2]> = IdVec::new();
        for corner in corners.ids() {
            if corner_edge[corner].is_some() {
                continue;
            }
            let [a, b] = faces.half_edge(corner);
            let edge = edges.push([a, b]);
            // Every half-edge between a and b leaves from one of them.
            for &c in vertex_corners.row(a) {
                if faces.vertex(faces.next(c)) == b {
                    corner_edge[c] = Some(edge);
                }
            }
            for &c in vertex_corners.row(b) {
                if faces.vertex(faces.next(c)) == a {
                    corner_edge[c] = Some(edge);
                }
            }
        }
        let corner_edge: IdVec<CornerId, EdgeId> =
            corner_edge.iter().map(|e| e.expect("every corner leaves on an edge")).collect();
        let edge_corners = Csr::group(edges.len(), corner_edge.enumerated().map(|(c, &e)| (e, c)), CornerId::new(0));
        Self { faces, corner_edge, edges, edge_corners, vertex_corners }
    }

    /// Number of vertices, those without a face included.
    pub fn vertex_count(&self) -> usize {
        self.vertex_corners.rows()
    }

    /// Whether an edge has one face only.
    #[inline]
    pub fn is_border(&self, edge: EdgeId) -> bool {
        self.edge_corners.row(edge).len() == 1
    }

    /// The edge between two vertices.
    pub fn find_edge(&self, a: VertexId, b: VertexId) -> Option<EdgeId> {
        let leaving = |from: VertexId, to: VertexId| {
            let corners = self.vertex_corners.row(from).iter();
            corners.copied().find(|&c| self.faces.vertex(self.faces.next(c)) == to)
        };
        if a.index() >= self.vertex_count() || b.index() >= self.vertex_count() {
            return None;
        }
        leaving(a, b).or_else(|| leaving(b, a)).map(|c| self.corner_edge[c])
    }

    /// The other half-edge of an edge of exactly two faces.
    #[inline]
    pub fn twin(&self, corner: CornerId) -> Option<CornerId> {
        match *self.edge_corners.row(self.corner_edge[corner]) {
            [a, b] if a == corner => Some(b),
            [a, b] if b == corner => Some(a),
            _ => None,
        }
    }

    /// The faces around a vertex.
    pub fn faces_at(&self, vertex: VertexId) -> impl Iterator<Item = FaceId> + '_ {
        self.vertex_corners.row(vertex).iter().map(|&c| self.faces.face_of(c))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_quads_share_one_edge() {
        let corners: Vec<_> = [0, 1, 2, 3, 1, 4, 5, 2].map(VertexId::new).to_vec();
        let t = Topology::new(Faces::quads(corners), 6);
        assert_eq!(t.edges.len(), 7);
        assert_eq!(t.edges.ids().filter(|&e| !t.is_border(e)).count(), 1);
        let shared = t.find_edge(VertexId::new(1), VertexId::new(2)).expect("shared edge");
        assert_eq!(t.edge_corners.row(shared).len(), 2);
        assert_eq!(t.twin(CornerId::new(1)), Some(CornerId::new(7)));
        assert_eq!(t.find_edge(VertexId::new(0), VertexId::new(4)), None);
    }
}
