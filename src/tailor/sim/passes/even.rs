//! Even spacing along chains.

use crate::sim::constraints::spacing::SHORTEST;
use crate::sim::sim_mesh::SimMesh;
use glam::Vec3;
use tailor_mesh::connectivity::edit::prev;
use tailor_mesh::connectivity::{CornerId, VertexId};

/// Weight of the centroid of the triangles on both sides, against even edges along the chain. Larger values make better
/// triangles, smaller ones more even edges.
const CENTROID_WEIGHT: f32 = 0.8;
/// Where bends shorten the edges of a chain to this share of the target length or less, [`CENTROID_WEIGHT`] falls, to zero
/// at [`SHORTEST`]. A smaller share lets chords cut off more of the bends: 0.8 leaves 0.3 % more of curves off their chords.
const STRAIGHT: f32 = 1.0;
/// Largest share of a chain's edge that its end slides at once, so that two ends never pass each other.
const LONGEST_SLIDE: f32 = 0.4;

/// The signed arc length by which a chain's vertex should slide. \[mesh units\]
pub fn even_slide(mesh: &SimMesh<'_>, vertex: VertexId) -> Option<f32> {
    let near = mesh.curve_neighbours(vertex)?;
    let half_way = 0.5 * (near.before.count() + near.after.count());
    let even = mesh.chain(near.after.chain).at_count(near.before.counts[0] + half_way) - near.arc_length();
    let [ahead, back] = [near.ahead, near.back].map(|half| mesh.points[mesh.topology.other_end(half, vertex)]);
    let central = (ahead - back).normalize_or_zero().dot(to_centroid(mesh, vertex));
    let [low, high] = near.lengths();
    let share = CENTROID_WEIGHT * freedom(mesh, vertex, near.ahead);
    Some((even + share * (central - even)).clamp(LONGEST_SLIDE * -low, LONGEST_SLIDE * high.max(0.0)))
}

/// How freely a chain's vertex may slide, 0 to 1: where the curve bends as sharply as edges follow it, uneven edges would
/// cut it off. `ahead` is the constrained edge along the chain.
fn freedom(mesh: &SimMesh<'_>, vertex: VertexId, ahead: CornerId) -> f32 {
    let straight = mesh.target[vertex] / mesh.baseline.target_at(mesh.place(ahead).location);
    ((straight - SHORTEST) / (STRAIGHT - SHORTEST)).clamp(0.0, 1.0)
}

/// The vector from a vertex to the centroid of the triangles around it.
fn to_centroid(mesh: &SimMesh<'_>, vertex: VertexId) -> Vec3 {
    let own = mesh.points[vertex];
    let (mut sum, mut weight) = (Vec3::ZERO, 0.0f32);
    for corner in mesh.topology.fan(vertex) {
        let (a, b) = (mesh.topology.target(corner), mesh.topology.vertex(prev(corner)));
        let (u, v) = (mesh.points[a] - own, mesh.points[b] - own);
        let w = u.cross(v).length();
        sum += w * (u + v);
        weight += w;
    }
    sum / (3.0 * weight).max(f32::MIN_POSITIVE)
}
