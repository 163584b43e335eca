//! Collapse every edge that is too short, the shortest first.

use super::mesh::{Grade, Place, SimMesh};
use super::queue::Queue;
use super::split::SPLIT_RATIO;
use crate::mesh::edit::{next, prev};
use crate::mesh::{CornerId, VertexId};
use glam::Vec3;

/// An edge shorter than this times its target is collapsed (Botsch and Kobbelt 2004, section 4). Larger values make
/// fewer, longer edges.
pub const COLLAPSE_RATIO: f32 = 4.0 / 5.0;

/// Collapses until no edge is too short that may go. Returns the number of collapses.
pub fn collapse_short_edges(mesh: &mut SimMesh<'_>) -> usize {
    let mut queue = Queue::new();
    let halves: Vec<CornerId> = mesh.topology.edges().filter(|&h| wants_collapse(mesh, h)).collect();
    halves.into_iter().for_each(|h| push(&mut queue, mesh, h));
    let mut count = 0;
    while let Some((a, b)) = queue.pop() {
        let Some(half) = mesh.topology.find(a, b).filter(|&h| wants_collapse(mesh, h)) else { continue };
        let Some(kept) = try_collapse(mesh, half) else { continue };
        count += 1;
        let around: Vec<CornerId> = mesh.topology.fan(kept).flat_map(|c| [c, prev(c)]).collect();
        for half in around.into_iter().filter(|&h| wants_collapse(mesh, h)) {
            push(&mut queue, mesh, half);
        }
    }
    count
}

fn wants_collapse(mesh: &SimMesh<'_>, half: CornerId) -> bool {
    mesh.relative_length(half) < COLLAPSE_RATIO
}

fn push(queue: &mut Queue<(VertexId, VertexId)>, mesh: &SimMesh<'_>, half: CornerId) {
    let (a, b) = (mesh.topology.vertex(half), mesh.topology.target(half));
    queue.push(mesh.target_between(a, b) - mesh.length(half), (a.min(b), a.max(b)));
}

/// Collapses an edge if that is allowed and safe; returns the vertex that remains.
fn try_collapse(mesh: &mut SimMesh<'_>, half: CornerId) -> Option<VertexId> {
    let (a, b) = (mesh.topology.vertex(half), mesh.topology.target(half));
    for removed in [a, b] {
        if !may_collapse(mesh, half, removed) {
            continue;
        }
        let kept = if removed == a { b } else { a };
        if let Some((position, place)) = middle(mesh, half, removed, kept) {
            mesh.collapse(half, removed);
            let corners: Vec<CornerId> = mesh.topology.fan(kept).collect();
            corners.into_iter().for_each(|c| mesh.place[c] = place);
            mesh.points[kept] = position;
            mesh.target[kept] = mesh.baseline.target_at(place.location);
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
        Grade::OnCurve(chain) => mesh.span[half].is_some_and(|s| s.chain == chain),
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
    let is_removed = move |c: CornerId| {
        let same = |h: CornerId| c.index() / 3 == h.index() / 3;
        same(half) || mesh.topology.twin(half).is_some_and(same)
    };
    mesh.topology.fan(vertex).filter(move |&c| !is_removed(c))
}

/// Whether edges from a new position to the neighbours of `vertex` stay short enough not to be split again.
fn stays_short(mesh: &SimMesh<'_>, half: CornerId, vertex: VertexId, kept: VertexId, position: Vec3) -> bool {
    staying(mesh, half, vertex)
        .flat_map(|c| [mesh.topology.target(c), mesh.topology.vertex(prev(c))])
        .all(|v| position.distance(mesh.points[v]) <= SPLIT_RATIO * mesh.target_between(kept, v))
}

/// Whether a collapse may make such a triangle.
fn may_be(mesh: &SimMesh<'_>, corners: [(Vec3, Place); 3]) -> bool {
    mesh.badness(corners) == 0 && !mesh.bridges_fold(corners)
}

/// Whether `removed` may take the place of `kept`.
fn is_safe(mesh: &SimMesh<'_>, half: CornerId, removed: VertexId, kept: VertexId) -> bool {
    let position = mesh.points[kept];
    let places = mesh.merged_places(half, removed);
    let place = |c: CornerId| places.iter().find(|(corner, _)| *corner == c).map(|(_, p)| *p);
    stays_short(mesh, half, removed, kept, position)
        && staying(mesh, half, removed).all(|c| {
            place(c).is_some_and(|p| may_be(mesh, [(position, p), mesh.corner(next(c)), mesh.corner(prev(c))]))
        })
}

/// For two free vertices: their middle on the surface, if both may move there.
fn middle(mesh: &SimMesh<'_>, half: CornerId, removed: VertexId, kept: VertexId) -> Option<(Vec3, Place)> {
    if mesh.grade[removed] != Grade::Free || mesh.grade[kept] != Grade::Free {
        return None;
    }
    let point = mesh.points[removed].midpoint(mesh.points[kept]);
    let there = mesh.baseline.closest(mesh.place[half].location.face, point);
    let place = Place { location: there.location, uv: mesh.baseline.uv(there.location) };
    let fits = |v: VertexId| {
        stays_short(mesh, half, v, kept, there.position)
            && staying(mesh, half, v)
                .all(|c| may_be(mesh, [(there.position, place), mesh.corner(next(c)), mesh.corner(prev(c))]))
    };
    (fits(removed) && fits(kept)).then_some((there.position, place))
}
