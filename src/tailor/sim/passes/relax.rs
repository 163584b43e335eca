//! Relax: free vertices move to the weighted centroid of their triangles and back to the surface; vertices on a chain slide
//! along its curve; anchors stay.
//!
//! Averages are taken in the surface's tangent planes, or of UVs (`relax_uv`).
//!
//! All moves are found on the same mesh and made together; those that made a triangle worse are undone. So the result is
//! the same for any number of threads.

use super::even::even_slide;
use super::relax_uv::move_in_uv;
use crate::sim::options::Relaxation;
use crate::sim::sim_mesh::{Defect, Destination, SimMesh, VertexConstraint, VertexMove};
use glam::{Vec3, Vec3A, Vec4};
use rayon::prelude::*;
use std::hint::black_box;
use std::ops::Range;
use tailor_mesh::connectivity::edit::face;
use tailor_mesh::connectivity::{CornerId, FaceId, IdVec, VertexId};

/// Successive shares of the way that vertices try to move: where moves would turn triangles over, they try again and shorter.
const STEPS: [f32; 3] = [1.0, 0.5, 0.25];

/// Vertices that one task averages.
const VERTICES_PER_TASK: usize = 2048;

/// Vertices whose surface data is loaded together before they move. It is far apart in memory; loading it at the same time
/// saves a tenth of a relaxation.
const GROUP: usize = 16;
/// Least groups of one task.
const MIN_GROUPS: usize = 32;

/// Moves every vertex once, after `sweeps` averages.
pub fn relax_and_project(mesh: &mut SimMesh<'_>, sweeps: usize, relaxation: Relaxation) {
    let mut waiting = surface_centroids(mesh, sweeps);
    if relaxation == Relaxation::Uv {
        move_in_uv(mesh, sweeps, &mut waiting);
    }
    waiting.extend(slides(mesh));
    let mut moves = Vec::new();
    for step in STEPS {
        waiting = attempt(mesh, &waiting, step, &mut moves);
        if waiting.is_empty() {
            break;
        }
    }
    mesh.debug_check();
}

/// The rings of some free vertices, in one array.
struct Rings {
    vertices: Vec<VertexId>,
    start: Vec<u32>,
    neighbours: Vec<VertexId>,
    normals: Vec<Vec3A>,
}

impl Rings {
    /// The rings of the free vertices in `range`.
    fn new(mesh: &SimMesh<'_>, range: Range<usize>) -> Self {
        let is_free = |v: &VertexId| mesh.constraint[*v] == VertexConstraint::Free && mesh.topology.has_faces(*v);
        let vertices: Vec<VertexId> = range.map(VertexId::new).filter(is_free).collect();
        let (mut start, mut neighbours) = (vec![0], Vec::with_capacity(7 * vertices.len()));
        for &v in &vertices {
            neighbours.extend(mesh.topology.fan(v).map(|c| mesh.topology.target(c)));
            start.push(neighbours.len() as u32);
        }
        let mut rings = Self { vertices, start, neighbours, normals: Vec::new() };
        let normals = rings.iter().map(|(v, ring)| mean_normal(&mesh.points, v, ring).into());
        rings.normals = normals.collect();
        rings
    }

    fn iter(&self) -> impl Iterator<Item = (VertexId, &[VertexId])> {
        let ring = |s: &[u32]| &self.neighbours[s[0] as usize..s[1] as usize];
        self.vertices.iter().copied().zip(self.start.windows(2).map(ring))
    }

    /// The centroid around each vertex.
    fn centroids(&self, points: &IdVec<VertexId, Vec4>) -> Vec<Vec3> {
        self.iter().zip(&self.normals).map(|((v, ring), &normal)| centroid(points, v, ring, normal)).collect()
    }
}

/// The centroids around all free vertices.
fn surface_centroids(mesh: &SimMesh<'_>, sweeps: usize) -> Vec<(VertexId, Destination)> {
    let slots = mesh.topology.vertex_slots();
    let tasks = (0..slots.div_ceil(VERTICES_PER_TASK)).into_par_iter();
    let range = |t: usize| t * VERTICES_PER_TASK..slots.min((t + 1) * VERTICES_PER_TASK);
    let rings: Vec<Rings> = tasks.map(|t| Rings::new(mesh, range(t))).collect();
    // With the weight of each vertex: triangles count by their area against their target.
    let weighted = |(p, t): (&Vec3, &f32)| p.extend(1.0 / (t * t));
    let mut points: IdVec<VertexId, Vec4> = mesh.points.iter().zip(mesh.target.iter()).map(weighted).collect();
    for _ in 0..sweeps {
        let next: Vec<Vec<Vec3>> = rings.par_iter().map(|r| r.centroids(&points)).collect();
        for (v, p) in rings.iter().zip(next).flat_map(|(r, next)| r.vertices.iter().zip(next)) {
            points[*v] = p.extend(points[*v].w);
        }
    }
    let free = rings.iter().flat_map(|r| &r.vertices);
    free.map(|&v| (v, Destination::Near(points[v].truncate()))).collect()
}

/// The destinations of vertices that slide along chains.
fn slides(mesh: &SimMesh<'_>) -> Vec<(VertexId, Destination)> {
    let is_on_curve = |v: &VertexId| matches!(mesh.constraint[*v], VertexConstraint::OnCurve(_));
    let on_curves: Vec<VertexId> = mesh.constraint.ids().filter(is_on_curve).collect();
    on_curves.into_par_iter().filter_map(|v| Some((v, Destination::Along(even_slide(mesh, v)?)))).collect()
}

/// The unit normal of the triangles around a vertex together.
#[inline]
fn mean_normal(points: &IdVec<VertexId, Vec3>, vertex: VertexId, ring: &[VertexId]) -> Vec3 {
    let own = points[vertex];
    let Some(&last) = ring.last() else { return Vec3::ZERO };
    let (mut sum, mut u) = (Vec3::ZERO, points[last] - own);
    for &b in ring {
        let v = points[b] - own;
        sum += u.cross(v);
        u = v;
    }
    sum.normalize_or_zero()
}

/// The centroid of the triangles around a vertex, in the plane of the surface there. Flipped triangles have no weight.
#[inline]
fn centroid(points: &IdVec<VertexId, Vec4>, vertex: VertexId, ring: &[VertexId], normal: Vec3A) -> Vec3 {
    let (own, own_weight) = (Vec3A::from_vec4(points[vertex]), points[vertex].w);
    let Some(&last) = ring.last() else { return own.into() };
    let (mut sum, mut weight) = (Vec3A::ZERO, 0.0f32);
    let (mut u, mut u_weight) = (Vec3A::from_vec4(points[last]) - own, points[last].w);
    for &b in ring {
        let (v, v_weight) = (Vec3A::from_vec4(points[b]) - own, points[b].w);
        let w = normal.dot(u.cross(v)).max(0.0) * (own_weight + u_weight + v_weight);
        sum += w * (u + v);
        weight += w;
        (u, u_weight) = (v, v_weight);
    }
    if weight <= 0.0 {
        return own.into();
    }
    let shift = sum / (3.0 * weight);
    (own + shift - normal * normal.dot(shift)).into()
}

/// Moves vertices by a share `step` of their way, back to the surface. Returns those that had to go back.
fn attempt(
    mesh: &mut SimMesh<'_>,
    wanted: &[(VertexId, Destination)],
    step: f32,
    moves: &mut Vec<Option<VertexMove>>,
) -> Vec<(VertexId, Destination)> {
    find_moves(mesh, wanted, step, moves);
    let mut moved: IdVec<VertexId, Option<u32>> = IdVec::filled(None, mesh.points.len());
    for (i, own) in moves.iter_mut().enumerate().filter_map(|(i, m)| Some((i, m.as_mut()?))) {
        moved[own.vertex] = Some(i as u32);
        mesh.swap(own);
    }
    let mut bad: Vec<FaceId> = match wanted.len() * 4 > mesh.points.len() {
        true => {
            let all = (0..mesh.topology.face_slots()).into_par_iter().map(FaceId::new);
            all.filter(|&f| is_worse(mesh, f, &moved, moves)).collect()
        }
        false => worse_around(mesh, moves.iter().flatten().map(|m| m.vertex), &moved, moves),
    };
    let mut refused: Vec<VertexId> = Vec::new();
    while !bad.is_empty() {
        let corners = bad.iter().flat_map(|&f| mesh.topology.triangle(f));
        let mut back: Vec<VertexId> = corners.filter(|&v| moved[v].is_some()).collect();
        back.sort_unstable();
        back.dedup();
        for &v in &back {
            if let Some(way_back) = moved[v].take().and_then(|i| moves[i as usize].as_mut()) {
                mesh.swap(way_back);
            }
        }
        bad = worse_around(mesh, back.iter().copied(), &moved, moves);
        bad.retain(|&f| mesh.topology.triangle(f).iter().any(|&v| moved[v].is_some()));
        refused.extend(back);
    }
    refused.sort_unstable();
    wanted.iter().filter(|(v, _)| refused.binary_search(v).is_ok()).copied().collect()
}

/// The moves that bring vertices a share `step` of the way to their destinations.
fn find_moves(mesh: &SimMesh<'_>, wanted: &[(VertexId, Destination)], step: f32, moves: &mut Vec<Option<VertexMove>>) {
    moves.clear();
    moves.resize_with(wanted.len(), || None);
    let groups = moves.par_chunks_mut(GROUP).zip(wanted.par_chunks(GROUP)).with_min_len(MIN_GROUPS);
    groups.for_each(|(moves, wanted)| {
        black_box(wanted.iter().map(|&(v, _)| load_surface(mesh, v)).sum::<f32>());
        for (own, &(v, destination)) in moves.iter_mut().zip(wanted) {
            *own = mesh.find_move(v, destination, step);
        }
    });
}

/// Reads a value of each array that a projection at a vertex reads.
fn load_surface(mesh: &SimMesh<'_>, vertex: VertexId) -> f32 {
    let Some(corner) = mesh.topology.fan(vertex).next() else { return 0.0 };
    let face = mesh.place(corner).location.face;
    let first = CornerId::new(3 * face.index());
    let sizing = mesh.baseline.sizing[mesh.baseline.topology.faces.vertex(first)];
    mesh.baseline.facets[face].points[0].x + mesh.baseline.uvs[first].x + sizing
}

/// The triangles around some vertices that moves made worse.
fn worse_around(
    mesh: &SimMesh<'_>,
    vertices: impl Iterator<Item = VertexId>,
    moved: &IdVec<VertexId, Option<u32>>,
    moves: &[Option<VertexMove>],
) -> Vec<FaceId> {
    let mut faces: Vec<FaceId> = vertices.flat_map(|v| mesh.topology.fan(v).map(face)).collect();
    faces.sort_unstable();
    faces.dedup();
    faces.into_par_iter().filter(|&f| is_worse(mesh, f, moved, moves)).collect()
}

/// Whether the moves of its corners made a triangle worse, or vertices of a chain pass each other.
fn is_worse(mesh: &SimMesh<'_>, f: FaceId, moved: &IdVec<VertexId, Option<u32>>, moves: &[Option<VertexMove>]) -> bool {
    let first = 3 * f.index();
    let corners = [CornerId::new(first), CornerId::new(first + 1), CornerId::new(first + 2)];
    if !mesh.topology.is_alive(corners[0]) {
        return false;
    }
    let now = mesh.defect(mesh.corners(corners[0]));
    if corners.iter().any(|&c| mesh.is_reversed(c)) {
        return true;
    }
    let before = |c: CornerId| {
        let (point, wedge) = mesh.corner(c);
        let old = moved[mesh.topology.vertex(c)].and_then(|i| moves[i as usize].as_ref());
        old.map_or((point, wedge), |old| old.corner(mesh.corner_wedge[c], wedge))
    };
    now > Defect::Good && now > mesh.defect([before(corners[0]), before(corners[1]), before(corners[2])])
}
