//! The rounds of split, collapse, flip, relax and project.
//!
//! Source: Botsch and Kobbelt, *A Remeshing Approach to Multiresolution Modeling* (SGP 2004), section 4; Waggoner and
//! de Goes, *Revamping the Cloth Tailoring Pipeline at Pixar* (SIGGRAPH Talks 2022).

use super::collapse::collapse_short_edges;
use super::flip::flip_edges;
use super::mesh::SimMesh;
use super::relax::relax_and_project;
use super::split::split_long_edges;
use serde::Serialize;

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
}

/// Brings the edges of `mesh` to their targets in at most `rounds` rounds, and never above `max_faces` triangles.
pub fn remesh(mesh: &mut SimMesh<'_>, rounds: u32, max_faces: usize) -> RemeshReport {
    let mut report = RemeshReport::default();
    flip_edges(mesh);
    for _ in 0..rounds {
        let splits = split_long_edges(mesh, max_faces);
        check(mesh);
        let collapses = collapse_short_edges(mesh);
        check(mesh);
        let flips = flip_edges(mesh);
        check(mesh);
        relax_and_project(mesh, 1);
        check(mesh);
        report.rounds += 1;
        report.splits += splits;
        report.collapses += collapses;
        report.flips += flips;
        report.converged = splits + collapses + flips == 0;
        if report.converged {
            break;
        }
    }
    flip_edges(mesh);
    report
}

/// Every invariant after every pass, in debug builds.
fn check(mesh: &SimMesh<'_>) {
    if cfg!(debug_assertions) {
        mesh.assert_consistent();
    }
}
