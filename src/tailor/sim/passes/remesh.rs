//! The schedule of remeshing: rounds of split, collapse, flip, relax and project.
//!
//! Source: Botsch and Kobbelt, *A Remeshing Approach to Multiresolution Modeling* (SGP 2004), section 4; Waggoner and
//! de Goes, *Revamping the Cloth Tailoring Pipeline at Pixar* (SIGGRAPH Talks 2022).

use super::collapse::{COLLAPSE_RATIO, FIRST_COLLAPSE_RATIO, collapse_short_edges, length_deficit};
use super::finish::{finish, turn_to_surface};
use super::flip::{flip_and_drift, flip_edges};
use super::queue::{keyed_around, keyed_by_both};
use super::relax::relax_and_project;
use super::split::{FIRST_SPLIT_RATIO, length_excess, split_far_edges, split_long_edges};
use crate::sim::baseline::Baseline;
use crate::sim::options::{Relaxation, SimOptions};
use crate::sim::sim_mesh::{PATCH_SIZE, SimMesh, in_patches};
use crate::sim::surface::lengths::SPLIT_RATIO;
use serde::Serialize;
use std::ops::RangeInclusive;
use tailor_mesh::connectivity::{CornerId, VertexId};

/// Weight of a squared valence excess in flips of all rounds. Larger values make more vertices of valence 6 and worse angles;
/// 0.2 makes better angles on some garments and worse ones on others.
const REGULARITY: f32 = 0.3;
/// The weight in the last flips: nearly Delaunay.
pub const LAST_REGULARITY: f32 = 0.1;
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
    /// Feature lines: chains along edges that are sharper than the target length can follow.
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

    fn add(&mut self, edits: impl IntoIterator<Item = Edits>) {
        self.full = false;
        for edits in edits {
            self.splits += edits.splits;
            self.collapses += edits.collapses;
            self.full |= edits.full;
        }
    }

    /// Edges changed so far.
    fn edits(&self) -> usize {
        self.splits + self.collapses + self.flips
    }
}

/// Brings the edges of `mesh` to their targets in at most `iterations` rounds, and never above `max_faces` triangles.
pub fn remesh(mesh: &mut SimMesh<'_>, options: &SimOptions, max_faces: usize) -> RemeshReport {
    let mut report = RemeshReport::new(mesh.baseline);
    let rounds = options.iterations;
    let context = PassContext { relaxation: options.relax, max_faces };
    for round in 1..=rounds {
        let before = report.edits();
        for pass in passes(round, rounds) {
            pass.run(mesh, &context, &mut report);
        }
        report.rounds = round;
        // Patches leave edges along their borders to the next round.
        report.converged = report.edits() == before && (round > 1 || rounds == 1);
        if report.converged {
            break;
        }
    }
    for pass in if rounds > 0 { LAST } else { &[LAST_FLIP] } {
        pass.run(mesh, &context, &mut report);
    }
    report
}

/// The passes of a round.
fn passes(round: u32, rounds: u32) -> impl Iterator<Item = Pass> {
    let is_last = round == rounds;
    let edits: &[Pass] =
        if round == 1 && !is_last { &[Pass::InPatches(PATCH_SIZE)] } else { &[Pass::SplitAndCollapse] };
    let flips = if DRIFT.contains(&round) { Pass::Drift } else { Pass::Flip(REGULARITY) };
    // The last round's relaxation is the one after it. A second one there would add 0.1 degrees to the 5th percentile
    // of the smallest angle, for a twentieth of the time.
    let relax = (round == 1 || !is_last).then_some(Pass::Relax(SWEEPS));
    edits.iter().copied().chain(is_last.then_some(Pass::SplitFar)).chain([flips]).chain(relax)
}

/// The passes after the rounds. Relaxation may have moved a triangle that was in the way of a split, and the finish moves vertices
/// of edges that were good before. Turns come last: a flip does not see that a triangle faces away.
const LAST: &[Pass] = &[Pass::Relax(LAST_SWEEPS), Pass::SplitFar, LAST_FLIP, Pass::Finish, LAST_FLIP, Pass::Turn];
/// The only pass where no round is asked for.
const LAST_FLIP: Pass = Pass::Flip(LAST_REGULARITY);

/// A pass over a whole mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pass {
    /// Splits and collapses inside patches of about so many triangles, which leaves the edges along their borders.
    InPatches(usize),
    /// Splits long edges, then collapses short ones.
    SplitAndCollapse,
    /// Splits edges of chains that are far from their curves.
    SplitFar,
    /// Flips edges towards the Delaunay condition, and by this weight towards valence 6.
    Flip(f32),
    /// Flips edges, and lets irregular vertices drift together.
    Drift,
    /// Relaxes by so many averages, and projects.
    Relax(usize),
    /// Moves vertices of thin triangles, and those of chains towards their curves.
    Finish,
    /// Flips edges and moves vertices where triangles face away in tight turns.
    Turn,
}

/// The options that passes read.
pub struct PassContext {
    pub relaxation: Relaxation,
    pub max_faces: usize,
}

impl Pass {
    /// Makes the pass, and counts what it edits.
    pub fn run(self, mesh: &mut SimMesh<'_>, context: &PassContext, report: &mut RemeshReport) {
        match self {
            Self::InPatches(size) => report.add(edit_in_patches(mesh, size, context.max_faces)),
            Self::SplitAndCollapse => report.add([split_and_collapse(mesh, RATIOS, context.max_faces)]),
            Self::SplitFar => report.splits += split_far_edges(mesh, context.max_faces),
            Self::Flip(regularity) => report.flips += flip_edges(mesh, regularity),
            Self::Drift => report.flips += flip_and_drift(mesh, REGULARITY),
            Self::Relax(sweeps) => relax_and_project(mesh, sweeps, context.relaxation),
            Self::Finish => finish(mesh),
            Self::Turn => turn_to_surface(mesh),
        }
    }
}

/// Counts of splits and collapses.
struct Edits {
    splits: usize,
    collapses: usize,
    /// Whether there was no room for the two triangles of one more split.
    full: bool,
}

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

/// Splits and collapses inside patches of about `size` triangles, Delaunay first; over the whole mesh where the patches cannot
/// be joined or exceed `max_faces`.
fn edit_in_patches(mesh: &mut SimMesh<'_>, size: usize, max_faces: usize) -> Vec<Edits> {
    // Collapses follow, so that splits alone may make more.
    let most = max_faces.saturating_mul(2);
    let edits = in_patches(mesh, size, max_faces, |patch| {
        flip_edges(patch, 0.0);
        split_and_collapse(patch, FIRST_RATIOS, most)
    });
    edits.unwrap_or_else(|| vec![split_and_collapse(mesh, RATIOS, max_faces)])
}
