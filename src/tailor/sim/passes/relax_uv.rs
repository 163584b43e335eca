//! Relaxation in the constraint UVs: free vertices move to the centroid of their triangles there, and are lifted back to the
//! surface.
//!
//! Source: Waggoner and de Goes, *Revamping the Cloth Tailoring Pipeline at Pixar* (SIGGRAPH Talks 2022).

use crate::sim::sim_mesh::{Destination, SimMesh};
use glam::Vec2;
use rayon::prelude::*;
use tailor_mesh::connectivity::edit::{next, prev};
use tailor_mesh::connectivity::{IdVec, VertexId, WedgeId};

/// The wedge of a free vertex, and those of the two other corners of each triangle around it.
struct UvRing {
    /// Index of the vertex's destination.
    at: usize,
    own: WedgeId,
    triangles: Vec<[WedgeId; 2]>,
}

/// Replaces the destinations of free vertices by the centroids around them in UV, after `sweeps` averages. Where there is no
/// layout, or a flipped one, destinations stay.
pub fn move_in_uv(mesh: &SimMesh<'_>, sweeps: usize, destinations: &mut [(VertexId, Destination)]) {
    let rings = destinations.par_iter().enumerate().filter_map(|(at, &(v, _))| UvRing::new(mesh, at, v));
    let rings: Vec<UvRing> = rings.collect();
    let mut uvs: IdVec<WedgeId, Vec2> = mesh.wedges.iter().map(|wedge| wedge.place.uv).collect();
    let mut weights: IdVec<WedgeId, f32> = IdVec::filled(0.0, mesh.wedges.len());
    for corner in mesh.topology.corners() {
        weights[mesh.corner_wedge[corner]] = mesh.target[mesh.topology.vertex(corner)].powi(-2);
    }
    for _ in 0..sweeps {
        let moved: Vec<Vec2> = rings.par_iter().map(|ring| ring.centroid(&uvs, &weights)).collect();
        rings.iter().zip(moved).for_each(|(ring, uv)| uvs[ring.own] = uv);
    }
    for ring in &rings {
        destinations[ring.at].1 = Destination::AtUv(uvs[ring.own]);
    }
}

impl UvRing {
    /// The ring of a free vertex; none if not all of it has a layout.
    fn new(mesh: &SimMesh<'_>, at: usize, vertex: VertexId) -> Option<Self> {
        let own = mesh.corner_wedge[mesh.topology.fan(vertex).next()?];
        let around = mesh.topology.fan(vertex).map(|c| [next(c), prev(c)].map(|c| mesh.corner_wedge[c]));
        let triangles: Vec<[WedgeId; 2]> = around.collect();
        let has_layout = |wedge: WedgeId| mesh.wedges[wedge].sense != 0.0;
        let is_whole = has_layout(own) && triangles.as_flattened().iter().all(|&wedge| has_layout(wedge));
        is_whole.then_some(Self { at, own, triangles })
    }

    /// The centroid of its triangles. They count by their area in UV against their target; flipped ones do not.
    fn centroid(&self, uvs: &IdVec<WedgeId, Vec2>, weights: &IdVec<WedgeId, f32>) -> Vec2 {
        let own = uvs[self.own];
        let (mut sum, mut total) = (Vec2::ZERO, 0.0);
        let sense: f32 = self.triangles.iter().map(|t| (uvs[t[0]] - own).perp_dot(uvs[t[1]] - own)).sum();
        for &[b, c] in &self.triangles {
            let (u, v) = (uvs[b] - own, uvs[c] - own);
            let weight = (u.perp_dot(v) * sense.signum()).max(0.0) * (weights[self.own] + weights[b] + weights[c]);
            sum += weight * (u + v);
            total += weight;
        }
        if total > 0.0 { own + sum / (3.0 * total) } else { own }
    }
}
