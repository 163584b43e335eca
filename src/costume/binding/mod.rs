//! The binding of the render mesh to the simulation mesh: a place on a triangle for each vertex.
//!
//! A vertex's place is that of its origin on the garment, found on the same panel, layer and side. All layers of a hem share the
//! place of the surface that they were made from, so that they move together. The nearest triangle would be that of a wrong layer
//! wherever cloth lies on cloth.

use glam::{DVec3, Vec3, Vec3A};
use rayon::prelude::*;
use std::sync::LazyLock;
use tailor::contact::{Aabb, NearestSearch, twice_area};
use tailor::render::Origins;
use tailor::sim::closest_weights;
use tailor::transfer::Locator;
use tailor_mesh::connectivity::{FaceId, IdVec, VertexId};
use tailor_mesh::garment::Mesh;

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
    /// Binds the points of `render` to the simulation mesh `sim`, on which `places` finds them.
    pub fn new(places: &Locator<'_>, sim: &Mesh, render: &Mesh, origins: &Origins) -> Self {
        let origin = |i: usize| {
            let vertex = VertexId::new(i);
            (origins.points[vertex], origins.faces.row(vertex))
        };
        let found = places.find(render.points.len(), origin);
        let surface = BindSurface::new(sim);
        let place = |(i, found): (usize, &Option<(FaceId, Vec3)>)| {
            let (origin, point) = (origins.points[VertexId::new(i)], render.points[VertexId::new(i)]);
            // A part of the garment that the simulation mesh lacks takes the nearest triangle of all.
            let (face, weights) = found.unwrap_or_else(|| surface.nearest(origin));
            (face.index() as u32, surface.coords(face, weights, point))
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
    pub fn bytes(&self) -> usize {
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

/// A simulation mesh to which points are bound.
pub struct BindSurface<'a> {
    mesh: &'a Mesh,
    normals: IdVec<VertexId, Vec3>,
    triangles: LazyLock<Triangles, Box<dyn FnOnce() -> Triangles + Send + 'a>>,
}

impl<'a> BindSurface<'a> {
    /// The surface of a mesh of triangles.
    pub fn new(mesh: &'a Mesh) -> Self {
        let triangle = |face: FaceId| [0, 1, 2].map(|k| mesh.points[mesh.faces.vertices_of(face)[k]]);
        let triangles = move || Triangles::new(mesh.faces.ids().map(triangle).collect());
        Self { mesh, normals: vertex_normals(mesh), triangles: LazyLock::new(Box::new(triangles)) }
    }

    /// The triangle nearest to a point, and the weights of its corners at the nearest point.
    pub fn nearest(&self, point: Vec3) -> (FaceId, Vec3) {
        self.triangles.nearest(point).map_or((FaceId::new(0), Vec3::X), |(face, weights)| (FaceId::new(face), weights))
    }

    /// The distance of a point. \[mesh units\]
    pub fn distance(&self, point: Vec3) -> f32 {
        self.triangles.distance(point)
    }

    /// The coordinates of `point`, bound at a place of a triangle: two weights, and the height over it.
    pub fn coords(&self, face: FaceId, weights: Vec3, point: Vec3) -> Vec3 {
        let corners = [0, 1, 2].map(|k| self.mesh.faces.vertices_of(face)[k]);
        let mean = |values: &IdVec<VertexId, Vec3>| -> Vec3 {
            corners.iter().zip(weights.to_array()).map(|(&v, w)| w * values[v]).sum()
        };
        let height = (point - mean(&self.mesh.points)).dot(mean(&self.normals).normalize_or_zero());
        Vec3::new(weights.x, weights.y, height)
    }
}

/// Triangles among which the nearest one is found.
pub struct Triangles {
    corners: Vec<[Vec3; 3]>,
    search: NearestSearch,
}

impl Triangles {
    /// Of some corners.
    pub fn new(corners: Vec<[Vec3; 3]>) -> Self {
        let boxes = corners.iter().map(|triangle| Aabb::of(triangle.map(Vec3A::from)));
        let search = NearestSearch::new(&boxes.collect::<Vec<_>>());
        Self { corners, search }
    }

    /// The triangle nearest to a point, and the weights of its corners at the nearest point; none without triangles.
    pub fn nearest(&self, point: Vec3) -> Option<(usize, Vec3)> {
        let squared = |triangle: usize, from: DVec3| self.nearest_of(triangle, from.as_vec3()).0;
        let found = self.search.nearest(point, squared)?;
        Some((found, self.nearest_of(found, point).1))
    }

    /// The corners of a triangle.
    pub fn corners(&self, triangle: usize) -> &[Vec3; 3] {
        &self.corners[triangle]
    }

    /// The distance of the nearest triangle, infinite without one. \[mesh units\]
    pub fn distance(&self, point: Vec3) -> f32 {
        let found = self.nearest(point);
        found.map_or(f32::INFINITY, |(triangle, _)| self.nearest_of(triangle, point).0.sqrt() as f32)
    }

    /// The squared distance of a triangle from a point, and the weights of its corners at the nearest point.
    fn nearest_of(&self, triangle: usize, point: Vec3) -> (f64, Vec3) {
        let [a, b, c] = self.corners[triangle];
        let weights = closest_weights(a, b, c, point);
        let nearest = a * weights.x + b * weights.y + c * weights.z;
        (f64::from(nearest.distance_squared(point)), weights)
    }
}
