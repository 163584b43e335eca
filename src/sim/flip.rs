//! Flip every free edge whose opposite angles sum to more than π.

use super::mesh::SimMesh;
use super::exp::exp;
use crate::mesh::{CornerId, IdVec, VertexId};
use crate::mesh::edit::{next, prev};
use glam::Vec3;
use rayon::prelude::*;

/// Sweeps over all edges; each flip raises the smallest angle of its pair, so a few suffice.
const MAX_SWEEPS: usize = 8;
/// The angles must exceed π by this sine before an edge is flipped, so that rounding cannot turn it back.
const MIN_GAIN: f32 = 1e-4;

/// Cosine of the angle between a new triangle and the surface at its corners above which it lies well. Larger values
/// keep more flips from turning edges out of a fold.
const MIN_ALIGNMENT: f32 = 0.85;

/// Flips until no edge gains by it. Returns the number of flips.
pub fn flip_edges(mesh: &mut SimMesh<'_>, regular: f32) -> usize {
    let mut count = 0;
    let mut excess = excess(mesh);
    let slots = mesh.topology.corner_slots();
    let all = (0..slots).into_par_iter().map(CornerId::new);
    let mut candidates: Vec<CornerId> = all
        .filter(|&h| mesh.topology.is_edge(h) && !mesh.is_constrained(h) && gain(mesh, &excess, h, regular) > MIN_GAIN)
        .collect();
    for _ in 0..MAX_SWEEPS {
        let mut touched = Vec::new();
        for half in candidates {
            if gain(mesh, &excess, half, regular) > MIN_GAIN && may_flip(mesh, half) && flip_is_safe(mesh, half) {
                let Some(twin) = mesh.topology.twin(half) else { continue };
                let [a, b, c, d] = [half, twin, prev(half), prev(twin)].map(|x| mesh.topology.vertex(x));
                for (v, by) in [(a, -1), (b, -1), (c, 1), (d, 1)] { excess[v] += by; }
                mesh.flip(half);
                count += 1;
                for c in [half, twin] {
                    touched.extend([next(c), prev(c)]);
                }
            }
        }
        if touched.is_empty() {
            break;
        }
        touched.sort_unstable();
        touched.dedup();
        candidates = touched;
    }
    count
}

fn excess(mesh: &SimMesh<'_>) -> IdVec<VertexId, i8> {
    let mut excess: IdVec<VertexId, i8> = IdVec::filled(-6, mesh.points.len());
    for c in mesh.topology.corners() {
        excess[mesh.topology.vertex(c)] += 1;
        if mesh.topology.twin(c).is_none() {
            // One more edge than triangles, and half a fan.
            excess[mesh.topology.vertex(c)] += 3;
        }
    }
    excess
}

/// What a flip gains.
#[inline]
fn gain(mesh: &SimMesh<'_>, excess: &IdVec<VertexId, i8>, half: CornerId, regular: f32) -> f32 {
    let Some(twin) = mesh.topology.twin(half) else { return -1.0 };
    let [va, vb, vc, vd] = [half, twin, prev(half), prev(twin)].map(|x| mesh.topology.vertex(x));
    let [a, b, c, d] = [va, vb, vc, vd].map(|x| mesh.points[x]);
    let [ea, eb, ec, ed] = [excess[va], excess[vb], excess[vc], excess[vd]];
    // The change of the sum of squares.
    let change = 4 + 2 * (i32::from(ec) + i32::from(ed) - i32::from(ea) - i32::from(eb));
    if change >= 0 && (a - c).dot(b - c) >= 0.0 && (a - d).dot(b - d) >= 0.0 {
        return -1.0;
    }
    let ((s1, c1), (s2, c2)) = (opposite_angle(c, a, b), opposite_angle(d, a, b));
    // Sine of the sum; negative where it exceeds pi.
    let norm = ((s1 * s1 + c1 * c1) * (s2 * s2 + c2 * c2)).sqrt().max(f32::MIN_POSITIVE);
    let sine = (s1 * c2 + c1 * s2) / norm;
    if exp(9, 0.0) == 1.0 {
        // new min angle guard
        let ((s3, c3), (s4, c4)) = (opposite_angle(a, c, d), opposite_angle(b, c, d));
        let sum = s3 * c4 + c3 * s4;
        if sum < 0.0 && sum * sum > exp(10, 0.5).powi(2) * (s3 * s3 + c3 * c3) * (s4 * s4 + c4 * c4) { return -1.0; }
    }
    -sine - regular * change as f32
}

/// Sine and cosine of an angle, both times the same positive number.
#[inline]
fn opposite_angle(apex: Vec3, a: Vec3, b: Vec3) -> (f32, f32) {
    let (u, v) = (a - apex, b - apex);
    (u.cross(v).length(), u.dot(v))
}

/// Whether the angles opposite the edge sum to more than π.
#[inline]
pub fn wants_flip(mesh: &SimMesh<'_>, half: CornerId) -> bool {
    let Some(twin) = mesh.topology.twin(half) else { return false };
    let [a, b, c, d] = [half, twin, prev(half), prev(twin)].map(|x| mesh.points[mesh.topology.vertex(x)]);
    let ((s1, c1), (s2, c2)) = (opposite_angle(c, a, b), opposite_angle(d, a, b));
    // sin(x + y) < 0 means x + y > π.
    let sum = s1 * c2 + c1 * s2;
    sum < 0.0 && sum * sum > MIN_GAIN * MIN_GAIN * (s1 * s1 + c1 * c1) * (s2 * s2 + c2 * c2)
}

fn may_flip(mesh: &SimMesh<'_>, half: CornerId) -> bool {
    !mesh.is_constrained(half) && mesh.topology.may_flip(half)
}

/// Neither new triangle is worse than the worse of the old, or turns further from the surface than those, if it turns
/// far.
fn flip_is_safe(mesh: &SimMesh<'_>, half: CornerId) -> bool {
    let Some(twin) = mesh.topology.twin(half) else { return false };
    let [a, b, c, d] = [half, next(half), prev(half), prev(twin)].map(|x| mesh.corner(x));
    let new = mesh.badness([c, d, b]).max(mesh.badness([d, c, a]));
    let aligned = || {
        let after = mesh.alignment([c, d, b]).min(mesh.alignment([d, c, a]));
        after >= MIN_ALIGNMENT || after >= mesh.alignment([a, b, c]).min(mesh.alignment([b, a, d]))
    };
    (new == 0 && aligned()) || new < mesh.face_badness(half).max(mesh.face_badness(twin))
}
