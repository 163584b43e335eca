//! Relax: every free vertex moves to the weighted middle of its neighbours and back to the surface; vertices on a chain
//! slide along its curve; anchors stay.

use super::mesh::{Grade, SimMesh, Site};
use crate::mesh::edit::{face, next, prev};
use crate::mesh::{CornerId, FaceId, IdVec, SiteId, VertexId};
use glam::Vec3;
use rayon::prelude::*;

/// Shares of the way that vertices try to move, in turn: where moves would fold triangles, they try again and shorter.
const STEPS: [f32; 3] = [1.0, 0.5, 0.25];

/// Where a vertex wants to go.
#[derive(Clone, Copy)]
enum Goal {
    Point(Vec3),
    /// Arc length on the chain.
    Curve(f32),
}

/// A move, as it is done.
struct Move {
    vertex: VertexId,
    position: Vec3,
    target: f32,
    sites: [Option<(SiteId, Site)>; 2],
    slide: Option<Slide>,
}

/// The half-edges along the chain and against it, and the new arc length.
#[derive(Clone, Copy)]
struct Slide {
    ahead: CornerId,
    back: CornerId,
    by: f32,
}

/// Moves every vertex once, `sweeps` times averaged before it goes back to the surface.
pub fn relax_and_project(mesh: &mut SimMesh<'_>, sweeps: usize) {
    let vertices: Vec<VertexId> = mesh.topology.vertices().collect();
    let goals = goals(mesh, &vertices, sweeps);
    let mut waiting: Vec<(VertexId, Goal)> =
        vertices.iter().zip(goals).filter_map(|(&v, goal)| Some((v, goal?))).collect();
    for step in STEPS {
        waiting = attempt(mesh, &waiting, step);
        if waiting.is_empty() {
            break;
        }
    }
}

/// Where vertices want to go.
fn goals(mesh: &SimMesh<'_>, vertices: &[VertexId], sweeps: usize) -> Vec<Option<Goal>> {
    let mut points = mesh.points.clone();
    for _ in 0..sweeps {
        let next: Vec<Option<Vec3>> = vertices.par_iter().map(|&v| middle(mesh, &points, v)).collect();
        vertices.iter().zip(next).for_each(|(&v, p)| points[v] = p.unwrap_or(points[v]));
    }
    let goal = |&v: &VertexId| match mesh.grade[v] {
        Grade::Frozen => None,
        Grade::OnCurve(_) => even(mesh, v).map(Goal::Curve),
        Grade::Free => Some(Goal::Point(points[v])),
    };
    vertices.par_iter().map(goal).collect()
}

/// The middle of the triangles around a free vertex, each weighted by its area against its target, in its tangent plane.
fn middle(mesh: &SimMesh<'_>, points: &IdVec<VertexId, Vec3>, vertex: VertexId) -> Option<Vec3> {
    if mesh.grade[vertex] != Grade::Free {
        return None;
    }
    let own = points[vertex];
    let (mut sum, mut weight, mut normal) = (Vec3::ZERO, 0.0f32, Vec3::ZERO);
    for corner in mesh.topology.fan(vertex) {
        let (a, b) = (mesh.topology.target(corner), mesh.topology.vertex(prev(corner)));
        let (u, v) = (points[a] - own, points[b] - own);
        let cross = u.cross(v);
        let target = (mesh.target[vertex] + mesh.target[a] + mesh.target[b]) / 3.0;
        let w = cross.length() / (target * target);
        sum += w * (u + v);
        weight += w;
        normal += cross;
    }
    if weight <= 0.0 {
        return None;
    }
    let shift = sum / (3.0 * weight);
    let normal = normal.normalize_or_zero();
    Some(own + shift - normal * normal.dot(shift))
}

/// The arc length at which both edges of a chain's vertex are alike, as their chain counts them.
fn even(mesh: &SimMesh<'_>, vertex: VertexId) -> Option<f32> {
    let [ahead, back] = mesh.chain_neighbours(vertex)?;
    let (after, before) = (mesh.span(ahead)?.along(), mesh.span(back)?.along());
    let chain = mesh.chain(after.chain);
    let middle = 0.5 * (mesh.count(before) + mesh.count(after));
    let s = chain.at_count(chain.count_to(before.from) + middle);
    // A loop's two edges may count from different turns.
    Some(s - before.to)
}

/// Moves vertices `step` of their way, back to the surface. Returns those that had to go back.
fn attempt(mesh: &mut SimMesh<'_>, goals: &[(VertexId, Goal)], step: f32) -> Vec<(VertexId, Goal)> {
    let moves: Vec<Option<Move>> = goals.par_iter().map(|&(v, goal)| wanted(mesh, v, goal, step)).collect();
    let mut undo: IdVec<VertexId, Option<u32>> = IdVec::filled(None, mesh.points.len());
    let mut old: Vec<Move> = Vec::with_capacity(moves.len());
    for wanted in moves.into_iter().flatten() {
        undo[wanted.vertex] = Some(old.len() as u32);
        old.push(swap(mesh, wanted));
    }
    let all = goals.len() * 4 > mesh.points.len();
    let mut suspects: Vec<FaceId> = match all {
        true => mesh.topology.faces().collect(),
        false => around(mesh, old.iter().map(|m| m.vertex)),
    };
    let mut refused: Vec<VertexId> = Vec::new();
    loop {
        let bad: Vec<bool> = suspects.par_iter().map(|&f| is_worse(mesh, f, &undo, &old)).collect();
        let mut back: Vec<VertexId> = suspects
            .iter()
            .zip(bad)
            .filter(|(_, bad)| *bad)
            .flat_map(|(&f, _)| mesh.topology.triangle(f))
            .filter(|&v| undo[v].is_some())
            .collect();
        back.sort_unstable();
        back.dedup();
        if back.is_empty() {
            break;
        }
        for &v in &back {
            if let Some(i) = undo[v].take() {
                let slot = &mut old[i as usize];
                let was = std::mem::replace(slot, Move { slide: None, sites: [None, None], ..*slot });
                swap(mesh, was);
            }
        }
        suspects = around(mesh, back.iter().copied());
        refused.extend(back);
    }
    refused.sort_unstable();
    let is_refused = |v: &VertexId| refused.binary_search(v).is_ok();
    goals.iter().filter(|(v, _)| is_refused(v)).copied().collect()
}

/// The triangles around some vertices, each once.
fn around(mesh: &SimMesh<'_>, vertices: impl Iterator<Item = VertexId>) -> Vec<FaceId> {
    let mut faces: Vec<FaceId> = vertices.flat_map(|v| mesh.topology.fan(v).map(face)).collect();
    faces.sort_unstable();
    faces.dedup();
    faces
}

fn wanted(mesh: &SimMesh<'_>, vertex: VertexId, goal: Goal, step: f32) -> Option<Move> {
    match goal {
        Goal::Point(goal) => {
            let own = mesh.site_of[mesh.topology.fan(vertex).next()?];
            let start = mesh.sites[own].place.location.face;
            let there = mesh.baseline.closest(start, mesh.points[vertex].lerp(goal, step));
            let site = mesh.site_on(there.location);
            let target = mesh.baseline.target_at(there.location);
            Some(Move { vertex, position: there.position, target, sites: [Some((own, site)), None], slide: None })
        }
        Goal::Curve(by) => slide(mesh, vertex, step * by),
    }
}

fn slide(mesh: &SimMesh<'_>, vertex: VertexId, by: f32) -> Option<Move> {
    let [ahead, back] = mesh.chain_neighbours(vertex)?;
    let after = mesh.span(ahead)?.along();
    let s = mesh.span(back)?.along().to + by;
    let (position, left) = mesh.on_curve(after.chain, s, true);
    let (_, right) = mesh.on_curve(after.chain, s, false);
    // The corner of the half-edge that leaves forward lies on the left; that of the one that leaves backward, right.
    let leaves = |half: CornerId| mesh.topology.vertex(half) == vertex;
    let on_left = if leaves(ahead) { Some(ahead) } else { Some(next(back)).filter(|_| !leaves(back)) };
    let on_right = if leaves(back) { Some(back) } else { Some(next(ahead)).filter(|_| !leaves(ahead)) };
    let site = |corner: Option<CornerId>, place: Option<_>| Some((mesh.site_of[corner?], mesh.site_at(place?)));
    let sites = [site(on_left, left), site(on_right, right)];
    let location = left.or(right)?.location;
    let target = mesh.baseline.target_at(location);
    Some(Move { vertex, position, target, sites, slide: Some(Slide { ahead, back, by }) })
}

/// Does a move; returns the move back.
fn swap(mesh: &mut SimMesh<'_>, wanted: Move) -> Move {
    let Move { vertex, position, target, sites, slide } = wanted;
    let position = std::mem::replace(&mut mesh.points[vertex], position);
    let target = std::mem::replace(&mut mesh.target[vertex], target);
    let sites = sites.map(|s| s.map(|(id, site)| (id, std::mem::replace(&mut mesh.sites[id], site))));
    let slide = slide.map(|Slide { ahead, back, by }| {
        for (half, starts) in [(ahead, true), (back, false)] {
            let Some(mark) = mesh.mark[half] else { continue };
            let span = &mut mesh.spans[mark.span()];
            *(if starts { &mut span.from } else { &mut span.to }) += by;
        }
        Slide { ahead, back, by: -by }
    });
    Move { vertex, position, target, sites, slide }
}

/// Whether the moves of its corners made a triangle worse.
fn is_worse(mesh: &SimMesh<'_>, f: FaceId, undo: &IdVec<VertexId, Option<u32>>, old: &[Move]) -> bool {
    let corners = [0, 1, 2].map(|k| CornerId::new(3 * f.index() + k));
    let now = mesh.badness(corners.map(|c| mesh.corner(c)));
    let passes = corners.iter().any(|&c| {
        mesh.mark[c].is_some_and(|m| {
            let span = mesh.spans[m.span()];
            span.from >= span.to
        })
    });
    if now == 0 && !passes {
        return false;
    }
    let before = corners.map(|c| {
        let (point, site) = mesh.corner(c);
        match undo[mesh.topology.vertex(c)] {
            None => (point, site),
            Some(i) => {
                let old = &old[i as usize];
                let id = mesh.site_of[c];
                let site = old.sites.iter().flatten().find(|(s, _)| *s == id).map_or(site, |(_, site)| site);
                (old.position, site)
            }
        }
    });
    passes || now > mesh.badness(before)
}
