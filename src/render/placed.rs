//! Where the points of a stage are, and how much room is left about them.

use crate::contact::{Clearance as Gap, RefinedFaces, UNBOUNDED as OPEN, morton_order, smaller as least};
use crate::garment::Orientation;
use crate::mesh::{FaceId, IdVec, Topology, VertexId};
use crate::subdivide::Cage;
use glam::Vec3;

/// How far a vertex may go against and along the normal until it meets another layer. \[stage units\]
pub type Room = Gap;

/// Part of a gap that each of its two sides has. Below a half, they do not meet.
const PART_OF_GAP: f32 = 0.45;
/// Gaps are looked for as far as this many times the largest height, so that those that are found are too small.
const REACH: f32 = 4.5;

/// The points of a stage.
#[derive(Clone, Debug)]
pub struct Placed {
    /// Where the vertices are.
    pub points: IdVec<VertexId, Vec3>,
    /// The room that operators have left about them.
    pub rooms: IdVec<VertexId, Room>,
}

impl Placed {
    /// The points of a cage before any operator, where none goes further than `height` from the surface.
    pub fn first(cage: &Cage, height: f32) -> Self {
        let points = cage.garment().points.clone();
        let t = &cage.level().topology;
        if height <= 0.0 {
            let rooms = IdVec::filled(OPEN, points.len());
            return Self { points, rooms };
        }
        let faces = RefinedFaces::new(
            cage.level(),
            cage.level().vertex_rows(),
            &points,
            &morton_order(&t.faces, &points),
            None,
        );
        let mut of_faces = faces.clearances(REACH * height);
        if cage.garment().orientation == Orientation::LeftHanded {
            of_faces.iter_mut().for_each(|gap| gap.reverse());
        }
        // A vertex moves the surface as far as the second ring of faces around it.
        let near = around(t, &of_faces);
        let of_faces: IdVec<FaceId, Gap> =
            t.faces.ids().map(|f| t.faces.vertices_of(f).iter().fold(OPEN, |gap, &v| least(gap, near[v]))).collect();
        let rooms = around(t, &of_faces).iter().map(|gap| gap.map(|g| PART_OF_GAP * g)).collect();
        Self { points, rooms }
    }

    /// Memory that it holds. \[bytes\]
    pub fn bytes(&self) -> usize {
        size_of_val(self.points.as_slice()) + size_of_val(self.rooms.as_slice())
    }
}

/// The least gap of the faces at each vertex.
fn around(t: &Topology, gaps: &IdVec<FaceId, Gap>) -> IdVec<VertexId, Gap> {
    let mut rooms = IdVec::filled(OPEN, t.vertex_count());
    for (face, &gap) in gaps.enumerated() {
        t.faces.vertices_of(face).iter().for_each(|&v| rooms[v] = least(rooms[v], gap));
    }
    rooms
}
