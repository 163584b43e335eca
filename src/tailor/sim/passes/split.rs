//! Split every edge that is too long, the longest first.

use super::queue::{QueuedEdge, edges, edit_in_order};
use crate::sim::geometry::smallest_angle_cosine;
use crate::sim::sim_mesh::{CurveSpan, SimMesh};
use glam::Vec3;
use rayon::prelude::*;
use tailor_mesh::connectivity::CornerId;
use tailor_mesh::connectivity::edit::prev;

/// The split ratio in the first of several rounds. At `SPLIT_RATIO` the halves
/// of an edge only just too long are so short that collapses undo the split: on male_worksuit01 such a round takes 29 000
/// edits, this one 16 000, which saves a tenth of all time. 1.5 leaves as many edits to the second round.
pub const FIRST_SPLIT_RATIO: f32 = 1.4;

/// An edge of a chain farther than this share of the target length from its curve is split at the end. Smaller values make
/// more short edges, which cost angles; without it the chord between two anchors cuts off up to 0.13. At 0.1, 3.5 % of the
/// curves of shoes01 (the soles) are more than 0.02 away; at 0.08, 2.6 %.
pub const FAR: f32 = 0.08;
/// The share if the triangles beside the edge keep their angles. It brings 0.5 to 1 % more of the curves within 0.02 on the
/// garments with fewest there.
const FAR_WITH_GOOD_ANGLES: f32 = 0.03;
/// The cosine of the least angle of such triangles, 28 degrees. Relaxation opens some of them further. A smaller angle
/// splits more: at 26 degrees edge lengths are 0.5 % less even.
const GOOD_ANGLE_COSINE: f32 = 0.882_95;
/// Samples of the distance between a curve and its chord.
const SAMPLES: u8 = 8;

/// Splits `long` edges and those that follow, until none is longer than `ratio` times its target or there is
/// no room for more in `max_faces` triangles. Returns the number of splits.
pub fn split_long_edges(mesh: &mut SimMesh<'_>, long: Vec<QueuedEdge>, ratio: f32, max_faces: usize) -> usize {
    let mut faces = mesh.topology.face_count();
    let key = |mesh: &SimMesh<'_>, half: CornerId| length_excess(mesh, half, ratio);
    edit_in_order(mesh, long, key, |mesh, half| {
        let more = 1 + usize::from(mesh.topology.twin(half).is_some());
        if faces + more > max_faces || !mesh.topology.may_split(half) || mesh.is_patch_border(half) {
            return None;
        }
        let vertex = mesh.split(half)?;
        faces += more;
        Some(vertex)
    })
}

/// The length over its target of an edge that should be split (Waggoner and de Goes 2022). \[mesh units\]
pub fn length_excess(mesh: &SimMesh<'_>, half: CornerId, ratio: f32) -> Option<f32> {
    mesh.is_outside(half, ratio, true).then(|| (mesh.relative_length(half) - 1.0) * mesh.target_of(half))
}

/// Splits edges of chains that are far from their curves, however short they are, if that makes no triangle worse. Returns
/// the number of splits.
pub fn split_far_edges(mesh: &mut SimMesh<'_>, max_faces: usize) -> usize {
    let far: Vec<CornerId> = edges(mesh).filter(|&h| is_far(mesh, h)).collect();
    let mut faces = mesh.topology.face_count();
    let mut count = 0;
    for half in far {
        let more = 1 + usize::from(mesh.topology.twin(half).is_some());
        // An earlier split may have shortened it.
        let is_safe = is_far(mesh, half) && mesh.span(half).is_some_and(|span| mesh.span_split_is_safe(half, span));
        if is_safe && faces + more <= max_faces && mesh.topology.may_split(half) && mesh.split(half).is_some() {
            faces += more;
            count += 1;
        }
    }
    mesh.debug_check();
    count
}

fn is_far(mesh: &SimMesh<'_>, half: CornerId) -> bool {
    let Some(span) = mesh.span(half).map(CurveSpan::along) else { return false };
    let ends = mesh.end_points(half);
    let target = mesh.baseline.target_at(mesh.place(half).location);
    let samples = (1..SAMPLES).map(|k| span.from + (span.to - span.from) * f32::from(k) / f32::from(SAMPLES));
    let distance = mesh.chord_distances(mesh.chain(span.chain), span.from, samples, ends).fold(0.0, f32::max);
    distance > FAR * target || (distance > FAR_WITH_GOOD_ANGLES * target && halves_are_good(mesh, half, span, ends))
}

/// Whether the triangles beside a constrained edge keep good angles if it is split.
fn halves_are_good(mesh: &SimMesh<'_>, half: CornerId, span: CurveSpan, ends: [Vec3; 2]) -> bool {
    let middle = mesh.on_curve(span.chain, mesh.middle_of_span(span));
    let apexes = [Some(half), mesh.topology.twin(half)].into_iter().flatten().map(|h| mesh.topology.vertex(prev(h)));
    let mut triangles = apexes.flat_map(|v| ends.map(|end| [end, middle, mesh.points[v]]));
    triangles.all(|triangle| smallest_angle_cosine(triangle) <= GOOD_ANGLE_COSINE)
}
