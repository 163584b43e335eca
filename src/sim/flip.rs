//! Flip every free edge whose opposite angles sum to more than π.

use super::mesh::SimMesh;
use crate::mesh::CornerId;
use crate::mesh::edit::{next, prev};
use glam::Vec3;
use rayon::prelude::*;

/// Sweeps over all edges; each flip raises the smallest angle of its pair, so a few suffice.
const MAX_SWEEPS: usize = 8;
/// The angles must exceed π by this sine before an edge is flipped, so that rounding cannot turn it back.
const MIN_GAIN: f32 = 1e-4;

/// Flips until no edge gains by it. Returns the number of flips.
pub fn flip_edges(mesh: &mut SimMesh<'_>) -> usize {
    let mut count = 0;
    let all = (0..mesh.topology.corner_slots()).into_par_iter().map(CornerId::new);
    let mut candidates: Vec<CornerId> =
        all.filter(|&h| mesh.topology.is_edge(h) && !mesh.is_constrained(h) && wants_flip(mesh, h)).collect();
    for _ in 0..MAX_SWEEPS {
        let mut touched = Vec::new();
        for half in candidates {
            if wants_flip(mesh, half) && may_flip(mesh, half) && flip_is_safe(mesh, half) {
                let twin = mesh.topology.twin(half);
                mesh.flip(half);
                count += 1;
                for c in std::iter::once(half).chain(twin) {
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

/// Neither new triangle is worse than the worse of the old.
fn flip_is_safe(mesh: &SimMesh<'_>, half: CornerId) -> bool {
    let Some(twin) = mesh.topology.twin(half) else { return false };
    let [a, b, c, d] = [half, next(half), prev(half), prev(twin)].map(|x| mesh.corner(x));
    let new = mesh.badness([c, d, b]).max(mesh.badness([d, c, a]));
    new == 0 || new < mesh.face_badness(half).max(mesh.face_badness(twin))
}
