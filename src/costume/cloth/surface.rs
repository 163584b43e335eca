//! The triangles of the simulation mesh with their pieces and UV shells, and queries of distance.

use glam::{Vec3, Vec3A};
use tailor::contact::{Aabb, NearestSearch, TEST, WorkLimit, twice_area};
use tailor::sim::{SimProduct, closest_weights};
use tailor_mesh::connectivity::{CornerId, FaceId, Faces, Groups, Topology, VertexId};
use tailor_mesh::garment::Mesh;

/// Triangles that a query looks at, for each that it may find.
const VISITED: usize = 16;

/// A simulation mesh for queries.
pub struct Surface<'a> {
    pub mesh: &'a Mesh,
    pub topology: &'a Topology,
    /// The connected piece of each triangle, numbered by its first triangle.
    pub pieces: Vec<u32>,
    /// The UV shell of each triangle, numbered by its first triangle.
    pub shells: Vec<u32>,
    search: NearestSearch,
}

/// The box of each face.
pub fn boxes(mesh: &Mesh) -> Vec<Aabb> {
    let corners = |face| mesh.faces.vertices_of(face).iter().map(|&v| Vec3A::from(mesh.points[v]));
    mesh.faces.ids().map(|face| Aabb::of(corners(face))).collect()
}

/// The area of a triangle.
pub fn area([a, b, c]: [Vec3; 3]) -> f64 {
    0.5 * f64::from((b - a).cross(c - a).length())
}

impl<'a> Surface<'a> {
    pub fn new(product: &SimProduct, topology: &'a Topology, mesh: &'a Mesh) -> Self {
        let pieces = groups(topology, |_, _| true);
        let shells = groups(topology, |corner, twin| shares_uvs(product, &mesh.faces, corner, twin));
        Self { mesh, topology, pieces, shells, search: NearestSearch::new(&boxes(mesh)) }
    }

    pub fn triangle(&self, face: FaceId) -> [Vec3; 3] {
        [0, 1, 2].map(|k| self.mesh.points[self.mesh.faces.vertices_of(face)[k]])
    }

    pub fn triangles(&self) -> impl Iterator<Item = [Vec3; 3]> + '_ {
        self.mesh.faces.ids().map(|face| self.triangle(face))
    }

    /// The outer normal at a vertex.
    pub fn normal(&self, vertex: VertexId) -> Vec3 {
        let of = |face| twice_area(self.mesh.faces.vertices_of(face), &self.mesh.points);
        self.topology.faces_at(vertex).map(of).sum::<Vec3>().normalize_or_zero()
    }

    /// The triangles within `reach` of `point` that `wanted` admits, ascending. In a crowd they are `most` of them, or fewer.
    pub fn near(&self, point: Vec3, reach: f32, most: usize, wanted: impl Fn(FaceId) -> bool) -> Vec<FaceId> {
        let near = Aabb::of([point.into()]).expanded(reach);
        let near = self.search.intersecting(&near, &WorkLimit::new(TEST * VISITED * most)).into_iter().map(FaceId::new);
        let is_near = |face: &FaceId| {
            let [a, b, c] = self.triangle(*face);
            let weights = closest_weights(a, b, c, point);
            (a * weights.x + b * weights.y + c * weights.z).distance(point) <= reach
        };
        near.filter(|face| wanted(*face)).filter(is_near).take(most).collect()
    }
}

/// Whether two half-edges of one edge have the same UVs, so that it is not a seam. At a fold of the UVs they have, and the shells
/// of the two sides are mirrored.
pub fn shares_uvs(product: &SimProduct, faces: &Faces, corner: CornerId, twin: CornerId) -> bool {
    let uv = |c: CornerId| product.places[c].uv;
    let sense = |c: CornerId| product.baseline.facets[product.places[c].location.face].sense;
    let are_same = uv(corner) == uv(faces.next(twin)) && uv(faces.next(corner)) == uv(twin);
    are_same && sense(corner) * sense(twin) >= 0.0
}

/// The two half-edges of each edge that has two, the lower one first.
pub fn twins(topology: &Topology) -> impl Iterator<Item = [CornerId; 2]> {
    let pair = |corner| Some([corner, topology.twin(corner).filter(|&twin| corner < twin)?]);
    topology.faces.corners().ids().filter_map(pair)
}

/// Groups of triangles across edges that `joins` admits, each numbered by its first triangle.
fn groups(topology: &Topology, joins: impl Fn(CornerId, CornerId) -> bool) -> Vec<u32> {
    let count = topology.faces.len();
    let mut groups = Groups::<FaceId>::new(count);
    for [corner, twin] in twins(topology).filter(|&[corner, twin]| joins(corner, twin)) {
        groups.join(topology.faces.face_of(corner), topology.faces.face_of(twin));
    }
    let mut numbers = vec![0; count];
    let mut next = 0;
    for face in (0..count).map(FaceId::new) {
        let first = groups.first(face);
        numbers[face.index()] = if first == face { next } else { numbers[first.index()] };
        next += u32::from(first == face);
    }
    numbers
}
