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
    use super::exp::exp;
    let mut room = Vec::new();
    flip_edges(mesh, 0.0);
    for round in 0..rounds {
        let last = round + 1 == rounds;
        let t0 = std::time::Instant::now();
        let splits = split_long_edges(mesh, max_faces, if round < exp(21, 0.0) as u32 { exp(20, 1.6) } else { exp(11, 1.25) });
        let t1 = std::time::Instant::now();
        check(mesh);
        let collapses = collapse_short_edges(mesh);
        check(mesh);
        let t2 = std::time::Instant::now();
        let flips = flip_edges(mesh, if last { exp(2, 0.0) } else { exp(1, 0.0) });
        check(mesh);
        let t3 = std::time::Instant::now();
        for _ in 0..if last { exp(6, 1.0) as usize } else { exp(5, 1.0) as usize } { relax_and_project(mesh, if last { exp(4, 1.0) } else { exp(3, 1.0) } as usize, &mut room); }
        check(mesh);
        let t4 = std::time::Instant::now();
        if exp(39, 0.0) > 0.0 { eprintln!("round {round} split {:.1} ({splits}) collapse {:.1} ({collapses}) flip {:.1} ({flips}) relax {:.1}", (t1-t0).as_secs_f64()*1e3, (t2-t1).as_secs_f64()*1e3, (t3-t2).as_secs_f64()*1e3, (t4-t3).as_secs_f64()*1e3); }
        report.rounds += 1;
        report.splits += splits;
        report.collapses += collapses;
        report.flips += flips;
        report.converged = splits + collapses + flips == 0;
        if report.converged {
            break;
        }
    }
    for _ in 0..exp(7, 0.0) as usize { flip_edges(mesh, exp(8, 0.0)); relax_and_project(mesh, exp(4, 1.0) as usize, &mut room); }
    flip_edges(mesh, exp(8, 0.0));
    report
}

/// Every invariant after every pass, in debug builds.
fn check(mesh: &SimMesh<'_>) {
    if cfg!(debug_assertions) {
        mesh.assert_consistent();
    }
}
