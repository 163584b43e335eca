//! The edges and adjacency of a polygon mesh, manifold or not.

use super::{CornerId, EdgeId, FaceId, Faces, Id, IdVec, VertexId};
use std::marker::PhantomData;

/// One list of values for each element of a kind, in compressed sparse rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Csr<K, V> {
    offsets: Vec<u32>,
    items: Vec<V>,
    key: PhantomData<fn(K)>,
}

impl<K: Id, V: Copy> Csr<K, V> {
    /// Rows from their `offsets`, one more than there are rows, and all `items`.
    pub fn from_parts(offsets: Vec<u32>, items: Vec<V>) -> Self {
        assert_eq!(offsets.last().copied().unwrap_or(0) as usize, items.len(), "offsets end at the items' end");
        Self { offsets, items, key: PhantomData }
    }

    /// Groups `items` by key, stably. `filler` only initializes memory.
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

    /// The start of each row, then the end of the last.
    pub fn offsets(&self) -> &[u32] {
        &self.offsets
    }

    /// The items of all rows, in order.
    pub fn items(&self) -> &[V] {
        &self.items
    }

    /// The items of one row.
    #[inline]
    pub fn row(&self, key: K) -> &[V] {
        &self.items[self.offsets[key.index()] as usize..self.offsets[key.index() + 1] as usize]
    }
}

/// The connectivity of a polygon mesh. An edge may have any number of faces, and a vertex any number of fans.
#[derive(Clone, Debug)]
pub struct Topology {
    /// The faces.
    pub faces: Faces,
    /// The edge of the half-edge that leaves each corner.
    pub corner_edge: IdVec<CornerId, EdgeId>,
    /// The vertices of each edge.
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
        let leader = edge_leaders(&faces, &vertex_corners);
        let mut edge_of_leader: IdVec<CornerId, Option<EdgeId>> = IdVec::filled(None, corners.len());
        let mut edges: IdVec<EdgeId, [VertexId; 2]> = IdVec::with_capacity(corners.len() / 2 + corners.len() / 8);
        let number = |c| *edge_of_leader[leader[c]].get_or_insert_with(|| edges.push(faces.half_edge(c)));
        let corner_edge: IdVec<CornerId, EdgeId> = corners.ids().map(number).collect();
        let edge_corners = Csr::group(edges.len(), corner_edge.enumerated().map(|(c, &e)| (e, c)), CornerId::new(0));
        Self { faces, corner_edge, edges, edge_corners, vertex_corners }
    }

    /// Number of vertices, including those without a face.
    pub fn vertex_count(&self) -> usize {
        self.vertex_corners.rows()
    }

    /// `true` if the edge has exactly one face.
    #[inline]
    pub fn is_border(&self, edge: EdgeId) -> bool {
        self.edge_corners.row(edge).len() == 1
    }

    /// The edge between two vertices.
    pub fn find_edge(&self, a: VertexId, b: VertexId) -> Option<EdgeId> {
        if a.index() >= self.vertex_count() || b.index() >= self.vertex_count() {
            return None;
        }
        // Search around the vertex with fewer faces.
        let (from, to) =
            if self.vertex_corners.row(a).len() <= self.vertex_corners.row(b).len() { (a, b) } else { (b, a) };
        let half_edges = self.vertex_corners.row(from).iter().flat_map(|&c| {
            let prev = self.faces.prev(c);
            [(c, self.faces.next(c)), (prev, prev)]
        });
        half_edges.into_iter().find(|&(_, far)| self.faces.vertex(far) == to).map(|(half, _)| self.corner_edge[half])
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

/// The representative half-edge of each half-edge's edge.
///
/// Linear in the number of corners even at vertices of very high valence, and without hashing.
fn edge_leaders(faces: &Faces, vertex_corners: &Csr<VertexId, CornerId>) -> IdVec<CornerId, CornerId> {
    let mut leader: IdVec<CornerId, CornerId> = faces.corners().ids().collect();
    // For each vertex, the last lower neighbour visited and the leader of the edge to it.
    let mut found: IdVec<VertexId, Option<(VertexId, CornerId)>> = IdVec::filled(None, vertex_corners.rows());
    for low in found.ids() {
        for &corner in vertex_corners.row(low) {
            let prev = faces.prev(corner);
            for (half, high) in [(corner, faces.vertex(faces.next(corner))), (prev, faces.vertex(prev))] {
                match found[high] {
                    _ if high < low => {}
                    Some((by, first)) if by == low => leader[half] = first,
                    _ => found[high] = Some((low, half)),
                }
            }
        }
    }
    leader
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

    #[test]
    fn edges_are_numbered_by_their_first_half_edge() {
        let corners: Vec<_> = [3, 2, 0, 2, 1, 0, 0, 2, 4].map(VertexId::new).to_vec();
        let t = Topology::new(Faces::triangles(corners), 5);
        let edges: Vec<_> = t.edges.iter().map(|e| e.map(VertexId::index)).collect();
        assert_eq!(edges, [[3, 2], [2, 0], [0, 3], [2, 1], [1, 0], [2, 4], [4, 0]]);
        let three = t.find_edge(VertexId::new(0), VertexId::new(2)).expect("edge of three faces");
        assert_eq!(t.edge_corners.row(three), [1, 5, 6].map(CornerId::new));
    }

    #[test]
    fn a_vertex_of_very_many_faces_takes_no_longer() {
        const FACES: usize = 200_000;
        let fan = (0..FACES).flat_map(|i| [0, i + 1, (i + 1) % FACES + 1]).map(VertexId::new);
        let t = Topology::new(Faces::triangles(fan.collect::<Vec<_>>()), FACES + 1);
        assert_eq!(t.edges.len(), 2 * FACES);
        for spoke in 1..=FACES {
            let edge = t.find_edge(VertexId::new(0), VertexId::new(spoke)).expect("a spoke");
            assert_eq!(t.edge_corners.row(edge).len(), 2);
        }
    }
}
