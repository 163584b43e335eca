//! Operators make no face cross another, or turn over, that did not before: where one would, its heights are reduced
//! step by step, first to almost nothing, then together with the fit to the limit surface. Only faces are looked at that
//! have another layer near, less height than asked, or a bend: others are sound by how they are made.

mod cross;
mod gap;
mod skin;
mod tree;

use cross::Scratch;
pub use gap::{Gap, OPEN};
pub use skin::Skin;

use super::derivation::Derivation;
use crate::mesh::{FaceId, IdVec, VertexId};
use crate::subdivide::{Cage, Level, Lineage};
use glam::Vec3;
use rayon::prelude::*;

/// Part of a height that is left in any case.
pub const LEAST_SHARE: f32 = 0.1;
/// Parts of the rest of the height that are left after each step, and whether the fit is. Finer steps leave more of both,
/// and take longer.
const STEPS: [(f32, bool); 4] = [(1.0, true), (0.3, true), (0.0, true), (0.0, false)];
/// Steps by which a neighbour may be behind. More makes the change from full height more sudden.
const SLACK: u8 = 2;
/// Cosine between the normals of a face with and without its moves below which it is looked at.
const ONE_WAY: f32 = 0.5;
/// Cosine from which on faces of the parent count as turned themselves.
const ALREADY_TURNED: f32 = 0.3;

/// The places of the points in three states, from which the sound one is mixed.
pub struct States<'a> {
    /// By the operator's weights alone, with the least heights.
    pub linear: &'a IdVec<VertexId, Vec3>,
    /// Fitted to the surface, with the least heights.
    pub flat: &'a IdVec<VertexId, Vec3>,
    /// Fitted with heights.
    pub raised: &'a IdVec<VertexId, Vec3>,
}

impl States<'_> {
    /// The place of a vertex that has a part of the rest of its height, and the fit or not.
    fn at(&self, vertex: VertexId, (height, is_fitted): (f32, bool)) -> Vec3 {
        if is_fitted { self.flat[vertex].lerp(self.raised[vertex], height) } else { self.linear[vertex] }
    }
}

/// A child and its parent, whose points are known.
pub struct Kin<'a> {
    /// The child; its points are not read.
    pub child: &'a Cage,
    /// The parent's.
    pub parent: &'a Level,
    /// The parent's points.
    pub parent_points: &'a IdVec<VertexId, Vec3>,
    /// What made the child of the parent.
    pub derivation: &'a Derivation,
    /// Pairs of a vertex and its copy, which keep together.
    pub pairs: &'a [[VertexId; 2]],
    /// Faces that may have moved.
    pub moved: &'a IdVec<FaceId, bool>,
    /// Those of them that may have become unsound. Others do so only where they bend.
    pub doubtful: &'a IdVec<FaceId, bool>,
}

/// Sound points.
pub struct Sound {
    /// The points.
    pub points: IdVec<VertexId, Vec3>,
    /// For each vertex the part that is left of its height.
    pub shares: IdVec<VertexId, f32>,
    /// Faces that cross others or are turned over all the same.
    pub faults: Vec<FaceId>,
}

/// The points, with as much of their heights as leaves the mesh sound.
pub fn sound(kin: &Kin, states: &States) -> Sound {
    let mut steps: IdVec<VertexId, u8> = IdVec::filled(0, states.raised.len());
    let mut points = states.raised.clone();
    let mut skin = Skin::new(kin.child, &points);
    let normals = linear_normals(kin.child.level(), states.linear);
    let is_active =
        |f: FaceId| kin.moved[f] && (kin.doubtful[f] || skin.is_bent(f) || skin.normal(f).dot(normals[f]) < ONE_WAY);
    let mut is_active: IdVec<FaceId, bool> = kin.moved.ids().map(is_active).collect();
    // Where a step back makes more faults than it mends, as beside the free border of a layer, an earlier one is kept.
    let mut best: Option<Sound> = None;
    let mut before = Skin::bare(kin.parent);
    let share = |&s: &u8| LEAST_SHARE + (1.0 - LEAST_SHARE) * STEPS[usize::from(s)].0;
    let mut pairs: Vec<[FaceId; 2]> = Vec::new();
    for _ in 0..STEPS.len() {
        // Faces that did not move are as they were.
        pairs.retain(|pair| pair.iter().all(|&f| !is_active[f]));
        pairs.extend(faults(kin, (&mut skin, &mut before), &is_active, &normals));
        let faults = faces_of(&pairs);
        let shares = steps.iter().map(share).collect();
        let changed = step_on(kin, &mut steps, &faults);
        if best.as_ref().is_none_or(|best| faults.len() < best.faults.len()) {
            best = Some(Sound { points: points.clone(), shares, faults });
        }
        if changed.is_empty() {
            break;
        }
        let moved = changed.into_iter().filter(|&vertex| {
            let place = states.at(vertex, STEPS[usize::from(steps[vertex])]);
            std::mem::replace(&mut points[vertex], place) != place
        });
        is_active = reached(kin.child.level(), moved);
        skin.update(&points, &is_active);
    }
    best.unwrap_or_else(|| Sound { points, shares: steps.iter().map(share).collect(), faults: Vec::new() })
}

/// Normals of the faces where the weights alone put them; none of faces without area.
fn linear_normals(level: &Level, points: &IdVec<VertexId, Vec3>) -> IdVec<FaceId, Vec3> {
    let faces = &level.topology.faces;
    let normal = |face| {
        let vertices = faces.vertices_of(face);
        let at = |v: VertexId| points[v] - points[vertices[0]];
        let area: Vec3 = vertices.windows(2).map(|p| at(p[0]).cross(at(p[1]))).sum();
        let longest = vertices.iter().map(|&v| at(v).length_squared()).fold(0.0, f32::max);
        if area.length() > 1e-3 * longest { area.normalize() } else { Vec3::ZERO }
    };
    (0..faces.len()).into_par_iter().map(|face| normal(FaceId::new(face))).collect::<Vec<_>>().into()
}

/// The faces of pairs, each once.
fn faces_of(pairs: &[[FaceId; 2]]) -> Vec<FaceId> {
    let mut faces: Vec<FaceId> = pairs.iter().flatten().copied().collect();
    faces.sort_unstable();
    faces.dedup();
    faces
}

/// Pairs of faces that cross, and faces with themselves that are turned over, and did not before.
fn faults(
    kin: &Kin,
    (skin, before): (&mut Skin, &mut Skin),
    is_active: &IdVec<FaceId, bool>,
    normals: &IdVec<FaceId, Vec3>,
) -> Vec<[FaceId; 2]> {
    let (crossing, turned) = (skin.crossings(is_active), skin.turned(is_active, normals));
    let parent_face = |f: FaceId| kin.derivation.parent_face(f);
    let mut is_parent = IdVec::filled(false, kin.parent.topology.faces.len());
    crossing.iter().flatten().chain(&turned).for_each(|&f| is_parent[parent_face(f)] = true);
    before.update(kin.parent_points, &is_parent);
    let mut scratch = Scratch::default();
    let mut crossed = |&[f, g]: &[FaceId; 2]| before.cross(parent_face(f), parent_face(g), &mut scratch);
    let had_turned = |&f: &FaceId| {
        let p = parent_face(f);
        before.is_turned(p, before.normal(p), ALREADY_TURNED)
    };
    let mut faults: Vec<[FaceId; 2]> = crossing.into_iter().filter(|pair| !crossed(pair)).collect();
    faults.extend(turned.into_iter().filter(|f| !had_turned(f)).map(|f| [f, f]));
    faults
}

/// Takes a step back at the vertices of `faults`, and as many at their neighbours as keep the change even; returns the
/// vertices that took one.
fn step_on(kin: &Kin, steps: &mut IdVec<VertexId, u8>, faults: &[FaceId]) -> Vec<VertexId> {
    let t = &kin.child.level().topology;
    let last = STEPS.len() as u8 - 1;
    let mut marked: Vec<VertexId> = faults.iter().flat_map(|&f| t.faces.vertices_of(f)).copied().collect();
    marked.sort_unstable();
    marked.dedup();
    marked.retain(|&v| steps[v] < last);
    let before = steps.clone();
    marked.iter().for_each(|&v| steps[v] += 1);
    let mut front = marked;
    while !front.is_empty() {
        let mut next: Vec<VertexId> = Vec::new();
        for &vertex in &front {
            let least = steps[vertex].saturating_sub(SLACK);
            for face in t.faces_at(vertex) {
                for &other in t.faces.vertices_of(face) {
                    if steps[other] < least {
                        steps[other] = least;
                        next.push(other);
                    }
                }
            }
        }
        front = next;
    }
    for &[vertex, copy] in kin.pairs {
        let most = steps[vertex].max(steps[copy]);
        (steps[vertex], steps[copy]) = (most, most);
    }
    steps.ids().filter(|&v| steps[v] != before[v]).collect()
}

/// The faces whose children move with some vertices: those at them, and the faces that touch those.
fn reached(level: &Level, vertices: impl Iterator<Item = VertexId>) -> IdVec<FaceId, bool> {
    let t = &level.topology;
    let mut near = IdVec::filled(false, t.vertex_count());
    for face in vertices.flat_map(|v| t.faces_at(v)) {
        t.faces.vertices_of(face).iter().for_each(|&v| near[v] = true);
    }
    t.faces.ids().map(|f| t.faces.vertices_of(f).iter().any(|&v| near[v])).collect()
}
