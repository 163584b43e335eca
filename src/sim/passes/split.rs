//! Split every edge that is too long, the longest first.

use crate::mesh::CornerId;
use crate::mesh::edit::prev;
use crate::sim::passes::polish::smallest_angle_cosine;
use crate::sim::passes::queue::{QueuedEdge, edit_in_order, keyed};
use crate::sim::sim_mesh::{CurveSpan, SimMesh};
use glam::Vec3;
use rayon::prelude::*;

/// An edge longer than this times its target is split. Smaller values make more, shorter edges. Botsch and Kobbelt 2004,
/// section 4, have 4/3, from which halves are nearer to the target than the whole; 5/4 makes better triangles: on the
/// garments it raises the 5th percentile of the smallest angle by 0.7 degrees, with 1 % more triangles.
pub const SPLIT_RATIO: f32 = 1.25;

/// The same in the first of several rounds. The halves of an edge only just longer than [`SPLIT_RATIO`] are so short that
/// collapses undo the split: on male_worksuit01 a round of that makes 29 000 edits, one of this 16 000, and a tenth of all
/// time is saved. At 1.5 as many edits are left to the second round.
pub(crate) const FIRST_SPLIT_RATIO: f32 = 1.4;

/// An edge of a chain that leaves its curve by more than this share of the target length is split at the end. Smaller
/// values make more short edges, which cost angles; without it the chord between two anchors cuts up to 0.13 off. At 0.1
/// 3.5 % of the curves of shoes01, the soles', are more than 0.02 off; at 0.08, 2.6 %.
pub(crate) const FAR: f32 = 0.08;
/// The same where the triangles beside it stay open: 0.5 to 1 % more of the curves within 0.02 on the garments with least.
const OFF: f32 = 0.03;
/// The least angle of those triangles, 28 degrees; its cosine. Some of them open further when they are relaxed. A smaller
/// angle splits more: at 26 degrees the lengths of edges are 0.5 % less even.
const OPEN: f32 = 0.882_95;
/// Places on a curve at which its distance from the edge is asked.
const PLACES: u8 = 8;

/// Splits until no edge is longer than `ratio` times its target or the mesh has `max_faces` triangles. Returns the number
/// of splits.
pub fn split_long_edges(mesh: &mut SimMesh<'_>, ratio: f32, max_faces: usize) -> usize {
    let long = keyed(mesh, |mesh, half| excess(mesh, half, ratio));
    split_edges(mesh, long, ratio, max_faces)
}

/// The same where the edges to begin with are known.
pub(crate) fn split_edges(mesh: &mut SimMesh<'_>, long: Vec<QueuedEdge>, ratio: f32, max_faces: usize) -> usize {
    let mut faces = mesh.topology.face_count();
    let key = |mesh: &SimMesh<'_>, half: CornerId| excess(mesh, half, ratio);
    edit_in_order(mesh, long, key, |mesh, half| {
        if faces >= max_faces || !mesh.topology.may_split(half) || mesh.is_patch_border(half) {
            return None;
        }
        let vertex = mesh.split(half)?;
        faces += 1 + usize::from(mesh.topology.twin(half).is_some());
        Some(vertex)
    })
}

/// The excess over the target, as in Waggoner and de Goes 2022, of an edge that is to be split.
pub(crate) fn excess(mesh: &SimMesh<'_>, half: CornerId, ratio: f32) -> Option<f32> {
    if !mesh.is_outside(half, ratio, true) {
        return None;
    }
    let (a, b) = (mesh.topology.vertex(half), mesh.topology.target(half));
    Some((mesh.relative_length(half) - 1.0) * mesh.target_between(a, b))
}

/// Splits edges of chains that leave their curves, by more than [`FAR`] however short they are, where no triangle is worse
/// for it. Returns the number of splits.
pub fn split_far_edges(mesh: &mut SimMesh<'_>, max_faces: usize) -> usize {
    let corners = (0..mesh.topology.corner_slots()).into_par_iter().map(CornerId::new);
    let far: Vec<CornerId> = corners.filter(|&h| mesh.topology.is_edge(h) && is_far(mesh, h)).collect();
    let mut faces = mesh.topology.face_count();
    let mut count = 0;
    for half in far {
        let more = 1 + usize::from(mesh.topology.twin(half).is_some());
        // A split before may have made another edge of it.
        let is_safe = is_far(mesh, half) && mesh.span(half).is_some_and(|span| mesh.span_split_is_safe(half, span));
        if is_safe && faces + more <= max_faces && mesh.topology.may_split(half) && mesh.split(half).is_some() {
            faces += more;
            count += 1;
        }
    }
    count
}

fn is_far(mesh: &SimMesh<'_>, half: CornerId) -> bool {
    let Some(span) = mesh.span(half).map(CurveSpan::along) else { return false };
    let ends = [mesh.topology.vertex(half), mesh.topology.target(half)].map(|v| mesh.points[v]);
    let target = mesh.baseline.target_at(mesh.place(half).location);
    let places = (1..PLACES).map(|k| span.from + (span.to - span.from) * f32::from(k) / f32::from(PLACES));
    let off = mesh.off_chord(mesh.chain(span.chain), span.from, places, ends).fold(0.0, f32::max);
    off > FAR * target || (off > OFF * target && halves_are_open(mesh, half, span, ends))
}

/// Whether the triangles beside a constrained edge would have no small angle if that were split.
fn halves_are_open(mesh: &SimMesh<'_>, half: CornerId, span: CurveSpan, ends: [Vec3; 2]) -> bool {
    let middle = mesh.on_curve(span.chain, mesh.middle_of_span(span));
    let apexes = [Some(half), mesh.topology.twin(half)].into_iter().flatten().map(|h| mesh.topology.vertex(prev(h)));
    apexes
        .map(|v| mesh.points[v])
        .all(|apex| ends.iter().all(|&end| smallest_angle_cosine([end, middle, apex]) <= OPEN))
}
