//! Flip free edges towards the Delaunay condition, by which the opposite angles sum to at most π, and towards valence 6.

use super::drift::drift_with;
use super::queue::edges;
use super::valence::ValenceExcess;
use crate::sim::sim_mesh::SimMesh;
use glam::Vec3;
use rayon::prelude::*;
use tailor_mesh::connectivity::edit::{next, prev};
use tailor_mesh::connectivity::{CornerId, VertexId};

/// Sweeps over all edges; each flip raises the smallest angle of its pair, so a few suffice.
const MAX_SWEEPS: usize = 8;
/// The angles must exceed π by this sine before an edge is flipped, so that rounding cannot flip it back.
const MIN_GAIN: f32 = 1e-4;

/// Flips until no edge gains by it. `regularity` weighs one square of valence excess against the sine of the angle by which
/// an edge is not Delaunay: 0 gives a Delaunay mesh. Returns the number of flips.
pub fn flip_edges(mesh: &mut SimMesh<'_>, regularity: f32) -> usize {
    let mut excess = ValenceExcess::new(mesh);
    flip_for_angles(mesh, &mut excess, regularity)
}

/// [`flip_edges`], followed by drifts of irregular vertices.
pub fn flip_and_drift(mesh: &mut SimMesh<'_>, regularity: f32) -> usize {
    let mut excess = ValenceExcess::new(mesh);
    flip_for_angles(mesh, &mut excess, regularity) + drift_with(mesh, &mut excess)
}

fn flip_for_angles(mesh: &mut SimMesh<'_>, excess: &mut ValenceExcess, regularity: f32) -> usize {
    let wants_flip = |mesh: &SimMesh<'_>, excess: &ValenceExcess, h: CornerId| {
        !mesh.is_constrained(h) && gain(mesh, excess, h, regularity) > MIN_GAIN
    };
    let mut candidates: Vec<CornerId> = edges(mesh).filter(|&h| wants_flip(mesh, excess, h)).collect();
    let mut count = 0;
    for _ in 0..MAX_SWEEPS {
        let mut touched = Vec::new();
        for half in candidates {
            let Some(twin) = mesh.topology.twin(half) else { continue };
            if wants_flip(mesh, excess, half) && mesh.may_flip(half) && mesh.flip_is_safe(half) {
                excess.flip(mesh, half);
                count += 1;
                touched.extend([half, twin, prev(half), prev(twin)].map(|c| mesh.topology.vertex(c)));
            }
        }
        if touched.is_empty() {
            break;
        }
        candidates = inner_edges_around(mesh, touched);
    }
    mesh.debug_check();
    count
}

/// The inner edges at some vertices and opposite to them: their gains depend on the valences of these vertices.
fn inner_edges_around(mesh: &SimMesh<'_>, mut vertices: Vec<VertexId>) -> Vec<CornerId> {
    vertices.sort_unstable();
    vertices.dedup();
    let t = &mesh.topology;
    let corners = vertices.into_iter().flat_map(|v| t.fan(v)).flat_map(|c| [c, next(c)]);
    let mut edges: Vec<CornerId> = corners.filter_map(|c| Some(c.min(t.twin(c)?))).collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

/// The gain of flipping an edge, in sines.
#[inline]
fn gain(mesh: &SimMesh<'_>, excess: &ValenceExcess, half: CornerId, regularity: f32) -> f32 {
    let Some(twin) = mesh.topology.twin(half) else { return -1.0 };
    // Written out: mapped arrays do not stay in registers, and this runs on every edge.
    let point = |x: CornerId| mesh.points[mesh.topology.vertex(x)];
    let (a, b, c, d) = (point(half), point(twin), point(prev(half)), point(prev(twin)));
    let change = excess.change(mesh, half);
    let is_acute = (a - c).dot(b - c) >= 0.0 && (a - d).dot(b - d) >= 0.0;
    if (change >= 0 || regularity == 0.0) && is_acute {
        return -1.0;
    }
    let ((s1, c1), (s2, c2)) = (opposite_angle(c, a, b), opposite_angle(d, a, b));
    let (one, two) = (s1 * s1 + c1 * c1, s2 * s2 + c2 * c2);
    let product = one * two;
    // The eighth power of a length is not a number of single precision where edges are very long or very short.
    let size = if product.is_normal() { product.sqrt() } else { one.sqrt() * two.sqrt() };
    let size = size.max(f32::MIN_POSITIVE);
    // The sine of the sum is negative where that exceeds π.
    -(s1 * c2 + c1 * s2) / size - regularity * change as f32
}

/// Sine and cosine of an angle, both times the same positive number.
#[inline]
fn opposite_angle(apex: Vec3, a: Vec3, b: Vec3) -> (f32, f32) {
    let (u, v) = (a - apex, b - apex);
    (u.cross(v).length(), u.dot(v))
}
