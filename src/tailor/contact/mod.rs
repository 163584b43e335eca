//! Contact queries on the first refinement of a cage: intersecting and flipped faces, clearance to the next layer, and
//! faces that may intersect on the next refinement. Nothing here knows of operators or moves a point.
//!
//! A face is tested with its children, four at a time in vector registers (`simd`, `face`), and faces that are near
//! each other are near in memory ([`morton_order`]).

mod axis;
mod bvh;
mod clearance;
mod face;
mod faces;
mod intersect;
mod nearest;
mod pairs;
mod part;
mod proximity;
mod simd;

pub use axis::{Quad, separating_axis};
pub use bvh::{Aabb, Bvh, morton_order, morton_sorted};
pub use clearance::{Clearance, UNBOUNDED, smaller};
pub use face::ChildId;
pub use faces::{RefinedFaces, evaluate};
pub use nearest::{NearestSearch, Range};
pub use pairs::{TEST, WorkLimit};
pub use part::RefinedPart;
pub use proximity::{NextContacts, Proximity};

use glam::Vec3;
use tailor_mesh::connectivity::{FaceId, Id, IdVec, Topology, VertexId};

/// Faces that one task refines or tests at least.
const FACES_PER_TASK: usize = 64;

/// Twice the area of a face, as a vector along its normal.
pub fn twice_area(vertices: &[VertexId], points: &IdVec<VertexId, Vec3>) -> Vec3 {
    let at = |v: VertexId| points[v] - points[vertices[0]];
    vertices.windows(2).map(|pair| at(pair[0]).cross(at(pair[1]))).sum()
}

/// The faces at some vertices, ascending.
pub fn faces_at(t: &Topology, vertices: impl Iterator<Item = VertexId>) -> Vec<FaceId> {
    let mut faces = unique(t.faces.len(), vertices.flat_map(|v| t.faces_at(v)));
    faces.sort_unstable();
    faces
}

/// Some faces and those that share a vertex with them, ascending.
pub fn with_neighbours(t: &Topology, faces: &[FaceId]) -> Vec<FaceId> {
    let vertices = faces.iter().flat_map(|&f| t.faces.vertices_of(f)).copied();
    faces_at(t, unique(t.vertex_count(), vertices).into_iter())
}

/// Some of `count` elements, each once, in the order in which they first come.
fn unique<I: Id>(count: usize, elements: impl Iterator<Item = I>) -> Vec<I> {
    let mut is_known = IdVec::filled(false, count);
    elements.filter(|&element| !std::mem::replace(&mut is_known[element], true)).collect()
}

/// Elements in ascending order, each once.
pub fn each_once<T: Ord>(mut all: Vec<T>) -> Vec<T> {
    all.sort_unstable();
    all.dedup();
    all
}
