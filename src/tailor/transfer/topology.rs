//! Topology of the simulation mesh, and the triangles of the baseline in each face of the garment.

use crate::sim::SimProduct;
use tailor_mesh::connectivity::{CornerId, Csr, EdgeId, FaceId, Faces, IdVec, Topology, VertexId};

/// The topology of a simulation mesh, with its constraints.
pub(super) struct SimTopology {
    pub topology: Topology,
    /// Which edges are seams of the constraint UVs.
    pub is_seam: IdVec<EdgeId, bool>,
    /// Which edges are on chains.
    pub is_chain: IdVec<EdgeId, bool>,
    /// The other half-edge of each; none at borders.
    pub twin: IdVec<CornerId, Option<CornerId>>,
    /// Triangles of the baseline in each face of the garment.
    pub source_triangles: Csr<FaceId, FaceId>,
}

impl SimTopology {
    /// The topology of `product`, whose garment has `source_faces` faces.
    pub fn new(product: &SimProduct, source_faces: usize) -> Self {
        let corners: Vec<VertexId> = product.triangles.iter().flatten().copied().collect();
        let topology = Topology::new(Faces::triangles(corners), product.points.len());
        let mut is_seam = IdVec::filled(false, topology.edges.len());
        let mut is_chain = is_seam.clone();
        for (id, chain) in product.baseline.chains.enumerated() {
            for edge in product.chain_edges[id].iter().filter_map(|&[a, b]| topology.find_edge(a, b)) {
                is_seam[edge] |= chain.kind.seam;
                is_chain[edge] = true;
            }
        }
        let twin = topology.faces.corners().ids().map(|c| topology.twin(c)).collect();
        let pairs = product.baseline.source_face.enumerated().map(|(face, &source)| (source, face));
        let source_triangles = Csr::group(source_faces, pairs, FaceId::new(0));
        Self { topology, is_seam, is_chain, twin, source_triangles }
    }

    /// The half-edges of a face inside its region, each with the face across it: those on no chain and no border.
    pub fn open_neighbours(&self, face: FaceId) -> impl Iterator<Item = (CornerId, FaceId)> {
        let faces = &self.topology.faces;
        let open = faces.corners_of(face).filter(move |&c| !self.is_chain[self.topology.corner_edge[c]]);
        open.filter_map(move |c| Some((c, faces.face_of(self.twin[c]?))))
    }
}

/// An edge's vertices, the lower first.
pub(super) fn edge_key([a, b]: [VertexId; 2]) -> [VertexId; 2] {
    [a.min(b), a.max(b)]
}
