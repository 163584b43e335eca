//! Thin triangles are opened: their vertices move to where the angles around them are better.
//!
//! Averages leave a vertex in the middle, also where the chains near it leave no room for good angles there. A search
//! for the best place costs little, as few vertices need one.
//!
//! Source: Freitag and Ollivier-Gooch, *Tetrahedral Mesh Improvement Using Swapping and Smoothing* (IJNME 1997), section
//! 3: averages everywhere, a search where the worst angles ask for it.

use crate::mesh::edit::{face, prev};
use crate::mesh::{CornerId, FaceId, VertexId};
use crate::sim::passes::collapse::MIN_COSINE;
use crate::sim::passes::relax::{Destination, swap, wanted};
use crate::sim::sim_mesh::{SimMesh, VertexConstraint};
use glam::Vec3;
use rayon::prelude::*;
use std::f32::consts::TAU;

/// Vertices of triangles with a smaller angle than 33 degrees search; its cosine. A smaller angle saves time; a larger
/// one raises the 5th percentile of angles.
const SEARCHED: f32 = 0.838_67;
/// Below 31 degrees (its cosine) an angle counts in full.
const THIN: f32 = 0.857_17;
/// Below 44 degrees (its cosine) an angle counts by [`POOR_WEIGHT`].
const POOR: f32 = 0.719_34;
/// Without it the triangles around a thin one pay for it: the 5th percentile falls by 0.2 degrees. Larger values leave
/// more thin ones: 0.6 a tenth more, on shoes01 half as many again.
const POOR_WEIGHT: f32 = 0.35;
/// Searches, later ones where something moved; more find next to nothing.
const ROUNDS: usize = 3;
/// Directions in which a free vertex looks for a better place.
const DIRECTIONS: usize = 8;
/// The first step of its search, as a share of the target length; each later one is half of the one before.
const FIRST_STEP: f32 = 0.16;
/// Steps of its search.
const STEPS: usize = 4;
/// How far a chain's vertex looks both ways, as a share of the shorter of its edges there. A quarter leaves a tenth more
/// thin triangles beside chains.
const REACH: f32 = 0.4;
/// Places that it looks at, each way.
const PLACES: i8 = 4;

/// How bad the angles around a vertex are.
#[derive(Clone, Copy)]
pub(crate) struct FanAngles {
    /// What all triangles lack together.
    pub lack: f32,
    /// The largest cosine of a smallest angle.
    pub worst: f32,
}

impl FanAngles {
    /// Whether less is lacking than `before`, and the smallest angle is none the smaller, or is not thin.
    fn is_better(self, before: Self) -> bool {
        self.lack < before.lack && self.worst <= before.worst.max(SEARCHED)
    }
}

/// Moves vertices of thin triangles. One after the other in the order of their numbers, so the result is the same for any
/// number of threads.
pub(crate) fn open_thin_triangles(mesh: &mut SimMesh<'_>) {
    let mut waiting = thin_vertices(mesh);
    for _ in 0..ROUNDS {
        waiting.retain(|&v| improve(mesh, v));
        waiting = with_rings(mesh, &waiting);
        waiting.retain(|&v| angles(mesh, v, mesh.points[v]).worst > SEARCHED);
    }
}

/// Some vertices and those around them: where these did not move, a search finds nothing that it did not find before.
pub(crate) fn with_rings(mesh: &SimMesh<'_>, moved: &[VertexId]) -> Vec<VertexId> {
    let mut near: Vec<VertexId> =
        moved.iter().flat_map(|&v| mesh.topology.ring(v)).chain(moved.iter().copied()).collect();
    near.sort_unstable();
    near.dedup();
    near
}

/// The vertices of thin triangles that may move.
fn thin_vertices(mesh: &SimMesh<'_>) -> Vec<VertexId> {
    let faces = (0..mesh.topology.corner_slots() / 3).into_par_iter().map(FaceId::new);
    let is_thin = |&f: &FaceId| {
        let is_alive = mesh.topology.is_alive(CornerId::new(3 * f.index()));
        is_alive && smallest_angle_cosine(mesh.topology.triangle(f).map(|v| mesh.points[v])) > SEARCHED
    };
    let thin: Vec<FaceId> = faces.filter(is_thin).collect();
    let vertices = thin.into_iter().flat_map(|f| mesh.topology.triangle(f));
    let mut vertices: Vec<VertexId> = vertices.filter(|&v| mesh.constraint[v] != VertexConstraint::Fixed).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

/// The cosine of a triangle's smallest angle, which is opposite its shortest side.
#[inline]
pub(crate) fn smallest_angle_cosine([a, b, c]: [Vec3; 3]) -> f32 {
    let (x, y, z) = (b.distance_squared(c), c.distance_squared(a), a.distance_squared(b));
    let (least, most, middle) = (x.min(y).min(z), x.max(y).max(z), x.max(y).min(x.min(y).max(z)));
    (most + middle - least) / (2.0 * (most * middle).sqrt()).max(f32::MIN_POSITIVE)
}

/// The angles of all triangles around a vertex, if it lay at `own`.
pub(crate) fn angles(mesh: &SimMesh<'_>, vertex: VertexId, own: Vec3) -> FanAngles {
    let at = |v: VertexId| mesh.points[v];
    mesh.topology.fan(vertex).fold(FanAngles { lack: 0.0, worst: 0.0 }, |sum, c| {
        let smallest_angle_cosine =
            smallest_angle_cosine([own, at(mesh.topology.target(c)), at(mesh.topology.vertex(prev(c)))]);
        let lack = (smallest_angle_cosine - THIN).max(0.0) + POOR_WEIGHT * (smallest_angle_cosine - POOR).max(0.0);
        FanAngles { lack: sum.lack + lack, worst: sum.worst.max(smallest_angle_cosine) }
    })
}

/// Moves a vertex to the best place that a search around it finds. Returns whether it moved.
fn improve(mesh: &mut SimMesh<'_>, vertex: VertexId) -> bool {
    let before = angles(mesh, vertex, mesh.points[vertex]);
    let goal = match mesh.constraint[vertex] {
        VertexConstraint::Free => free_goal(mesh, vertex, before),
        VertexConstraint::OnCurve(_) => slide_goal(mesh, vertex, before),
        VertexConstraint::Fixed => None,
    };
    let is_better = |mesh: &SimMesh<'_>| angles(mesh, vertex, mesh.points[vertex]).is_better(before);
    goal.is_some_and(|goal| try_move(mesh, vertex, goal, is_better))
}

/// Moves a vertex if the result is wanted, and no triangle lies worse, nor an edge against its chain. Returns whether it
/// moved.
pub(crate) fn try_move(
    mesh: &mut SimMesh<'_>,
    vertex: VertexId,
    goal: Destination,
    is_wanted: impl Fn(&SimMesh<'_>) -> bool,
) -> bool {
    let Some(mut there) = wanted(mesh, vertex, goal, 1.0) else { return false };
    let lies = |mesh: &SimMesh<'_>, c| (mesh.face_defect(c), mesh.alignment(mesh.corners(c)));
    let old: Vec<(CornerId, (u8, f32))> = mesh.topology.fan(vertex).map(|c| (c, lies(mesh, c))).collect();
    swap(mesh, &mut there);
    let is_good = |&(c, (defect, alignment)): &(CornerId, (u8, f32))| {
        let now = lies(mesh, c);
        // The bound of collapses: that of flips leaves three times the thin triangles where folds are tight.
        now.0 <= defect && (now.1 >= MIN_COSINE || now.1 >= alignment) && !passes(mesh, c)
    };
    let moves = is_wanted(mesh) && old.iter().all(is_good);
    if !moves {
        swap(mesh, &mut there);
    }
    moves
}

/// Whether an edge of a corner's triangle runs against its chain.
fn passes(mesh: &SimMesh<'_>, corner: CornerId) -> bool {
    let first = 3 * face(corner).index();
    let marks = (first..first + 3).filter_map(|c| mesh.mark[CornerId::new(c)]);
    marks.into_iter().any(|m| mesh.spans[m.span()].is_reversed())
}

/// The best place for a free vertex, in the plane of its triangles.
fn free_goal(mesh: &SimMesh<'_>, vertex: VertexId, before: FanAngles) -> Option<Destination> {
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
            let there = angles(mesh, vertex, to);
            if there.is_better(least) {
                (best, least) = (to, there);
            }
        }
        step *= 0.5;
    }
    (best != start).then_some(Destination::Point(best))
}

/// The best place for a chain's vertex on its curve. Bends do not hold it: it follows them afterwards, as far as that makes
/// no thin triangle.
fn slide_goal(mesh: &SimMesh<'_>, vertex: VertexId, before: FanAngles) -> Option<Destination> {
    let [ahead, back] = mesh.chain_neighbours(vertex)?;
    let (after, last) = (mesh.span(ahead)?.along(), mesh.span(back)?.along());
    let reach = REACH * (after.to - after.from).min(last.to - last.from);
    let (mut best, mut least) = (0.0, before);
    for k in (-PLACES..=PLACES).filter(|&k| k != 0) {
        let by = reach * f32::from(k) / f32::from(PLACES);
        let there = angles(mesh, vertex, mesh.on_curve(after.chain, last.to + by));
        if there.is_better(least) {
            (best, least) = (by, there);
        }
    }
    (best != 0.0).then_some(Destination::Along(best))
}
