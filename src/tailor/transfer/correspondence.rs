//! Correspondence of the simulation mesh and the baseline: locations of vertices, and areas that faces have in common.

use super::coverage::Coverage;
use super::topology::SimTopology;
use crate::sim::{BaselinePoint, SimProduct};
use glam::Vec3;
use tailor_mesh::connectivity::{CornerId, FaceId, IdVec, VertexId};

/// Places of the simulation mesh's elements on the baseline, from which every attribute is carried.
pub(super) struct Correspondence<'a> {
    pub product: &'a SimProduct,
    pub mesh: &'a SimTopology,
    pub coverage: &'a Coverage,
    /// The location of each vertex; at a seam, on the side of its first corner.
    pub locations: IdVec<VertexId, BaselinePoint>,
    /// Faces that no sample hits, ascending, each with the garment's face under its centroid.
    pub unsampled: Vec<(FaceId, FaceId)>,
}

impl<'a> Correspondence<'a> {
    pub fn new(product: &'a SimProduct, mesh: &'a SimTopology, coverage: &'a Coverage) -> Self {
        // A vertex of the simulation mesh has a triangle.
        let location = |v| product.places[mesh.topology.vertex_corners.row(v)[0]].location;
        let locations = product.points.ids().map(location).collect();
        let mut map = Self { product, mesh, coverage, locations, unsampled: Vec::new() };
        let bare = mesh.topology.faces.ids().filter(|&f| coverage.sources.row(f).is_empty());
        map.unsampled = bare.map(|f| (f, map.source_under(f))).collect();
        map
    }

    /// The garment's face under the centroid of a face.
    pub fn source_under(&self, face: FaceId) -> FaceId {
        self.product.source_face(face)
    }

    /// The baseline's triangle under the centroid of a face.
    pub fn triangle_under(&self, face: FaceId) -> FaceId {
        self.product.triangle_under(face)
    }

    /// The locations of a face's corners, on its own side of the seams.
    pub fn corner_locations(&self, face: FaceId) -> [BaselinePoint; 3] {
        [0, 1, 2].map(|k| self.product.places[CornerId::new(3 * face.index() + k)].location)
    }

    /// The positions of a face's corners. \[mesh units\]
    pub fn triangle(&self, face: FaceId) -> [Vec3; 3] {
        self.product.triangles[face.index()].map(|v| self.product.points[v])
    }

    /// \[mesh units\]
    pub fn centroid(&self, face: FaceId) -> Vec3 {
        self.triangle(face).iter().sum::<Vec3>() / 3.0
    }

    /// The position of a corner. \[mesh units\]
    pub fn position(&self, corner: CornerId) -> Vec3 {
        self.product.points[self.mesh.topology.faces.vertex(corner)]
    }

    /// The square of a half-edge's length. \[square mesh units\]
    pub fn length_squared(&self, half: CornerId) -> f32 {
        self.position(half).distance_squared(self.position(self.mesh.topology.faces.next(half)))
    }
}
