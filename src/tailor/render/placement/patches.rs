//! The limit surface of some faces of a cage, between its vertices too.
//!
//! Each corner of a face has a patch: the limit of its child quad, by the biquadratic through nine points of the limit
//! surface. It needs no other rules at creases, borders and extraordinary vertices than limit positions do.

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::sync::Arc;
use tailor_mesh::connectivity::{CornerId, FaceId, IdVec, Topology, VertexId};
use tailor_mesh::garment::Scheme;
use tailor_mesh::subdivide::{Connectivity, Level, Numbering, carried_points, child_corner};

/// Steps to a nearer point.
const STEPS: usize = 2;
/// Weight below which a vertex is not a source of a place.
const LEAST_WEIGHT: f32 = 1e-6;

/// Where a vertex is on a cage, and so how it may slide on the limit surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CagePlace {
    /// At the vertex of a corner: nowhere.
    Vertex(CornerId),
    /// On the edge after a corner, along its curve. The share of its length.
    Edge(CornerId, f32),
    /// In the child quad of a corner: anywhere. Shares of half the edges after and before the corner.
    Face(CornerId, Vec2),
}

impl CagePlace {
    /// The place of a weighted sum of vertices of a face; none if there are no such vertices.
    pub fn new(t: &Topology, face: FaceId, sources: &[(VertexId, f32)]) -> Option<Self> {
        let weight = |c: CornerId| {
            let of = sources.iter().filter(|source| source.0 == t.faces.vertex(c));
            of.map(|source| source.1).sum::<f32>()
        };
        let used = t.faces.corners_of(face).filter(|&c| weight(c) > LEAST_WEIGHT);
        let corner = used.clone().max_by(|&a, &b| weight(a).total_cmp(&weight(b)).then(b.cmp(&a)))?;
        let (next, prev) = (t.faces.next(corner), t.faces.prev(corner));
        let [after, before] = [next, prev].map(weight);
        match used.count() {
            1 => Some(Self::Vertex(corner)),
            2 if after > LEAST_WEIGHT => Some(Self::Edge(corner, after)),
            2 if before > LEAST_WEIGHT => Some(Self::Edge(prev, 1.0 - before)),
            _ => Some(Self::Face(corner, in_child_quad(t.faces.valence(face), after, before))),
        }
    }

    /// The face.
    pub fn face(self, t: &Topology) -> FaceId {
        let (Self::Vertex(corner) | Self::Edge(corner, _) | Self::Face(corner, _)) = self;
        t.faces.face_of(corner)
    }
}

/// The shares in the child quad of a corner with the largest weight, from the weights of the corners after and before it.
fn in_child_quad(valence: usize, after: f32, before: f32) -> Vec2 {
    // The quad has the corner, the middles of its edges, and the mean of all corners.
    let bend = 0.5 - 1.0 / valence as f32;
    let difference = 2.0 * (after - before);
    let slope = 0.5 - bend * difference;
    let root = (slope * slope - 4.0 * bend * before).max(0.0).sqrt();
    let v = 2.0 * before / (slope + root).max(f32::MIN_POSITIVE);
    Vec2::new(v + difference, v).clamp(Vec2::ZERO, Vec2::ONE)
}

/// The patches of some faces.
pub struct Patches {
    parent: Arc<Connectivity>,
    /// The first patch of each face that has them.
    first: IdVec<FaceId, Option<u32>>,
    /// For each corner, a grid of points: rows of three along the edge after it.
    grids: Vec<[Vec3; 9]>,
}

impl Patches {
    /// The patches of `faces` (ascending) of a cage with `points`.
    pub fn new(parent: Arc<Connectivity>, points: &IdVec<VertexId, Vec3>, faces: &[FaceId]) -> Self {
        let t = &parent.level().topology;
        let mut first = IdVec::filled(None, t.faces.len());
        let mut count = 0;
        for &face in faces {
            first[face] = Some(count);
            count += t.faces.valence(face) as u32;
        }
        let grids = grids(parent.level(), points, faces);
        Self { parent, first, grids }
    }

    /// Their memory. \[bytes\]
    pub fn bytes(&self) -> usize {
        size_of_val(self.grids.as_slice()) + size_of_val(self.first.as_slice())
    }

    fn topology(&self) -> &Topology {
        &self.parent.level().topology
    }

    fn grid(&self, corner: CornerId) -> Option<&[Vec3; 9]> {
        let faces = &self.topology().faces;
        let face = faces.face_of(corner);
        let first = self.first[face]? as usize;
        self.grids.get(first + corner.index() - faces.range(face).start)
    }

    /// The point at a place.
    pub fn at(&self, place: CagePlace) -> Option<Vec3> {
        Some(match place {
            CagePlace::Vertex(corner) => self.grid(corner)?[0],
            CagePlace::Edge(corner, share) => self.on_edge(corner, share)?[0],
            CagePlace::Face(corner, shares) => evaluate(self.grid(corner)?, shares)[0],
        })
    }

    /// A place nearer to `point`, as far as a vertex can slide there, and the point at it. Further steps change little, as
    /// the fit that asks goes on from the place.
    pub fn nearer(&self, mut place: CagePlace, point: Vec3) -> Option<(CagePlace, Vec3)> {
        for _ in 0..STEPS {
            place = self.step(place, point)?;
        }
        Some((place, self.at(place)?))
    }

    /// One step of Newton's method towards `point`.
    fn step(&self, place: CagePlace, point: Vec3) -> Option<CagePlace> {
        Some(match place {
            CagePlace::Vertex(_) => place,
            CagePlace::Edge(corner, share) => {
                let [at, along] = self.on_edge(corner, share)?;
                let step = (point - at).dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
                CagePlace::Edge(corner, (share + step).clamp(0.0, 1.0))
            }
            CagePlace::Face(corner, shares) => {
                let [at, along, across] = evaluate(self.grid(corner)?, shares);
                let (corner, shares) = self.within(corner, shares + least_squares(along, across, point - at));
                CagePlace::Face(corner, shares)
            }
        })
    }

    /// Position on the curve of the edge after a corner, and its derivative.
    fn on_edge(&self, corner: CornerId, share: f32) -> Option<[Vec3; 2]> {
        if share <= 0.5 {
            let [point, along, _] = evaluate(self.grid(corner)?, Vec2::new(2.0 * share, 0.0));
            return Some([point, 2.0 * along]);
        }
        let [point, _, along] =
            evaluate(self.grid(self.topology().faces.next(corner))?, Vec2::new(0.0, 2.0 - 2.0 * share));
        Some([point, -2.0 * along])
    }

    /// The patch in which shares beyond those of a corner's patch are, and the shares there.
    fn within(&self, corner: CornerId, shares: Vec2) -> (CornerId, Vec2) {
        let (faces, Vec2 { x, y }) = (&self.topology().faces, shares);
        let beyond = if x > 1.0 {
            Some((faces.next(corner), Vec2::new(y, 2.0 - x)))
        } else if y > 1.0 {
            Some((faces.prev(corner), Vec2::new(2.0 - y, x)))
        } else if y < 0.0 {
            self.topology().twin(corner).map(|twin| (faces.next(twin), Vec2::new(-y, x)))
        } else if x < 0.0 {
            self.topology().twin(faces.prev(corner)).map(|twin| (twin, Vec2::new(y, -x)))
        } else {
            None
        };
        // A neighbour of opposite winding has the vertex elsewhere.
        let is_known = |c: CornerId| {
            let is_beside = x > 1.0 || y > 1.0 || faces.vertex(c) == faces.vertex(corner);
            is_beside && self.first[faces.face_of(c)].is_some()
        };
        let (corner, shares) = beyond.filter(|&(c, _)| is_known(c)).unwrap_or((corner, shares));
        (corner, shares.clamp(Vec2::ZERO, Vec2::ONE))
    }
}

/// The limit points of the child quads of some faces.
fn grids(level: &Level, points: &IdVec<VertexId, Vec3>, faces: &[FaceId]) -> Vec<[Vec3; 9]> {
    let t = &level.topology;
    let mut is_needed = IdVec::filled(false, t.faces.len());
    let around = faces.iter().flat_map(|&face| t.faces.vertices_of(face)).flat_map(|&v| t.faces_at(v));
    around.for_each(|face| is_needed[face] = true);
    let needed: Vec<FaceId> = is_needed.ids().filter(|&face| is_needed[face]).collect();
    let (mut part, whole) = level.part(&needed);
    if part.scheme == Scheme::Loop {
        // Loop surfaces are their triangles here, as for limit positions.
        part.scheme = Scheme::Bilinear;
    }
    let mut limits: IdVec<VertexId, Vec3> = whole.iter().map(|&v| points[v]).collect();
    let first = part.refined();
    limits = carried_points(&part.vertex_rows(), &limits);
    let second = first.refined();
    limits = carried_points(&first.vertex_rows(), &limits);
    limits = carried_points(&&second.limit_rows(), &limits);
    let numbering = Numbering::new(&first);
    let grid = |corner: CornerId| {
        let corners = [0, 1, 2, 3].map(|k| child_corner(&part.topology.faces, corner, k));
        let vertex = corners.map(|c| limits[numbering.of_vertex(first.topology.faces.vertex(c))]);
        let edge = corners.map(|c| limits[numbering.of_edge(first.topology.corner_edge[c])]);
        let centre = limits[numbering.of_face(first.topology.faces.face_of(corners[0]))];
        [vertex[0], edge[0], vertex[1], edge[3], centre, edge[1], vertex[3], edge[2], vertex[2]]
    };
    let corners = |&face: &FaceId| {
        let own = FaceId::new(needed.partition_point(|&other| other < face));
        part.topology.faces.corners_of(own)
    };
    faces.par_iter().flat_map_iter(|face| corners(face).map(grid)).collect()
}

/// Position and derivatives of the biquadratic through a grid.
fn evaluate(grid: &[Vec3; 9], shares: Vec2) -> [Vec3; 3] {
    let weights = |x: f32| [(1.0 - x) * (1.0 - 2.0 * x), 4.0 * x * (1.0 - x), x * (2.0 * x - 1.0)];
    let slopes = |x: f32| [4.0 * x - 3.0, 4.0 - 8.0 * x, 4.0 * x - 1.0];
    let sum =
        |along: [f32; 3], across: [f32; 3]| -> Vec3 { (0..9).map(|i| along[i % 3] * across[i / 3] * grid[i]).sum() };
    let [along, across] = [shares.x, shares.y].map(weights);
    [sum(along, across), sum(slopes(shares.x), across), sum(along, slopes(shares.y))]
}

/// The multiples of two directions that come nearest to an offset.
fn least_squares(along: Vec3, across: Vec3, offset: Vec3) -> Vec2 {
    let (a, b, c) = (along.length_squared(), along.dot(across), across.length_squared());
    let (x, y) = (along.dot(offset), across.dot(offset));
    let determinant = a * c - b * b;
    let step = Vec2::new(c * x - b * y, a * y - b * x) / determinant;
    if determinant > 1e-6 * a * c && step.is_finite() { step } else { Vec2::ZERO }
}
