//! Points bound to the triangles of a body, which take them along.

use super::bodies::Bodies;
use super::triangle::{TriangleSearch, at};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// The place of a point on a body: the nearest one.
struct Place {
    triangle: usize,
    weights: DVec3,
    /// The point less its place.
    offset: DVec3,
    frame: DMat3,
}

/// Points bound to a shape of a body.
pub struct BoundPoints<'a> {
    bodies: &'a Bodies,
    places: Vec<Place>,
}

impl<'a> BoundPoints<'a> {
    /// Binds points to a shape.
    pub fn new(bodies: &'a Bodies, shape: &[DVec3], points: &[DVec3]) -> Self {
        let search = TriangleSearch::new(bodies.triangles.iter().map(|t| t.map(|v| shape[v])).collect());
        let normals = normals(&bodies.triangles, shape);
        let place = |&point: &DVec3| {
            let (triangle, weights, on) = search.nearest(point).unwrap_or((0, DVec3::X, point));
            let frame = frame(bodies.triangles[triangle], weights, shape, &normals);
            Place { triangle, weights, offset: point - on, frame }
        };
        Self { bodies, places: points.par_iter().map(place).collect() }
    }

    /// The distance of each point from the body. \[mesh units\]
    pub fn distances(&self) -> impl Iterator<Item = f64> + '_ {
        self.places.iter().map(|place| place.offset.length())
    }

    /// The height of each point over the body, negative inside. \[mesh units\]
    pub fn heights(&self) -> impl Iterator<Item = f64> + '_ {
        self.places.iter().map(|place| place.offset.dot(place.frame.z_axis))
    }

    /// The vertex of the body that is nearest to the place of each point.
    pub fn vertices(&self) -> Vec<usize> {
        let vertex = |place: &Place| {
            let k = (1..3).fold(0, |best, k| if place.weights[k] > place.weights[best] { k } else { best });
            self.bodies.triangles[place.triangle][k]
        };
        self.places.iter().map(vertex).collect()
    }

    /// Where another shape of the body takes the points. Their distance from it stays.
    pub fn carried(&self, shape: &[DVec3]) -> Vec<DVec3> {
        let normals = normals(&self.bodies.triangles, shape);
        let carried = |place: &Place| {
            let vertices = self.bodies.triangles[place.triangle];
            let turn = frame(vertices, place.weights, shape, &normals) * place.frame.transpose();
            at(vertices.map(|v| shape[v]), place.weights) + turn * place.offset
        };
        self.places.par_iter().map(carried).collect()
    }
}

/// The frame of a place on a triangle: its last axis is the mean normal of the corners, its first one is along the first edge.
fn frame(vertices: [usize; 3], weights: DVec3, points: &[DVec3], normals: &[DVec3]) -> DMat3 {
    let [a, b, c] = vertices.map(|v| points[v]);
    let mean = at(vertices.map(|v| normals[v]), weights);
    let z = mean.try_normalize().or((b - a).cross(c - a).try_normalize()).unwrap_or(DVec3::Z);
    let x = (b - a).reject_from_normalized(z).try_normalize().unwrap_or_else(|| z.any_orthonormal_vector());
    DMat3::from_cols(x, z.cross(x), z)
}

/// The normals of vertices, by area.
pub fn normals(triangles: &[[usize; 3]], points: &[DVec3]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; points.len()];
    for &triangle in triangles {
        let [a, b, c] = triangle.map(|v| points[v]);
        triangle.into_iter().for_each(|v| normals[v] += (b - a).cross(c - a));
    }
    normals.iter().map(|n| n.normalize_or_zero()).collect()
}
