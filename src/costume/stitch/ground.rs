//! The surface below threads.

use crate::binding::Triangles;
use glam::Vec3;
use tailor::render::LimitSurface;
use tailor_mesh::garment::Mesh;

/// The triangles of a limit surface, with its normals.
pub struct Ground {
    triangles: Triangles,
    normals: Vec<[Vec3; 3]>,
}

impl Ground {
    /// The surface of a mesh, whose faces are split from their first corners.
    pub fn new(mesh: &Mesh, surface: &LimitSurface) -> Self {
        let fans = mesh.faces.ids().flat_map(|face| {
            let around = mesh.faces.vertices_of(face);
            (2..around.len()).map(move |k| [around[0], around[k - 1], around[k]])
        });
        let (corners, normals) =
            fans.map(|fan| (fan.map(|v| surface.points[v]), fan.map(|v| surface.normals[v]))).unzip();
        Self { triangles: Triangles::new(corners), normals }
    }

    /// The place of the surface that is nearest to a point, and its normal.
    pub fn below(&self, point: Vec3) -> Option<(Vec3, Vec3)> {
        let (triangle, weights) = self.triangles.nearest(point)?;
        let mean = |corners: &[Vec3; 3]| corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z;
        Some((mean(self.triangles.corners(triangle)), mean(&self.normals[triangle]).normalize_or_zero()))
    }
}
