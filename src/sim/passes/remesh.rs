//! The rounds of split, collapse, flip, relax and project.
//!
//! Source: Botsch and Kobbelt, *A Remeshing Approach to Multiresolution Modeling* (SGP 2004), section 4; Waggoner and
//! de Goes, *Revamping the Cloth Tailoring Pipeline at Pixar* (SIGGRAPH Talks 2022).

use crate::mesh::{CornerId, VertexId};
use crate::sim::passes::collapse::{COLLAPSE_RATIO, FIRST_COLLAPSE_RATIO, collapse_edges, collapse_short_edges, lack};
use crate::sim::passes::flip::{flip_and_drift, flip_edges};
use crate::sim::passes::follow::follow_curves;
use crate::sim::passes::polish::open_thin_triangles;
use crate::sim::passes::queue::{keyed_around, keyed_by_both};
use crate::sim::passes::relax::relax_and_project;
use crate::sim::passes::split::{
    FIRST_SPLIT_RATIO, SPLIT_RATIO, excess, split_edges, split_far_edges, split_long_edges,
};
use crate::sim::sim_mesh::SimMesh;
use crate::sim::sim_mesh::patches::{PATCH, in_patches};
use serde::Serialize;
use std::ops::RangeInclusive;

/// What a square of excess neighbours weighs in a flip while rounds go on. Larger values make more vertices of valence 6
/// and, above this, worse angles; 0.2 makes better angles on some garments and worse ones on others.
const REGULARITY: f32 = 0.3;
/// The same for the last flips: nearly Delaunay.
const LAST_REGULARITY: f32 = 0.1;
/// Rounds in which irregular vertices drift together: the first ones after that in patches, so that later ones relax what
/// they leave. Only the second round: 3 % fewer regular vertices; the last one too: 3 % more, and 0.2 degrees less in the
/// 5th percentile of the smallest angle; also the fourth: 1 to 2 % more, for 4 % of the time.
const DRIFT: RangeInclusive<u32> = 2..=3;
/// Averages between two projections. More make the triangles of a round more even; past three a round gains little.
const SWEEPS: usize = 3;
/// The same for the last relaxation, whose triangles stay; a fifth adds 0.02 degrees to their angles.
const LAST_SWEEPS: usize = 4;

/// Above which length edges are split, and below which they are collapsed, as shares of their targets.
const RATIOS: [f32; 2] = [SPLIT_RATIO, COLLAPSE_RATIO];
/// The same in the first of several rounds.
const FIRST_RATIOS: [f32; 2] = [FIRST_SPLIT_RATIO, FIRST_COLLAPSE_RATIO];

/// What remeshing did.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct RemeshReport {
    /// Rounds done.
    pub rounds: u32,
    /// Whether the last round neither split, collapsed nor flipped anything.
    pub converged: bool,
    /// Edges split in all rounds.
    pub splits: usize,
    /// Edges collapsed in all rounds.
    pub collapses: usize,
    /// Edges flipped in all rounds.
    pub flips: usize,
    /// Chains along folds that are sharper than the target length can follow.
    pub ridges: usize,
    /// Corners of chains that were kept as vertices.
    pub corners: usize,
    /// Vertices of the surface whose target length grading shortened.
    pub graded: usize,
}

/// A pass over a whole mesh as a round does it, for tests and benches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// Split long edges.
    Split,
    /// Collapse short edges.
    Collapse,
    /// Turn edges.
    Flip,
    /// Turn edges, also such that only bring irregular vertices together.
    Drift,
    /// Relax and project.
    Relax,
    /// Slide vertices of chains to where edges follow the curves.
    Follow,
    /// Split and collapse inside patches of about so many triangles, as a first round does.
    InPatches(usize),
}

impl Pass {
    /// The passes of a round, in their order.
    pub const ROUND: [Self; 4] = [Self::Split, Self::Collapse, Self::Drift, Self::Relax];

    /// Does the pass; returns the number of edges that it changed, or of vertices that follow their curves better.
    pub fn run(self, mesh: &mut SimMesh<'_>) -> usize {
        match self {
            Self::Split => split_long_edges(mesh, SPLIT_RATIO, usize::MAX),
            Self::Collapse => collapse_short_edges(mesh, COLLAPSE_RATIO),
            Self::Flip => flip_edges(mesh, REGULARITY),
            Self::Drift => flip_and_drift(mesh, REGULARITY),
            Self::Relax => {
                relax_and_project(mesh, SWEEPS, &mut Vec::new());
                0
            }
            Self::Follow => follow_curves(mesh),
            Self::InPatches(size) => edit_in_patches(mesh, size, usize::MAX).map_or(0, |(a, b)| a + b),
        }
    }
}

/// Brings the edges of `mesh` to their targets in at most `rounds` rounds, and never above `max_faces` triangles.
pub fn remesh(mesh: &mut SimMesh<'_>, rounds: u32, max_faces: usize) -> RemeshReport {
    let chains = &mesh.baseline.chains;
    let ridges = chains.iter().filter(|c| c.kind.ridge).count();
    let corners = chains.iter().map(|c| c.pins.len()).sum();
    let mut report = RemeshReport { ridges, corners, graded: mesh.baseline.graded, ..RemeshReport::default() };
    let mut room = Vec::new();
    for round in 1..=rounds {
        let in_patches = if round == 1 && rounds > 1 { edit_in_patches(mesh, PATCH, max_faces) } else { None };
        let (splits, collapses) = in_patches.unwrap_or_else(|| edit(mesh, RATIOS, max_faces));
        check(mesh);
        if round == rounds {
            report.splits += split_far_edges(mesh, max_faces);
        }
        let flips = if DRIFT.contains(&round) { flip_and_drift } else { flip_edges }(mesh, REGULARITY);
        check(mesh);
        // The last round's is the one after it. Without a second one there the 5th percentile of the smallest angle is 0.1
        // degrees less, for a twentieth of the time.
        if round == 1 || round < rounds {
            relax_and_project(mesh, SWEEPS, &mut room);
        }
        check(mesh);
        report.rounds = round;
        report.splits += splits;
        report.collapses += collapses;
        report.flips += flips;
        // Patches leave what lies along their borders to the next round.
        report.converged = in_patches.is_none() && splits + collapses + flips == 0;
        if report.converged {
            break;
        }
    }
    if rounds > 0 {
        relax_and_project(mesh, LAST_SWEEPS, &mut room);
        // Where a triangle was in the way, it may have moved.
        report.splits += split_far_edges(mesh, max_faces);
    }
    flip_edges(mesh, LAST_REGULARITY);
    if rounds > 0 {
        open_thin_triangles(mesh);
        follow_curves(mesh);
    }
    check(mesh);
    report
}

/// Splits and collapses; returns the numbers of edits.
fn edit(mesh: &mut SimMesh<'_>, [longest, shortest]: [f32; 2], max_faces: usize) -> (usize, usize) {
    let lack = |mesh: &SimMesh<'_>, half: CornerId| lack(mesh, half, shortest);
    let [long, mut short] = keyed_by_both(mesh, |mesh, half| excess(mesh, half, longest), lack);
    let old = mesh.topology.vertex_slots();
    let splits = split_edges(mesh, long, longest, max_faces);
    check(mesh);
    let new = (old..mesh.topology.vertex_slots()).map(VertexId::new);
    short.extend(keyed_around(mesh, new, &lack));
    (splits, collapse_edges(mesh, short, shortest))
}

/// The same inside patches of about `size` triangles, Delaunay first. None where the mesh does not fall into patches.
fn edit_in_patches(mesh: &mut SimMesh<'_>, size: usize, max_faces: usize) -> Option<(usize, usize)> {
    let faces = mesh.topology.face_count();
    let room = max_faces.saturating_sub(faces) as f64 / faces.max(1) as f64;
    let done = in_patches(mesh, size, |patch| {
        let own = patch.topology.face_count();
        flip_edges(patch, 0.0);
        check(patch);
        let edits = edit(patch, FIRST_RATIOS, own.saturating_add((room * own as f64) as usize));
        check(patch);
        edits
    })?;
    Some(done.into_iter().fold((0, 0), |sum, one| (sum.0 + one.0, sum.1 + one.1)))
}

/// Every invariant after every pass, in debug builds.
fn check(mesh: &SimMesh<'_>) {
    if cfg!(debug_assertions) {
        mesh.assert_consistent();
    }
}
