//! Collapse every edge that is too short, the shortest first.

use super::queue::{QueuedEdge, edit_in_order};
use crate::sim::sim_mesh::{Defect, MIN_COSINE, SimMesh, TriangleCorner, VertexConstraint, Wedge};
use crate::sim::surface::lengths::SPLIT_RATIO;
use glam::Vec3;
use tailor_mesh::connectivity::edit::{face, next, prev};
use tailor_mesh::connectivity::{CornerId, VertexId};

/// An edge shorter than this times its target is collapsed (Botsch and Kobbelt 2004, section 4). Larger values make
/// fewer, longer edges.
pub const COLLAPSE_RATIO: f32 = 4.0 / 5.0;

/// The collapse ratio in the first of several rounds: relaxation makes most slightly short edges long enough. With
/// [`COLLAPSE_RATIO`] the 5th percentile of the smallest angle is 0.1 to 0.4 degrees less.
pub const FIRST_COLLAPSE_RATIO: f32 = 0.7;

/// A collapse makes no edge longer than this times its target. Larger values collapse more short edges, and leave more
/// splits to the next round (4/3 is Botsch and Kobbelt's; the 5/4 of splits leaves three times the short edges).
const LONGEST: f32 = 4.0 / 3.0;

/// Collapses `short` edges and those that follow, until none is shorter than `ratio` times its target that may collapse.
/// Returns the number of collapses.
pub fn collapse_short_edges(mesh: &mut SimMesh<'_>, short: Vec<QueuedEdge>, ratio: f32) -> usize {
    edit_in_order(mesh, short, |mesh, half| length_deficit(mesh, half, ratio), try_collapse)
}

/// The length that an edge which should be collapsed lacks of its target. \[mesh units\]
pub fn length_deficit(mesh: &SimMesh<'_>, half: CornerId, ratio: f32) -> Option<f32> {
    mesh.is_outside(half, ratio, false).then(|| (1.0 - mesh.relative_length(half)) * mesh.target_of(half))
}

/// Collapses an edge if that is allowed and safe; returns the vertex that remains.
fn try_collapse(mesh: &mut SimMesh<'_>, half: CornerId) -> Option<VertexId> {
    let [a, b] = mesh.topology.ends(half);
    // Lengths are checked first: they refuse most, and cost least.
    if let Some((position, wedge)) = middle(mesh, half, a, b).filter(|_| may_collapse(mesh, half, a)) {
        let own = mesh.merged_wedges(half, a)[0];
        mesh.collapse(half, a);
        mesh.wedges[own] = wedge;
        mesh.points[b] = position;
        mesh.target[b] = mesh.baseline.sizing_at(wedge.place.location);
        return Some(b);
    }
    for (removed, kept) in [(a, b), (b, a)] {
        if mesh.constraint[removed] != VertexConstraint::Fixed
            && stays_short(mesh, half, removed, kept, mesh.points[kept])
            && may_collapse(mesh, half, removed)
            && is_safe(mesh, half, removed, kept)
        {
            mesh.collapse(half, removed);
            return Some(kept);
        }
    }
    None
}

/// Whether the constraints let `removed` go: it is free, or it slides along its chain into its neighbour there.
fn may_collapse(mesh: &SimMesh<'_>, half: CornerId, removed: VertexId) -> bool {
    let is_allowed = match mesh.constraint[removed] {
        VertexConstraint::Free => true,
        VertexConstraint::OnCurve(chain) => mesh.span(half).is_some_and(|s| s.chain == chain),
        VertexConstraint::Fixed => false,
    };
    // Two constrained edges of a removed triangle would become one.
    let joins_chains = |c: CornerId| mesh.is_constrained(next(c)) && mesh.is_constrained(prev(c));
    is_allowed
        && !joins_chains(half)
        && !mesh.topology.twin(half).is_some_and(joins_chains)
        && mesh.topology.may_collapse(half)
        && mesh.may_merge(half, removed)
}

/// The corners around `vertex` in triangles that stay.
fn staying<'a>(mesh: &'a SimMesh<'_>, half: CornerId, vertex: VertexId) -> impl Iterator<Item = CornerId> + 'a {
    let (own, other) = (face(half), mesh.topology.twin(half).map(face));
    mesh.topology.fan(vertex).filter(move |&c| face(c) != own && Some(face(c)) != other)
}

/// Whether edges from a new position to the neighbours of `vertex` stay short enough not to be split again.
fn stays_short(mesh: &SimMesh<'_>, half: CornerId, vertex: VertexId, kept: VertexId, position: Vec3) -> bool {
    let [a, b] = mesh.topology.ends(half);
    mesh.topology.ring(vertex).filter(|&v| v != a && v != b).all(|v| {
        let most = LONGEST * mesh.target_between(kept, v);
        let length = position.distance_squared(mesh.points[v]);
        // One that is too long already may stay as long as it is.
        length <= most * most || length <= mesh.points[vertex].distance_squared(mesh.points[v])
    })
}

/// Whether the chain's edge beyond a removed vertex stays short enough when it takes over this one's part of the curve.
fn chain_stays_short(mesh: &SimMesh<'_>, half: CornerId, removed: VertexId) -> bool {
    !mesh.is_constrained(half)
        || mesh.curve_neighbours(removed).is_none_or(|near| near.after.count() + near.before.count() <= SPLIT_RATIO)
}

/// Whether a collapse may make such a triangle from that of `old`, the corner that moves: it has no defect and bridges no
/// sharp edge, or is better than before.
fn may_become(mesh: &SimMesh<'_>, moved: TriangleCorner<'_>, old: CornerId) -> bool {
    let corners = [moved, mesh.corner(next(old)), mesh.corner(prev(old))];
    let defect = mesh.defect(corners);
    if defect > Defect::Good && defect > mesh.face_defect(old) {
        return false;
    }
    let alignment = mesh.alignment(corners);
    alignment > MIN_COSINE || alignment >= mesh.alignment(mesh.corners(old))
}

/// Whether `removed` may move to `kept`.
fn is_safe(mesh: &SimMesh<'_>, half: CornerId, removed: VertexId, kept: VertexId) -> bool {
    let position = mesh.points[kept];
    let [left, right] = mesh.merged_wedges(half, removed).map(|w| &mesh.wedges[w]);
    let sector = mesh.left_sector(half, removed);
    let wedge = |c: CornerId| if sector.is_empty() || sector.contains(&c) { left } else { right };
    chain_stays_short(mesh, half, removed)
        && staying(mesh, half, removed).all(|c| may_become(mesh, (position, wedge(c)), c))
}

/// For two free vertices: their midpoint on the surface, if both may move there.
fn middle(mesh: &SimMesh<'_>, half: CornerId, removed: VertexId, kept: VertexId) -> Option<(Vec3, Wedge)> {
    if [removed, kept].iter().any(|&v| mesh.constraint[v] != VertexConstraint::Free) {
        return None;
    }
    let point = mesh.points[removed].midpoint(mesh.points[kept]);
    if ![removed, kept].iter().all(|&v| stays_short(mesh, half, v, kept, point)) {
        return None;
    }
    let there = mesh.baseline.closest(mesh.place(half).location.face, point);
    let wedge = mesh.wedge_at(there.location);
    let fits = |&v: &VertexId| staying(mesh, half, v).all(|c| may_become(mesh, (there.position, &wedge), c));
    [removed, kept].iter().all(fits).then_some((there.position, wedge))
}
