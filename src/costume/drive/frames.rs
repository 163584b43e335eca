//! The rotation of each vertex of a triangle mesh from its bind pose.
//!
//! Two directions in the tangent plane at bind are written as sums of edges around the vertex. The same sums on a moved mesh are
//! where the directions went; the rotation is the one in the moved tangent plane that is nearest to both (the polar part of the
//! linear map). Directions that are sums of edges need no solve in each frame.

use super::fault;
use glam::{Mat3, Quat, Vec2, Vec3};
use rayon::prelude::*;
use tailor_mesh::connectivity::{Csr, VertexId};
use tailor_mesh::error::Error;

/// A mesh at bind, ready to measure the rotation of its vertices.
pub struct BindFrames {
    triangles: Vec<[u32; 3]>,
    /// The triangles around each vertex, each with the corner that the vertex has.
    corners: Csr<VertexId, (u32, u8)>,
    /// The neighbours of each vertex in the order of `corners`, two each, with their share of the two directions.
    shares: Vec<[Vec2; 2]>,
    /// The frame of each vertex at bind: two directions in the tangent plane, and the normal.
    bind: Vec<Mat3>,
}

impl BindFrames {
    /// Of a mesh at bind. Vertices without triangles never turn.
    ///
    /// # Errors
    /// A triangle with a vertex that is not among the points.
    pub fn new(points: &[Vec3], triangles: &[[u32; 3]]) -> Result<Self, Error> {
        if let Some(triangle) = triangles.iter().find(|t| t.iter().any(|&v| v as usize >= points.len())) {
            let count = points.len();
            return Err(fault(format!("triangle {triangle:?} is beyond the {count} points of the simulation mesh")));
        }
        let corner = |(i, &v): (usize, &u32)| (VertexId::new(v as usize), ((i / 3) as u32, (i % 3) as u8));
        let corners = triangles.as_flattened().iter().enumerate().map(corner);
        let mut frames = Self {
            triangles: triangles.to_vec(),
            corners: Csr::group(points.len(), corners, (0, 0)),
            shares: Vec::new(),
            bind: Vec::with_capacity(points.len()),
        };
        for vertex in 0..points.len() {
            let normal = frames.normal(vertex, points);
            let x = normal.any_orthonormal_vector();
            let frame = Mat3::from_cols(x, normal.cross(x), normal);
            let edges: Vec<[Vec2; 2]> = frames
                .ring(vertex)
                .map(|ends| ends.map(|v| (frame.transpose() * (points[v] - points[vertex])).truncate()))
                .collect();
            frames.shares.extend(shares(&edges));
            frames.bind.push(frame);
        }
        Ok(frames)
    }

    /// Number of vertices.
    pub fn vertices(&self) -> usize {
        self.bind.len()
    }

    /// The rotation of each vertex from bind to `points`.
    pub fn rotations(&self, points: &[Vec3]) -> Vec<Quat> {
        (0..self.vertices()).into_par_iter().map(|vertex| self.rotation(vertex, points)).collect()
    }

    fn rotation(&self, vertex: usize, points: &[Vec3]) -> Quat {
        let first = self.corners.offsets()[vertex] as usize;
        let normal = self.normal(vertex, points);
        let (mut x, mut y) = (Vec3::ZERO, Vec3::ZERO);
        for (ends, shares) in self.ring(vertex).zip(&self.shares[first..]) {
            for (end, share) in ends.into_iter().zip(shares) {
                let edge = points[end] - points[vertex];
                x += share.x * edge;
                y += share.y * edge;
            }
        }
        // In any basis of the moved plane, the angle of the nearest rotation has a closed form.
        let u = normal.any_orthonormal_vector();
        let v = normal.cross(u);
        let turn = Vec2::new(x.dot(u) + y.dot(v), x.dot(v) - y.dot(u)).normalize_or(Vec2::X);
        let across = turn.x * u + turn.y * v;
        let moved = Mat3::from_cols(across, normal.cross(across), normal);
        Quat::from_mat3(&(moved * self.bind[vertex].transpose())).normalize()
    }

    /// The other two vertices of each triangle around a vertex.
    fn ring(&self, vertex: usize) -> impl Iterator<Item = [usize; 2]> + '_ {
        self.corners.row(VertexId::new(vertex)).iter().map(|&(triangle, corner)| {
            let triangle = self.triangles[triangle as usize];
            [1, 2].map(|k| triangle[(corner as usize + k) % 3] as usize)
        })
    }

    /// The unit normal at a vertex; the z axis without one.
    fn normal(&self, vertex: usize, points: &[Vec3]) -> Vec3 {
        let at = points[vertex];
        let sum: Vec3 = self.ring(vertex).map(|[a, b]| (points[a] - at).cross(points[b] - at)).sum();
        sum.normalize_or(Vec3::Z)
    }
}

/// The shares of edges in the two axes: sums of edges by them are the axes, with the least squares of shares.
fn shares(edges: &[[Vec2; 2]]) -> Vec<[Vec2; 2]> {
    let all = || edges.iter().flatten();
    let [xx, xy, yy] =
        [all().map(|e| e.x * e.x).sum::<f32>(), all().map(|e| e.x * e.y).sum(), all().map(|e| e.y * e.y).sum()];
    let determinant = xx * yy - xy * xy;
    let usable = determinant > 1e-6 * xx * yy;
    let share = |e: &Vec2| match usable {
        true => Vec2::new(yy * e.x - xy * e.y, xx * e.y - xy * e.x) / determinant,
        false => Vec2::ZERO,
    };
    edges.iter().map(|ends| ends.each_ref().map(share)).collect()
}
