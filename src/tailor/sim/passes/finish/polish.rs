//! Polish: vertices of thin triangles move to where the angles around them are better.
//!
//! Relaxation leaves a vertex at the centroid, also where nearby chains allow no good angles there. A search for the best
//! position costs little, as few vertices need one.
//!
//! Source: Freitag and Ollivier-Gooch, *Tetrahedral Mesh Improvement Using Swapping and Smoothing* (IJNME 1997), section
//! 3: averages everywhere, a search where the worst angles ask for it.

use crate::sim::geometry::smallest_angle_cosine;
use crate::sim::sim_mesh::{Defect, Destination, MIN_COSINE, SimMesh, VertexConstraint};
use glam::Vec3;
use rayon::prelude::*;
use std::f32::consts::TAU;
use tailor_mesh::connectivity::edit::{face, prev};
use tailor_mesh::connectivity::{CornerId, FaceId, VertexId};

/// The cosine of 33 degrees: a triangle with a smaller angle is thin, and its vertices search. A smaller angle saves time; a
/// larger one raises the 5th percentile of angles.
pub const THIN_COSINE: f32 = 0.838_67;
/// The cosine of 31 degrees, below which an angle costs in full.
const BAD_COSINE: f32 = 0.857_17;
/// The cosine of 44 degrees, below which an angle costs by [`POOR_WEIGHT`].
const POOR_COSINE: f32 = 0.719_34;
/// Without it the triangles around a thin one pay for it: the 5th percentile falls by 0.2 degrees. Larger values leave
/// more thin ones: 0.6 a tenth more, on shoes01 half as many again.
const POOR_WEIGHT: f32 = 0.35;
/// Rounds of searches, each where something moved; more find next to nothing.
const ROUNDS: usize = 3;
/// Directions in which a free vertex searches.
const DIRECTIONS: usize = 8;
/// The first step of its search, as a share of the target length; each later one is half of the one before.
const FIRST_STEP: f32 = 0.16;
/// Steps of its search.
const STEPS: usize = 4;
/// Range of a chain vertex's search in each direction, as a share of its shorter edge there. A quarter leaves a tenth more
/// thin triangles beside chains.
const REACH: f32 = 0.4;
/// Positions that it tries in each direction.
const TRIALS: i8 = 4;

/// The angles around a vertex.
#[derive(Clone, Copy)]
pub struct FanAngles {
    /// The sum of all triangles' costs.
    pub cost: f32,
    /// The cosine of the smallest angle.
    pub worst: f32,
}

impl FanAngles {
    /// Whether the cost is less than `before`, and no thin triangle gets thinner.
    fn is_better(self, before: Self) -> bool {
        self.cost < before.cost && self.worst <= before.worst.max(THIN_COSINE)
    }
}

/// Moves vertices of thin triangles, in the order of their ids, so that the result is the same for any number of threads.
pub(super) fn open_thin_triangles(mesh: &mut SimMesh<'_>) {
    let mut waiting = thin_vertices(mesh);
    for _ in 0..ROUNDS {
        waiting.retain(|&v| improve(mesh, v));
        waiting = with_rings(mesh, &waiting);
        waiting.retain(|&v| fan_angles(mesh, v, mesh.points[v]).worst > THIN_COSINE);
    }
    mesh.debug_check();
}

/// Vertices that moved and those around them: all others would find the same again.
pub(super) fn with_rings(mesh: &SimMesh<'_>, moved: &[VertexId]) -> Vec<VertexId> {
    let mut near: Vec<VertexId> =
        moved.iter().flat_map(|&v| mesh.topology.ring(v)).chain(moved.iter().copied()).collect();
    near.sort_unstable();
    near.dedup();
    near
}

/// The vertices of thin triangles that may move.
fn thin_vertices(mesh: &SimMesh<'_>) -> Vec<VertexId> {
    let faces = (0..mesh.topology.face_slots()).into_par_iter().map(FaceId::new);
    let is_thin = |&f: &FaceId| {
        let is_alive = mesh.topology.is_alive(CornerId::new(3 * f.index()));
        is_alive && smallest_angle_cosine(mesh.topology.triangle(f).map(|v| mesh.points[v])) > THIN_COSINE
    };
    let thin: Vec<FaceId> = faces.filter(is_thin).collect();
    let vertices = thin.into_iter().flat_map(|f| mesh.topology.triangle(f));
    let mut vertices: Vec<VertexId> = vertices.filter(|&v| mesh.constraint[v] != VertexConstraint::Fixed).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

/// The angles of all triangles around a vertex, if it lay at `own`.
pub(super) fn fan_angles(mesh: &SimMesh<'_>, vertex: VertexId, own: Vec3) -> FanAngles {
    let at = |v: VertexId| mesh.points[v];
    mesh.topology.fan(vertex).fold(FanAngles { cost: 0.0, worst: 0.0 }, |sum, c| {
        let cosine = smallest_angle_cosine([own, at(mesh.topology.target(c)), at(mesh.topology.vertex(prev(c)))]);
        let cost = (cosine - BAD_COSINE).max(0.0) + POOR_WEIGHT * (cosine - POOR_COSINE).max(0.0);
        FanAngles { cost: sum.cost + cost, worst: sum.worst.max(cosine) }
    })
}

/// Moves a vertex to the best position that a search around it finds. Returns whether it moved.
fn improve(mesh: &mut SimMesh<'_>, vertex: VertexId) -> bool {
    let before = fan_angles(mesh, vertex, mesh.points[vertex]);
    let goal = match mesh.constraint[vertex] {
        VertexConstraint::Free => search_plane(mesh, vertex, before),
        VertexConstraint::OnCurve(_) => search_curve(mesh, vertex, before),
        VertexConstraint::Fixed => None,
    };
    let is_better = |mesh: &SimMesh<'_>| fan_angles(mesh, vertex, mesh.points[vertex]).is_better(before);
    goal.is_some_and(|goal| try_move(mesh, vertex, goal, is_better))
}

/// Moves a vertex if the result is wanted, makes no triangle worse and reverses no edge of a chain. Returns whether it moved.
pub(super) fn try_move(
    mesh: &mut SimMesh<'_>,
    vertex: VertexId,
    goal: Destination,
    is_wanted: impl Fn(&SimMesh<'_>) -> bool,
) -> bool {
    let Some(mut there) = mesh.find_move(vertex, goal, 1.0) else { return false };
    let quality = |mesh: &SimMesh<'_>, c| (mesh.face_defect(c), mesh.alignment(mesh.corners(c)));
    let old: Vec<(CornerId, (Defect, f32))> = mesh.topology.fan(vertex).map(|c| (c, quality(mesh, c))).collect();
    mesh.swap(&mut there);
    let is_good = |&(c, (defect, alignment)): &(CornerId, (Defect, f32))| {
        let now = quality(mesh, c);
        let mut corners = tailor_mesh::connectivity::edit::corners(face(c));
        // The bound of flips instead leaves three times the thin triangles where turns are tight.
        now.0 <= defect && (now.1 >= MIN_COSINE || now.1 >= alignment) && !corners.any(|c| mesh.is_reversed(c))
    };
    let moves = is_wanted(mesh) && old.iter().all(is_good);
    if !moves {
        mesh.swap(&mut there);
    }
    moves
}

/// The best position for a free vertex, in the plane of its triangles.
fn search_plane(mesh: &SimMesh<'_>, vertex: VertexId, before: FanAngles) -> Option<Destination> {
    let start = mesh.points[vertex];
    let at = |v: VertexId| mesh.points[v] - start;
    let area = |c: CornerId| at(mesh.topology.target(c)).cross(at(mesh.topology.vertex(prev(c))));
    let normal = mesh.topology.fan(vertex).map(area).sum::<Vec3>().try_normalize()?;
    let (x, y) = normal.any_orthonormal_pair();
    let (mut best, mut least) = (start, before);
    let mut step = FIRST_STEP * mesh.target[vertex];
    for _ in 0..STEPS {
        let from = best;
        for k in 0..DIRECTIONS {
            let (sin, cos) = (k as f32 * TAU / DIRECTIONS as f32).sin_cos();
            let to = from + step * (cos * x + sin * y);
            let there = fan_angles(mesh, vertex, to);
            if there.is_better(least) {
                (best, least) = (to, there);
            }
        }
        step *= 0.5;
    }
    (best != start).then_some(Destination::Near(best))
}

/// The best position for a chain's vertex on its curve, whatever its bends: vertices follow those afterwards, as far as that
/// makes no thin triangle.
fn search_curve(mesh: &SimMesh<'_>, vertex: VertexId, before: FanAngles) -> Option<Destination> {
    let near = mesh.curve_neighbours(vertex)?;
    let [behind, ahead] = near.lengths();
    let reach = REACH * ahead.min(behind);
    let (mut best, mut least) = (0.0, before);
    for k in (-TRIALS..=TRIALS).filter(|&k| k != 0) {
        let by = reach * f32::from(k) / f32::from(TRIALS);
        let there = fan_angles(mesh, vertex, mesh.on_curve(near.after.chain, near.arc_length() + by));
        if there.is_better(least) {
            (best, least) = (by, there);
        }
    }
    (best != 0.0).then_some(Destination::Along(best))
}
