//! Flip every free edge whose opposite angles sum to more than π.

use crate::mesh::edit::{next, prev};
use crate::mesh::{CornerId, IdVec, VertexId, WedgeId};
use crate::sim::passes::drift::drift_with;
use crate::sim::sim_mesh::{SimMesh, VertexConstraint};
use glam::Vec3;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::f32::consts::FRAC_PI_3;

/// Sweeps over all edges; each flip raises the smallest angle of its pair, so a few suffice.
const MAX_SWEEPS: usize = 8;
/// The angles must exceed π by this sine before an edge is flipped, so that rounding cannot turn it back.
const MIN_GAIN: f32 = 1e-4;

/// Cosine of the angle between a new triangle and the surface at its corners above which it lies well. Larger values
/// keep more flips from turning edges out of a fold.
const MIN_ALIGNMENT: f32 = 0.85;

/// Vertices whose excess one task finds.
const VERTICES_PER_TASK: usize = 4096;

/// Flips until no edge gains by it. `regularity` is what one square of excess weighs against the sine of the angle by
/// which an edge is not Delaunay: 0 gives a Delaunay mesh. Returns the number of flips.
pub fn flip_edges(mesh: &mut SimMesh<'_>, regularity: f32) -> usize {
    let mut excess = excess(mesh);
    flip_for_angles(mesh, &mut excess, regularity)
}

/// The same, and then runs of flips for regular vertices alone.
pub fn flip_and_drift(mesh: &mut SimMesh<'_>, regularity: f32) -> usize {
    let mut excess = excess(mesh);
    flip_for_angles(mesh, &mut excess, regularity) + drift_with(mesh, &mut excess)
}

fn flip_for_angles(mesh: &mut SimMesh<'_>, excess: &mut ValenceExcess, regularity: f32) -> usize {
    let all = (0..mesh.topology.corner_slots()).into_par_iter().map(CornerId::new);
    let wants = |mesh: &SimMesh<'_>, excess: &ValenceExcess, h: CornerId| gain(mesh, excess, h, regularity) > MIN_GAIN;
    let mut candidates: Vec<CornerId> =
        all.filter(|&h| mesh.topology.is_edge(h) && !mesh.is_constrained(h) && wants(mesh, excess, h)).collect();
    let mut count = 0;
    let mut touched = Vec::new();
    for _ in 0..MAX_SWEEPS {
        for &half in &candidates {
            let Some(twin) = mesh.topology.twin(half).filter(|_| !mesh.is_constrained(half)) else { continue };
            if wants(mesh, excess, half) && may_flip(mesh, half) && flip_is_safe(mesh, half) {
                flip_with(mesh, excess, half);
                count += 1;
                touched.extend([half, twin].into_iter().flat_map(|c| [next(c), prev(c)]));
            }
        }
        if touched.is_empty() {
            break;
        }
        touched.sort_unstable();
        touched.dedup();
        std::mem::swap(&mut candidates, &mut touched);
        touched.clear();
    }
    count
}

/// Flips an edge that may be, and keeps `excess` up with it.
pub(crate) fn flip_with(mesh: &mut SimMesh<'_>, excess: &mut ValenceExcess, half: CornerId) {
    count_flip(mesh, excess, half, 1);
    mesh.flip(half);
}

/// Turns an edge back that was flipped, and keeps `excess` up with it.
pub(crate) fn unflip_with(mesh: &mut SimMesh<'_>, excess: &mut ValenceExcess, half: CornerId) {
    mesh.unflip(half);
    count_flip(mesh, excess, half, -1);
}

/// Counts a flip that is to come, or takes back one that is no more (`sign` -1).
fn count_flip(mesh: &SimMesh<'_>, excess: &mut ValenceExcess, half: CornerId, sign: i8) {
    let Some(twin) = mesh.topology.twin(half) else { return };
    let wedges = [half, twin, prev(half), prev(twin)].map(|c| mesh.corner_wedge[c]);
    wedges.into_iter().zip([-sign, -sign, sign, sign]).for_each(|(wedge, by)| excess[wedge] += by);
}

/// Triangles in each sector of a vertex above the best number: six at a free vertex, three on each side of a chain, and
/// between the chains of an anchor what makes angles of 60 degrees.
pub(crate) type ValenceExcess = IdVec<WedgeId, i8>;

pub(crate) fn excess(mesh: &SimMesh<'_>) -> ValenceExcess {
    let slots = mesh.topology.vertex_slots();
    let tasks = (0..slots.div_ceil(VERTICES_PER_TASK)).into_par_iter();
    let found = tasks.map(|t| {
        let (first, end) = (t * VERTICES_PER_TASK, slots.min((t + 1) * VERTICES_PER_TASK));
        let mut found = Vec::with_capacity(end - first);
        (first..end).for_each(|v| excess_at(mesh, VertexId::new(v), &mut found));
        found
    });
    let mut excess: ValenceExcess = IdVec::filled(0, mesh.wedges.len());
    found.collect::<Vec<_>>().into_iter().flatten().for_each(|(wedge, own)| excess[wedge] = own);
    excess
}

/// The excess in each sector of a vertex.
fn excess_at(mesh: &SimMesh<'_>, vertex: VertexId, found: &mut Vec<(WedgeId, i8)>) {
    let constraint = mesh.constraint[vertex];
    let mut fan = mesh.topology.fan(vertex);
    if constraint == VertexConstraint::Free {
        let Some(first) = fan.next() else { return };
        found.push((mesh.corner_wedge[first], (fan.count() + 1).min(100) as i8 - 6));
        return;
    }
    let mut sectors: Vec<(WedgeId, i8, f32)> = Vec::with_capacity(4);
    for c in fan {
        let wedge = mesh.corner_wedge[c];
        let angle = if constraint == VertexConstraint::Fixed { mesh.angle(c) } else { 0.0 };
        match sectors.iter_mut().find(|s| s.0 == wedge) {
            Some(own) => (own.1, own.2) = (own.1.saturating_add(1).min(100), own.2 + angle),
            None => sectors.push((wedge, 1, angle)),
        }
    }
    let best = |angle: f32| match constraint {
        VertexConstraint::Fixed => (angle / FRAC_PI_3).round().clamp(1.0, 12.0) as i8,
        _ => 3,
    };
    found.extend(sectors.into_iter().map(|(wedge, count, angle)| (wedge, count - best(angle))));
}

impl SimMesh<'_> {
    /// The angle of a corner. \[radians\]
    fn angle(&self, corner: CornerId) -> f32 {
        let [p, q, r] = [corner, next(corner), prev(corner)].map(|c| self.points[self.topology.vertex(c)]);
        (q - p).angle_between(r - p)
    }

    /// The sum over all sectors of the square of their triangles above or below the best number.
    pub fn irregularity(&self) -> i64 {
        let excess = excess(self);
        let wedges: BTreeSet<WedgeId> = self.topology.corners().map(|c| self.corner_wedge[c]).collect();
        wedges.into_iter().map(|wedge| i64::from(excess[wedge]).pow(2)).sum()
    }
}

/// The change of the sum of squares of excesses when an edge of two triangles is turned.
#[inline]
pub(crate) fn change(mesh: &SimMesh<'_>, excess: &ValenceExcess, half: CornerId) -> i32 {
    let Some(twin) = mesh.topology.twin(half) else { return 0 };
    let excess = |x: CornerId| i32::from(excess[mesh.corner_wedge[x]]);
    4 + 2 * (excess(prev(half)) + excess(prev(twin)) - excess(half) - excess(twin))
}

/// What turning an edge gains, in sines.
#[inline]
fn gain(mesh: &SimMesh<'_>, excess: &ValenceExcess, half: CornerId, regularity: f32) -> f32 {
    let Some(twin) = mesh.topology.twin(half) else { return -1.0 };
    // Written out: arrays that are mapped are not kept in registers, and this is asked of every edge.
    let point = |x: CornerId| mesh.points[mesh.topology.vertex(x)];
    let (a, b, c, d) = (point(half), point(twin), point(prev(half)), point(prev(twin)));
    let change = change(mesh, excess, half);
    let square = (a - c).dot(b - c) >= 0.0 && (a - d).dot(b - d) >= 0.0;
    if (change >= 0 || regularity == 0.0) && square {
        return -1.0;
    }
    let ((s1, c1), (s2, c2)) = (opposite_angle(c, a, b), opposite_angle(d, a, b));
    let size = ((s1 * s1 + c1 * c1) * (s2 * s2 + c2 * c2)).sqrt().max(f32::MIN_POSITIVE);
    // The sine of the sum is negative where that exceeds π.
    -(s1 * c2 + c1 * s2) / size - regularity * change as f32
}

/// Sine and cosine of an angle, both times the same positive number.
#[inline]
fn opposite_angle(apex: Vec3, a: Vec3, b: Vec3) -> (f32, f32) {
    let (u, v) = (a - apex, b - apex);
    (u.cross(v).length(), u.dot(v))
}

/// Whether turning an edge makes no edge that is there already, in this patch or another.
pub(crate) fn may_flip(mesh: &SimMesh<'_>, half: CornerId) -> bool {
    let apexes = mesh.topology.twin(half).map(|t| [half, t].map(|h| mesh.topology.vertex(prev(h))));
    apexes.is_some_and(|[c, d]| mesh.may_connect(c, d)) && mesh.topology.may_flip(half)
}

/// Neither new triangle is worse than the worse of the old, or turns further from the surface than those, if it turns
/// far.
pub(crate) fn flip_is_safe(mesh: &SimMesh<'_>, half: CornerId) -> bool {
    let Some(twin) = mesh.topology.twin(half) else { return false };
    let ([a, b, c], d) = (mesh.corners(half), mesh.corner(prev(twin)));
    let new = mesh.defect([c, d, b]).max(mesh.defect([d, c, a]));
    let aligned = || {
        let after = mesh.alignment([c, d, b]).min(mesh.alignment([d, c, a]));
        after >= MIN_ALIGNMENT || after >= mesh.alignment([a, b, c]).min(mesh.alignment([b, a, d]))
    };
    (new == 0 && aligned()) || new < mesh.face_defect(half).max(mesh.face_defect(twin))
}
