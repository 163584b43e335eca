//! The points of a cage and their clearance: the free distance that operators may use on either side of the surface.
//!
//! Each face of the garment measures its gap to the next layer on both sides. A vertex takes the smallest gap of the
//! faces that it moves.

use crate::contact::{Clearance, RefinedFaces, UNBOUNDED, morton_order, smaller};
use glam::Vec3;
use tailor_mesh::connectivity::{FaceId, IdVec, Topology, VertexId};
use tailor_mesh::garment::{Mesh, Orientation};
use tailor_mesh::subdivide::Level;

/// Share of a gap that each of its two surfaces may use. Below a half, they stay apart.
const GAP_SHARE: f32 = 0.45;
/// Range of the search for gaps, as a multiple of the largest height. Wider gaps do not restrict it.
const GAP_RANGE: f32 = 4.5;

/// The points of a cage.
#[derive(Clone, Debug)]
pub struct CagePoints {
    /// Positions. \[mesh units\]
    pub points: IdVec<VertexId, Vec3>,
    /// The clearance that is left beside each point.
    pub clearance: IdVec<VertexId, Clearance>,
}

impl CagePoints {
    /// The points of a garment. `height` is the largest height of its operators. \[mesh units\]
    pub fn first(garment: &Mesh, level: &Level, height: f32) -> Self {
        let points = garment.points.clone();
        let t = &level.topology;
        if height <= 0.0 {
            let clearance = IdVec::filled(UNBOUNDED, points.len());
            return Self { points, clearance };
        }
        let surface = RefinedFaces::new(level, level.vertex_rows(), &points, &morton_order(&t.faces, &points), None);
        let mut face_gaps = surface.clearances(GAP_RANGE * height);
        if garment.orientation == Orientation::LeftHanded {
            face_gaps.iter_mut().for_each(|gap| gap.reverse());
        }
        // A vertex moves the surface as far as the second ring of faces around it.
        let first_ring = vertex_gaps(t, &face_gaps);
        let of_vertices = |f| t.faces.vertices_of(f).iter().fold(UNBOUNDED, |gap, &v| smaller(gap, first_ring[v]));
        let face_gaps: IdVec<FaceId, Clearance> = t.faces.ids().map(of_vertices).collect();
        let clearance = vertex_gaps(t, &face_gaps).iter().map(|gap| gap.map(|g| GAP_SHARE * g)).collect();
        Self { points, clearance }
    }
}

/// The smallest gap of the faces at each vertex.
fn vertex_gaps(t: &Topology, gaps: &IdVec<FaceId, Clearance>) -> IdVec<VertexId, Clearance> {
    let mut smallest = IdVec::filled(UNBOUNDED, t.vertex_count());
    for (face, &gap) in gaps.enumerated() {
        t.faces.vertices_of(face).iter().for_each(|&v| smallest[v] = smaller(smallest[v], gap));
    }
    smallest
}
