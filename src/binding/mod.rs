//! The binding of the render mesh to the simulation mesh: a place on a triangle for each vertex.
//!
//! A vertex's place is that of its origin on the garment, found on the same panel, layer and side. All layers of a hem share the
//! place of the surface that they were made from, so that they move together. The nearest triangle would be that of a wrong layer
//! wherever cloth lies on cloth.

use crate::contact::{Aabb, NearestSearch, twice_area};
use crate::garment::Mesh;
use crate::mesh::{FaceId, IdVec, VertexId};
use crate::render::Origins;
use crate::sim::{SimProduct, closest_weights};
use crate::transfer::TriangleLocator;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::sync::LazyLock;

/// The places of the render mesh's vertices on the simulation mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Binding {
    /// The triangle of each vertex.
    pub faces: Vec<u32>,
    /// The weights of the triangle's first and second corner, and the height over it along the mean of the vertex normals.
    /// \[-, -, mesh units\]
    pub coords: Vec<Vec3>,
}

impl Binding {
    /// Binds the points of `render` to the simulation mesh `sim`, made of `product`. The garment has `source_faces` faces.
    pub fn new(product: &SimProduct, source_faces: usize, sim: &Mesh, render: &Mesh, origins: &Origins) -> Self {
        let places = TriangleLocator::new(product, source_faces);
        let origin = |i: usize| {
            let vertex = VertexId::new(i);
            (origins.points[vertex], origins.faces.row(vertex))
        };
        let found = places.find(render.points.len(), origin);
        let normals = vertex_normals(sim);
        let triangles = LazyLock::new(|| NearestTriangle::new(sim));
        let place = |(i, found): (usize, &Option<(FaceId, Vec3)>)| {
            let (origin, point) = (origins.points[VertexId::new(i)], render.points[VertexId::new(i)]);
            let (face, weights) = found.unwrap_or_else(|| triangles.to(origin));
            let corners = [0, 1, 2].map(|k| sim.faces.vertices_of(face)[k]);
            let mean = |values: &IdVec<VertexId, Vec3>| -> Vec3 {
                corners.iter().zip(weights.to_array()).map(|(&v, w)| w * values[v]).sum()
            };
            let height = (point - mean(&sim.points)).dot(mean(&normals).normalize_or_zero());
            (face.index() as u32, Vec3::new(weights.x, weights.y, height))
        };
        let (faces, coords) = found.par_iter().enumerate().map(place).unzip();
        Self { faces, coords }
    }

    /// The places of some of the vertices, in their order.
    pub fn of_points(&self, vertices: &[VertexId]) -> Self {
        let at = |v: &VertexId| v.index();
        Self {
            faces: vertices.iter().map(|v| self.faces[at(v)]).collect(),
            coords: vertices.iter().map(|v| self.coords[at(v)]).collect(),
        }
    }

    /// Its memory. \[bytes\]
    pub(crate) fn bytes(&self) -> usize {
        16 * self.faces.len()
    }
}

/// The sum of the normals of the faces around each vertex, by area.
fn vertex_normals(mesh: &Mesh) -> IdVec<VertexId, Vec3> {
    let mut normals = IdVec::filled(Vec3::ZERO, mesh.points.len());
    for face in mesh.faces.ids() {
        let vertices = mesh.faces.vertices_of(face);
        let normal = twice_area(vertices, &mesh.points);
        vertices.iter().for_each(|&v| normals[v] += normal);
    }
    normals
}

/// The nearest triangle of all, for vertices on a part of the garment that the simulation mesh lacks.
struct NearestTriangle<'a> {
    mesh: &'a Mesh,
    search: NearestSearch,
}

impl<'a> NearestTriangle<'a> {
    fn new(mesh: &'a Mesh) -> Self {
        let aabb = |face: FaceId| {
            let points = mesh.faces.vertices_of(face).iter().map(|&v| mesh.points[v].into());
            points.fold(Aabb::EMPTY, |b, p| b.merged(&Aabb { low: p, high: p }))
        };
        let boxes: Vec<Aabb> = mesh.faces.ids().map(aabb).collect();
        Self { mesh, search: NearestSearch::new(&boxes) }
    }

    /// The triangle nearest to a point, and the weights of its corners at the nearest point.
    fn to(&self, point: Vec3) -> (FaceId, Vec3) {
        let squared = |face: usize, from: DVec3| self.nearest_of(FaceId::new(face), from.as_vec3()).0;
        let found = self.search.nearest(point, squared).map(FaceId::new);
        found.map_or((FaceId::new(0), Vec3::X), |face| (face, self.nearest_of(face, point).1))
    }

    /// The squared distance of a triangle from a point, and the weights of its corners at the nearest point.
    fn nearest_of(&self, face: FaceId, point: Vec3) -> (f64, Vec3) {
        let [a, b, c] = [0, 1, 2].map(|k| self.mesh.points[self.mesh.faces.vertices_of(face)[k]]);
        let weights = closest_weights(a, b, c, point);
        let nearest = a * weights.x + b * weights.y + c * weights.z;
        (f64::from(nearest.distance_squared(point)), weights)
    }
}
