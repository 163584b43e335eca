//! The limit surface of a render mesh at its vertices, and lines on it: what lies on the finished surface begins here.

use super::parallels::{self, Surface, SurfaceLine};
use super::seam::{Network, RowSide};
use glam::Vec3;
use tailor_mesh::connectivity::{IdVec, VertexId};
use tailor_mesh::garment::{Mesh, Orientation};
use tailor_mesh::subdivide::{Level, carried_points};

/// The limit positions of the vertices of a mesh, with outer normals.
pub struct LimitSurface {
    level: Level,
    /// The limit positions.
    pub points: IdVec<VertexId, Vec3>,
    /// The outer normals.
    pub normals: IdVec<VertexId, Vec3>,
    is_left_handed: bool,
}

impl LimitSurface {
    /// The limit surface of a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        let level = Level::base(mesh);
        let points = carried_points(&&level.limit_rows(), &mesh.points);
        let is_left_handed = mesh.orientation == Orientation::LeftHanded;
        let normals = vertex_normals(mesh, &points);
        Self { level, points, normals, is_left_handed }
    }

    /// The lines at ascending distances along the surface from edges, which are joined to chains; 0 is the edges themselves. Left and
    /// right are as those of a seam. \[mesh units\]
    pub fn lines(&self, edges: Vec<[VertexId; 2]>, side: RowSide, distances: &[f32]) -> Vec<SurfaceLine> {
        let topology = &self.level.topology;
        let chains = Network::new(topology, &[edges]).chains(topology);
        let surface = Surface { topology, points: &self.points, is_left_handed: self.is_left_handed };
        parallels::lines(&surface, &chains, side.sides(), distances)
    }

    /// The position and the outer normal at a point of a line.
    pub fn at(&self, ([a, b], share): ([VertexId; 2], f32)) -> (Vec3, Vec3) {
        let normal = self.normals[a].lerp(self.normals[b], share).normalize_or_zero();
        (self.points[a].lerp(self.points[b], share), normal)
    }
}

/// Outer normals of the surface through `points`, weighted by the areas at its corners.
pub fn vertex_normals(mesh: &Mesh, points: &IdVec<VertexId, Vec3>) -> IdVec<VertexId, Vec3> {
    let faces = &mesh.faces;
    let sign = if mesh.orientation == Orientation::LeftHanded { -1.0 } else { 1.0 };
    let mut normals = IdVec::filled(Vec3::ZERO, points.len());
    for corner in faces.corners().ids() {
        let [here, next, prev] = [corner, faces.next(corner), faces.prev(corner)].map(|c| faces.vertex(c));
        normals[here] += sign * (points[next] - points[here]).cross(points[prev] - points[here]);
    }
    normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
    normals
}
