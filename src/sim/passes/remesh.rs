//! The rounds of split, collapse, flip, relax and project.
//!
//! Source: Botsch and Kobbelt, *A Remeshing Approach to Multiresolution Modeling* (SGP 2004), section 4; Waggoner and
//! de Goes, *Revamping the Cloth Tailoring Pipeline at Pixar* (SIGGRAPH Talks 2022).

use super::collapse::{COLLAPSE_RATIO, FIRST_COLLAPSE_RATIO, collapse_short_edges, length_deficit};
use super::finish::finish;
use super::flip::{flip_and_drift, flip_edges};
use super::queue::{keyed_around, keyed_by_both};
use super::relax::relax_and_project;
use super::split::{FIRST_SPLIT_RATIO, length_excess, split_far_edges, split_long_edges};
use crate::mesh::{CornerId, VertexId};
use crate::sim::baseline::Baseline;
use crate::sim::sim_mesh::{PATCH_SIZE, SimMesh, in_patches};
use crate::sim::surface::lengths::SPLIT_RATIO;
use serde::Serialize;
use std::ops::RangeInclusive;

/// Weight of a squared valence excess in flips of all rounds. Larger values make more vertices of valence 6 and worse angles;
/// 0.2 makes better angles on some garments and worse ones on others.
const REGULARITY: f32 = 0.3;
/// The weight in the last flips: nearly Delaunay.
const LAST_REGULARITY: f32 = 0.1;
/// Rounds with drift: the first ones after the round in patches, so that later ones relax the result. The second alone leaves
/// 3 % fewer regular vertices; the last one too, 3 % more, and 0.2 degrees less in the 5th percentile of the smallest angle;
/// the fourth too, 1 to 2 % more, for 4 % of the time.
const DRIFT: RangeInclusive<u32> = 2..=3;
/// Averages between two projections. More make the triangles of a round more even; past three a round gains little.
const SWEEPS: usize = 3;
/// Averages of the last relaxation, whose triangles stay; a fifth adds 0.02 degrees to their angles.
const LAST_SWEEPS: usize = 4;

/// Ratios to the target above which edges are split and below which they are collapsed.
const RATIOS: [f32; 2] = [SPLIT_RATIO, COLLAPSE_RATIO];
/// The ratios in the first of several rounds.
const FIRST_RATIOS: [f32; 2] = [FIRST_SPLIT_RATIO, FIRST_COLLAPSE_RATIO];

/// Rounds and edits of remeshing.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct RemeshReport {
    /// Rounds done.
    pub rounds: u32,
    /// Whether the last round neither split, collapsed nor flipped anything.
    pub converged: bool,
    /// Whether the last round had no room for more splits in the largest number of triangles.
    pub full: bool,
    /// Edges split in all rounds.
    pub splits: usize,
    /// Edges collapsed in all rounds.
    pub collapses: usize,
    /// Edges flipped in all rounds.
    pub flips: usize,
    /// Chains along folds that are sharper than the target length can follow.
    pub feature_lines: usize,
    /// Corners of chains that were kept as vertices.
    pub corners: usize,
    /// UV shells too small for triangles of the target length, whose borders are not constraints.
    pub small_shells: usize,
    /// Vertices of the surface whose target length grading shortened.
    pub graded: usize,
}

impl RemeshReport {
    /// The report before the first round.
    fn new(baseline: &Baseline) -> Self {
        let feature_lines = baseline.chains.iter().filter(|c| c.kind.feature).count();
        let corners = baseline.chains.iter().map(|c| c.pins.len()).sum();
        let small_shells = baseline.small_shells.count();
        Self { feature_lines, corners, small_shells, graded: baseline.graded, ..Self::default() }
    }
}

/// A pass over a whole mesh as a round makes it, for tests and benches.
#[cfg(feature = "internals")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// Split long edges.
    Split,
    /// Collapse short edges.
    Collapse,
    /// Flip edges.
    Flip,
    /// Flip edges, and let irregular vertices drift together.
    Drift,
    /// Relax and project.
    Relax,
    /// Slide vertices of chains to where edges follow the curves.
    Follow,
    /// Split and collapse inside patches of about so many triangles, as a first round does.
    InPatches(usize),
}

#[cfg(feature = "internals")]
impl Pass {
    /// The passes of a round, in their order.
    pub const ROUND: [Self; 4] = [Self::Split, Self::Collapse, Self::Drift, Self::Relax];

    /// Makes the pass; returns the number of edges that it changed, or of vertices that follow their curves better.
    pub fn run(self, mesh: &mut SimMesh<'_>) -> usize {
        match self {
            Self::Split => {
                let (long, _) = keyed_by_both(mesh, |mesh, half| length_excess(mesh, half, SPLIT_RATIO), |_, _| None);
                split_long_edges(mesh, long, SPLIT_RATIO, usize::MAX)
            }
            Self::Collapse => {
                let deficit = |mesh: &SimMesh<'_>, half| length_deficit(mesh, half, COLLAPSE_RATIO);
                let (short, _) = keyed_by_both(mesh, deficit, |_, _| None);
                collapse_short_edges(mesh, short, COLLAPSE_RATIO)
            }
            Self::Flip => flip_edges(mesh, REGULARITY),
            Self::Drift => flip_and_drift(mesh, REGULARITY),
            Self::Relax => {
                relax_and_project(mesh, SWEEPS, &mut Vec::new());
                0
            }
            Self::Follow => super::finish::follow_curves(mesh),
            Self::InPatches(size) => {
                edit_in_patches(mesh, size, usize::MAX).map_or(0, |edits| edits.splits + edits.collapses)
            }
        }
    }
}

/// Brings the edges of `mesh` to their targets in at most `rounds` rounds, and never above `max_faces` triangles.
pub fn remesh(mesh: &mut SimMesh<'_>, rounds: u32, max_faces: usize) -> RemeshReport {
    let mut report = RemeshReport::new(mesh.baseline);
    let mut scratch = Vec::new();
    for round in 1..=rounds {
        let in_patches = if round == 1 && rounds > 1 { edit_in_patches(mesh, PATCH_SIZE, max_faces) } else { None };
        let Edits { splits, collapses, full } =
            in_patches.unwrap_or_else(|| split_and_collapse(mesh, RATIOS, max_faces));
        if round == rounds {
            report.splits += split_far_edges(mesh, max_faces);
        }
        let flips = if DRIFT.contains(&round) { flip_and_drift } else { flip_edges }(mesh, REGULARITY);
        // The last round's relaxation is the one after it. A second one there would add 0.1 degrees to the 5th percentile
        // of the smallest angle, for a twentieth of the time.
        if round == 1 || round < rounds {
            relax_and_project(mesh, SWEEPS, &mut scratch);
        }
        report.rounds = round;
        report.full = full;
        report.splits += splits;
        report.collapses += collapses;
        report.flips += flips;
        // Patches leave edges along their borders to the next round.
        report.converged = in_patches.is_none() && splits + collapses + flips == 0;
        if report.converged {
            break;
        }
    }
    if rounds > 0 {
        relax_and_project(mesh, LAST_SWEEPS, &mut scratch);
        // Relaxation may have moved a triangle that was in the way.
        report.splits += split_far_edges(mesh, max_faces);
    }
    flip_edges(mesh, LAST_REGULARITY);
    if rounds > 0 {
        finish(mesh);
    }
    report
}

/// What one round of splits and collapses did.
#[derive(Clone, Copy, Default)]
struct Edits {
    splits: usize,
    collapses: usize,
    /// Whether there was no room for the two triangles of one more split.
    full: bool,
}

/// Splits and collapses.
fn split_and_collapse(mesh: &mut SimMesh<'_>, [longest, shortest]: [f32; 2], max_faces: usize) -> Edits {
    let deficit = |mesh: &SimMesh<'_>, half: CornerId| length_deficit(mesh, half, shortest);
    let (long, mut short) = keyed_by_both(mesh, |mesh, half| length_excess(mesh, half, longest), deficit);
    let (old, wants_room) = (mesh.topology.vertex_slots(), !long.is_empty());
    let splits = split_long_edges(mesh, long, longest, max_faces);
    let full = wants_room && mesh.topology.face_count() + 2 > max_faces;
    let new = (old..mesh.topology.vertex_slots()).map(VertexId::new);
    short.extend(keyed_around(mesh, new, &deficit));
    Edits { splits, collapses: collapse_short_edges(mesh, short, shortest), full }
}

/// Splits and collapses inside patches of about `size` triangles, Delaunay first. None, with the mesh unchanged, if the patches
/// cannot be joined or exceed `max_faces`.
fn edit_in_patches(mesh: &mut SimMesh<'_>, size: usize, max_faces: usize) -> Option<Edits> {
    // Collapses follow, so that splits alone may make more.
    let most = max_faces.saturating_mul(2);
    let edits = in_patches(mesh, size, max_faces, |patch| {
        flip_edges(patch, 0.0);
        split_and_collapse(patch, FIRST_RATIOS, most)
    })?;
    let add = |sum: Edits, one: Edits| Edits {
        splits: sum.splits + one.splits,
        collapses: sum.collapses + one.collapses,
        full: sum.full || one.full,
    };
    Some(edits.into_iter().fold(Edits::default(), add))
}
