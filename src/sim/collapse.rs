//! Collapse every edge that is too short, the shortest first.

use super::mesh::{Grade, SimMesh, Site};
use super::queue::EdgeQueue;
use super::shape::Corner;
use super::split::SPLIT_RATIO;
use crate::mesh::edit::{face, next, prev};
use crate::mesh::{CornerId, VertexId};
use glam::Vec3;

/// An edge shorter than this times its target is collapsed (Botsch and Kobbelt 2004, section 4). Larger values make
/// fewer, longer edges.
pub const COLLAPSE_RATIO: f32 = 4.0 / 5.0;

/// Collapses until no edge is too short that may go. Returns the number of collapses.
pub fn collapse_short_edges(mesh: &mut SimMesh<'_>) -> usize {
    let mut queue = EdgeQueue::of(mesh, lack);
    let mut count = 0;
    while let Some(half) = queue.pop(mesh) {
        if lack(mesh, half).is_none() {
            continue;
        }
        let Some(kept) = try_collapse(mesh, half) else { continue };
        count += 1;
        for half in mesh.topology.fan(kept).flat_map(|c| [c, prev(c)]) {
            queue.push(mesh, half, lack(mesh, half));
        }
    }
    count
}

/// What an edge that is to be collapsed lacks of its target.
fn lack(mesh: &SimMesh<'_>, half: CornerId) -> Option<f32> {
    let relative = mesh.relative_length(half);
    let (a, b) = (mesh.topology.vertex(half), mesh.topology.target(half));
    (relative < COLLAPSE_RATIO).then(|| (1.0 - relative) * mesh.target_between(a, b))
}

/// Collapses an edge if that is allowed and safe; returns the vertex that remains.
fn try_collapse(mesh: &mut SimMesh<'_>, half: CornerId) -> Option<VertexId> {
    let (a, b) = (mesh.topology.vertex(half), mesh.topology.target(half));
    for (removed, kept) in [(a, b), (b, a)] {
        if !may_collapse(mesh, half, removed) {
            continue;
        }
        if let Some((position, site)) = middle(mesh, half, removed, kept) {
            let own = mesh.merged_sites(half, removed)[0];
            mesh.collapse(half, removed);
            mesh.sites[own] = site;
            mesh.points[kept] = position;
            mesh.target[kept] = mesh.baseline.target_at(site.place.location);
            return Some(kept);
        }
        if is_safe(mesh, half, removed, kept) {
            mesh.collapse(half, removed);
            return Some(kept);
        }
    }
    None
}

/// Whether the constraints let `removed` go: it is free, or it slides along its chain into its neighbour there.
fn may_collapse(mesh: &SimMesh<'_>, half: CornerId, removed: VertexId) -> bool {
    let allowed = match mesh.grade[removed] {
        Grade::Free => true,
        Grade::OnCurve(chain) => mesh.span(half).is_some_and(|s| s.chain == chain),
        Grade::Frozen => false,
    };
    // Two constrained edges of a removed triangle would become one.
    let joins_chains = |c: CornerId| mesh.is_constrained(next(c)) && mesh.is_constrained(prev(c));
    allowed
        && !joins_chains(half)
        && !mesh.topology.twin(half).is_some_and(joins_chains)
        && mesh.topology.may_collapse(half)
}

/// The corners around `vertex` in triangles that stay.
fn staying<'a>(mesh: &'a SimMesh<'_>, half: CornerId, vertex: VertexId) -> impl Iterator<Item = CornerId> + 'a {
    let (own, other) = (face(half), mesh.topology.twin(half).map(face));
    mesh.topology.fan(vertex).filter(move |&c| face(c) != own && Some(face(c)) != other)
}

/// Whether edges from a new position to the neighbours of `vertex` stay short enough not to be split again.
fn stays_short(mesh: &SimMesh<'_>, half: CornerId, vertex: VertexId, kept: VertexId, position: Vec3) -> bool {
    staying(mesh, half, vertex).flat_map(|c| [mesh.topology.target(c), mesh.topology.vertex(prev(c))]).all(|v| {
        let most = SPLIT_RATIO * mesh.target_between(kept, v);
        position.distance_squared(mesh.points[v]) <= most * most
    })
}

/// Whether the chain's edge beyond a removed vertex stays short enough when it takes over the part of this one.
fn chain_stays_short(mesh: &SimMesh<'_>, half: CornerId, removed: VertexId) -> bool {
    let Some(span) = mesh.span(half) else { return true };
    let Some([ahead, back]) = mesh.chain_neighbours(removed) else { return true };
    let parts = [ahead, back].map(|h| mesh.span(h).map_or(0.0, |s| mesh.count(s)));
    debug_assert!(span.from <= span.to || !span.forward, "spans run along their chains");
    parts[0] + parts[1] <= SPLIT_RATIO
}

/// Whether a collapse may make such a triangle.
fn may_be(mesh: &SimMesh<'_>, corners: [Corner<'_>; 3]) -> bool {
    mesh.badness(corners) == 0 && !mesh.bridges_fold(corners)
}

/// Whether `removed` may take the place of `kept`.
fn is_safe(mesh: &SimMesh<'_>, half: CornerId, removed: VertexId, kept: VertexId) -> bool {
    let position = mesh.points[kept];
    let [left, right] = mesh.merged_sites(half, removed).map(|s| &mesh.sites[s]);
    let mut sector = Vec::new();
    mesh.left_sector(half, removed, &mut sector);
    let site = |c: CornerId| if sector.is_empty() || sector.contains(&c) { left } else { right };
    stays_short(mesh, half, removed, kept, position)
        && chain_stays_short(mesh, half, removed)
        && staying(mesh, half, removed)
            .all(|c| may_be(mesh, [(position, site(c)), mesh.corner(next(c)), mesh.corner(prev(c))]))
}

/// For two free vertices: their middle on the surface, if both may move there.
fn middle(mesh: &SimMesh<'_>, half: CornerId, removed: VertexId, kept: VertexId) -> Option<(Vec3, Site)> {
    if mesh.grade[removed] != Grade::Free || mesh.grade[kept] != Grade::Free {
        return None;
    }
    let point = mesh.points[removed].midpoint(mesh.points[kept]);
    let there = mesh.baseline.closest(mesh.place(half).location.face, point);
    let site = mesh.site_on(there.location);
    let fits = |v: VertexId| {
        stays_short(mesh, half, v, kept, there.position)
            && staying(mesh, half, v)
                .all(|c| may_be(mesh, [(there.position, &site), mesh.corner(next(c)), mesh.corner(prev(c))]))
    };
    (fits(removed) && fits(kept)).then_some((there.position, site))
}
