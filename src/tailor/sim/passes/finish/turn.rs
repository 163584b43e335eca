//! Turn: where a triangle faces away from the surface under its middle, an edge flips or a vertex moves.
//!
//! All other passes compare a triangle with the surface at its corners. In a tight turn these face several ways, and the
//! triangle may face away from all that lies between them.

use crate::sim::sim_mesh::{Defect, Destination, SimMesh, VertexConstraint};
use glam::Vec3;
use rayon::prelude::*;
use std::f32::consts::TAU;
use tailor_mesh::connectivity::edit::{corners, face};
use tailor_mesh::connectivity::{CornerId, FaceId, VertexId};

/// Least cosine to the surface at each corner from which a triangle is not measured: it faces all the surface around it.
const SURELY_FACING: f32 = 0.5;
/// Triangles at which vertices may move, so that time is bounded. Where more face away, the surface itself is crumpled.
const MOST_MOVED: usize = 256;
/// Triangles around a vertex that may move, for the same reason.
const MOST_AROUND: usize = 24;
/// Directions in which a free vertex may move.
const DIRECTIONS: usize = 8;
/// Lengths of its moves, as shares of the target length.
const STEPS: [f32; 4] = [0.08, 0.16, 0.3, 0.5];
/// Moves of a chain's vertex, as shares of its shorter edge there.
const SLIDES: [f32; 6] = [-0.2, 0.2, -0.4, 0.4, -0.7, 0.7];

/// Edits the mesh where triangles face away, in the order of their ids, so that the result is the same for any number of
/// threads.
pub fn turn_to_surface(mesh: &mut SimMesh<'_>) {
    let faces = (0..mesh.topology.face_slots()).into_par_iter().map(FaceId::new);
    let away: Vec<FaceId> = faces.filter(|&f| is_away(mesh, f)).collect();
    let remaining: Vec<FaceId> = away.into_iter().filter(|&f| !flip_at(mesh, f)).collect();
    for f in remaining.into_iter().take(MOST_MOVED) {
        shift_at(mesh, f);
    }
    mesh.debug_check();
}

/// Whether a corner's triangle faces away from the surface nearest to its middle.
fn faces_away(mesh: &SimMesh<'_>, corner: CornerId) -> bool {
    let corners = mesh.corners(corner);
    if mesh.alignment(corners) > SURELY_FACING {
        return false;
    }
    let [(a, p), (b, q), (c, r)] = corners;
    let near = mesh.baseline.closest_from([p, q, r].map(|wedge| wedge.place.location.face), (a + b + c) / 3.0);
    (b - a).cross(c - a).dot(mesh.baseline.normal(near.location.face)) < 0.0
}

/// Whether a triangle is there still and faces away.
fn is_away(mesh: &SimMesh<'_>, f: FaceId) -> bool {
    let first = CornerId::new(3 * f.index());
    mesh.topology.is_alive(first) && faces_away(mesh, first)
}

/// Flips an edge of a triangle that faces away. Returns whether it does so no more.
fn flip_at(mesh: &mut SimMesh<'_>, f: FaceId) -> bool {
    !is_away(mesh, f) || corners(f).any(|half| flip(mesh, half))
}

/// Moves a vertex of a triangle that faces away.
fn shift_at(mesh: &mut SimMesh<'_>, f: FaceId) {
    if is_away(mesh, f) {
        let _ = corners(f).any(|c| shift(mesh, mesh.topology.vertex(c)));
    }
}

/// How bad the triangles of some corners are: how many face away or have a defect, and the worst defect.
type Fault = (usize, Defect);

fn fault(mesh: &SimMesh<'_>, at: &[CornerId]) -> Fault {
    at.iter().fold((0, Defect::Good), |(count, worst), &corner| {
        let defect = mesh.face_defect(corner);
        let is_bad = defect > Defect::Good || faces_away(mesh, corner);
        (count + usize::from(is_bad), worst.max(defect))
    })
}

fn is_better(now: Fault, before: Fault) -> bool {
    now.0 < before.0 && now.1 <= before.1
}

/// Flips an edge if fewer triangles face away then.
fn flip(mesh: &mut SimMesh<'_>, half: CornerId) -> bool {
    let Some(twin) = mesh.topology.twin(half).filter(|_| !mesh.is_constrained(half) && mesh.may_flip(half)) else {
        return false;
    };
    let before = fault(mesh, &[half, twin]);
    mesh.flip(half);
    let turns = is_better(fault(mesh, &[half, twin]), before);
    if !turns {
        mesh.unflip(half);
    }
    turns
}

/// Moves a vertex by the shortest way after which fewer triangles face away.
fn shift(mesh: &mut SimMesh<'_>, vertex: VertexId) -> bool {
    let fan: Vec<CornerId> = mesh.topology.fan(vertex).take(MOST_AROUND + 1).collect();
    if fan.len() > MOST_AROUND {
        return false;
    }
    let before = fault(mesh, &fan);
    destinations(mesh, vertex).into_iter().any(|goal| {
        let Some(mut there) = mesh.find_move(vertex, goal, 1.0) else { return false };
        mesh.swap(&mut there);
        let is_reversed = |&c: &CornerId| corners(face(c)).any(|c| mesh.is_reversed(c));
        let turns = is_better(fault(mesh, &fan), before) && !fan.iter().any(is_reversed);
        if !turns {
            mesh.swap(&mut there);
        }
        turns
    })
}

/// Where a vertex may go, the nearest places first.
fn destinations(mesh: &SimMesh<'_>, vertex: VertexId) -> Vec<Destination> {
    match mesh.constraint[vertex] {
        VertexConstraint::Free => around(mesh, vertex),
        VertexConstraint::OnCurve(_) => {
            let shorter = mesh.curve_neighbours(vertex).map(|near| near.lengths()).map_or(0.0, |[a, b]| a.min(b));
            SLIDES.iter().map(|share| Destination::Along(share * shorter)).collect()
        }
        VertexConstraint::Fixed => Vec::new(),
    }
}

/// Places in the plane of a free vertex's surface.
fn around(mesh: &SimMesh<'_>, vertex: VertexId) -> Vec<Destination> {
    let Some(wedge) = mesh.topology.fan(vertex).next().map(|c| mesh.wedge(c)) else { return Vec::new() };
    let (x, y) = wedge.normal.try_normalize().unwrap_or(Vec3::Z).any_orthonormal_pair();
    let place = |step: f32, k: usize| {
        let (sin, cos) = (k as f32 * TAU / DIRECTIONS as f32).sin_cos();
        Destination::Near(mesh.points[vertex] + step * mesh.target[vertex] * (cos * x + sin * y))
    };
    STEPS.iter().flat_map(|&step| (0..DIRECTIONS).map(move |k| (step, k))).map(|(step, k)| place(step, k)).collect()
}
