//! Relax: every free vertex moves to the weighted middle of its neighbours and back to the surface; vertices on a chain
//! slide along its curve; anchors stay.

use super::mesh::{Grade, Place, SimMesh, Span};
use crate::mesh::edit::prev;
use crate::mesh::{CornerId, VertexId};
use glam::Vec3;
use rayon::prelude::*;

/// Shares of the way that vertices try to move, in turn: where moves would fold triangles, all try again and shorter.
const STEPS: [f32; 3] = [1.0, 0.5, 0.25];

/// Where a vertex wants to go.
#[derive(Clone, Copy)]
enum Move {
    To { position: Vec3, place: Place },
    Slide { arriving: CornerId, leaving: CornerId, by: f32 },
}

/// Moves every vertex once. Returns the number of vertices that moved.
pub fn relax_and_project(mesh: &mut SimMesh<'_>) -> usize {
    let vertices: Vec<VertexId> = mesh.topology.vertices().collect();
    let mut count = 0;
    for step in STEPS {
        let moves: Vec<Option<Move>> = vertices.par_iter().map(|&v| wanted(mesh, v, step)).collect();
        let mut refused = 0;
        for (&vertex, wanted) in vertices.iter().zip(moves) {
            match wanted.map(|m| apply(mesh, vertex, m)) {
                Some(true) => count += 1,
                Some(false) => refused += 1,
                None => {}
            }
        }
        // A few refusals do not pay for another pass over all vertices.
        if refused == 0 || step == STEPS[0] && refused * 100 < vertices.len() {
            break;
        }
    }
    count
}

fn wanted(mesh: &SimMesh<'_>, vertex: VertexId, step: f32) -> Option<Move> {
    match mesh.grade[vertex] {
        Grade::Frozen => None,
        Grade::OnCurve(_) => slide(mesh, vertex, step),
        Grade::Free => free_move(mesh, vertex, step),
    }
}

/// To the middle of the surrounding triangles, each weighted by its area against its target, then to the surface.
fn free_move(mesh: &SimMesh<'_>, vertex: VertexId, step: f32) -> Option<Move> {
    let own = mesh.points[vertex];
    let (mut sum, mut weight, mut normal) = (Vec3::ZERO, 0.0f32, Vec3::ZERO);
    for corner in mesh.topology.fan(vertex) {
        let (a, b) = (mesh.topology.target(corner), mesh.topology.vertex(prev(corner)));
        let cross = (mesh.points[a] - own).cross(mesh.points[b] - own);
        let target = (mesh.target[vertex] + mesh.target[a] + mesh.target[b]) / 3.0;
        let w = cross.length() / (target * target);
        sum += w * (own + mesh.points[a] + mesh.points[b]) / 3.0;
        weight += w;
        normal += cross;
    }
    if weight <= 0.0 {
        return None;
    }
    let shift = sum / weight - own;
    let normal = normal.normalize_or_zero();
    let tangential = shift - normal * normal.dot(shift);
    let start = mesh.topology.fan(vertex).next().map(|c| mesh.place[c].location.face)?;
    let there = mesh.baseline.closest(start, own + step * tangential);
    let place = Place { location: there.location, uv: mesh.baseline.uv(there.location) };
    Some(Move::To { position: there.position, place })
}

/// The constrained half-edges that arrive at and leave a vertex, along the chain or against it.
fn chain_edges(mesh: &SimMesh<'_>, vertex: VertexId) -> Option<(CornerId, CornerId)> {
    let mut found = mesh.topology.fan(vertex).flat_map(|c| [c, prev(c)]).filter(|&c| mesh.is_constrained(c));
    let first = found.next()?;
    let twin = mesh.topology.twin(first);
    let second = found.find(|&c| c != first && Some(c) != twin)?;
    let arrives = |c: CornerId| {
        let span = mesh.span[c];
        (mesh.topology.target(c) == vertex) == span.is_some_and(|s| s.forward)
    };
    Some(if arrives(first) { (first, second) } else { (second, first) })
}

/// The span of a constrained edge in the chain's own direction.
fn along(mesh: &SimMesh<'_>, half: CornerId) -> Option<Span> {
    mesh.span[half].map(|s| if s.forward { s } else { s.reversed() })
}

/// To where both parts of the curve have the same length in terms of their targets.
fn slide(mesh: &SimMesh<'_>, vertex: VertexId, step: f32) -> Option<Move> {
    let (arriving, leaving) = chain_edges(mesh, vertex)?;
    let (before, after) = (along(mesh, arriving)?, along(mesh, leaving)?);
    let far = |half: CornerId| {
        let v = mesh.topology.vertex(half);
        if v == vertex { mesh.topology.target(half) } else { v }
    };
    let (l, r) = (mesh.target_between(far(arriving), vertex), mesh.target_between(vertex, far(leaving)));
    let (d, e) = (before.to - before.from, after.to - after.from);
    let by = step * ((d + e) * l / (l + r) - d);
    Some(Move::Slide { arriving, leaving, by })
}

fn apply(mesh: &mut SimMesh<'_>, vertex: VertexId, wanted: Move) -> bool {
    match wanted {
        Move::To { position, place } => {
            if !mesh.may_move(vertex, position, |_| place) {
                return false;
            }
            let corners: Vec<CornerId> = mesh.topology.fan(vertex).collect();
            corners.into_iter().for_each(|c| mesh.place[c] = place);
            mesh.points[vertex] = position;
            mesh.target[vertex] = mesh.baseline.target_at(place.location);
            true
        }
        Move::Slide { arriving, leaving, by } => apply_slide(mesh, vertex, arriving, leaving, by),
    }
}

fn apply_slide(mesh: &mut SimMesh<'_>, vertex: VertexId, arriving: CornerId, leaving: CornerId, by: f32) -> bool {
    let (Some(before), Some(after)) = (along(mesh, arriving), along(mesh, leaving)) else { return false };
    let (before, after) = (Span { to: before.to + by, ..before }, Span { from: after.from + by, ..after });
    if !(before.from < before.to && after.from < after.to) {
        return false;
    }
    let (position, left) = mesh.on_curve(before.chain, before.to, true);
    let (_, right) = mesh.on_curve(before.chain, before.to, false);
    let sides = mesh.sides(vertex, leaving);
    let place = |c: CornerId| {
        let is_left = sides.iter().find(|(corner, _)| *corner == c).is_none_or(|(_, l)| *l);
        let (own, other) = if is_left { (left, right) } else { (right, left) };
        own.or(other).unwrap_or(mesh.place[c])
    };
    if !mesh.may_move(vertex, position, place) {
        return false;
    }
    let places: Vec<(CornerId, Place)> = sides.iter().map(|&(c, _)| (c, place(c))).collect();
    for (half, span) in [(arriving, before), (leaving, after)] {
        let forward = mesh.span[half].is_some_and(|s| s.forward);
        mesh.set_span(half, if forward { span } else { span.reversed() });
    }
    for (corner, place) in places {
        mesh.place[corner] = place;
    }
    mesh.points[vertex] = position;
    if let Some(corner) = mesh.topology.fan(vertex).next() {
        mesh.target[vertex] = mesh.baseline.target_at(mesh.place[corner].location);
    }
    true
}
