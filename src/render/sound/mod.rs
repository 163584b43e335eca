//! Operators make no face cross another, or turn over, that did not before: where one would, its heights are reduced
//! step by step, first to almost nothing, then together with the fit to the limit surface. What is turned over steps back
//! first, as it is found without a search for pairs. Only faces are looked at that have another layer near, less height than
//! asked, or a bend: others are sound by how they are made.

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
/// Steps back of what is turned over before crossings are looked for. More lower heights that need not be.
const TURNS: usize = 2;
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
    let mut mending = Mending::new(kin, states);
    mending.turn_back();
    // Where a step back makes more faults than it mends, as beside the free border of a layer, an earlier one is kept.
    let mut best: Option<Sound> = None;
    let mut pairs: Vec<[FaceId; 2]> = Vec::new();
    for _ in 0..STEPS.len() {
        // Faces that did not move are as they were.
        pairs.retain(|pair| pair.iter().all(|&f| !mending.is_active[f]));
        pairs.extend(mending.faults());
        let faults = faces_of(&pairs);
        if best.as_ref().is_none_or(|best| faults.len() < best.faults.len()) {
            best = Some(mending.as_it_is(faults.clone()));
        }
        if !mending.step_back(&faults) {
            break;
        }
    }
    best.unwrap_or_else(|| mending.as_it_is(Vec::new()))
}

/// A mesh while its faults are mended.
struct Mending<'a> {
    kin: &'a Kin<'a>,
    states: &'a States<'a>,
    skin: Skin<'a>,
    /// The parent's skin, as far as it was asked about.
    before: Skin<'a>,
    /// Normals where the weights alone put the faces.
    normals: IdVec<FaceId, Vec3>,
    /// How far each vertex has stepped back.
    steps: IdVec<VertexId, u8>,
    points: IdVec<VertexId, Vec3>,
    /// Faces that may have become unsound with the last step.
    is_active: IdVec<FaceId, bool>,
}

impl<'a> Mending<'a> {
    fn new(kin: &'a Kin<'a>, states: &'a States<'a>) -> Self {
        let points = states.raised.clone();
        let skin = Skin::new(kin.child, &points);
        let normals = linear_normals(kin.child.level(), states.linear);
        let is_active = |f: FaceId| {
            kin.moved[f] && (kin.doubtful[f] || skin.is_bent(f) || skin.normal(f).dot(normals[f]) < ONE_WAY)
        };
        let is_active = kin.moved.ids().map(is_active).collect();
        let steps = IdVec::filled(0, points.len());
        Self { kin, states, skin, before: Skin::bare(kin.parent), normals, steps, points, is_active }
    }

    fn as_it_is(&self, faults: Vec<FaceId>) -> Sound {
        let share = |&step: &u8| LEAST_SHARE + (1.0 - LEAST_SHARE) * STEPS[usize::from(step)].0;
        Sound { points: self.points.clone(), shares: self.steps.iter().map(share).collect(), faults }
    }

    /// Takes steps back at what is turned over. Most of what crosses is, too, and this is found without a search for pairs.
    fn turn_back(&mut self) {
        let mut all = self.is_active.clone();
        for _ in 0..TURNS {
            let turned = self.turned();
            if !self.step_back(&turned) {
                break;
            }
            all.iter_mut().zip(self.is_active.iter()).for_each(|(all, now)| *all |= now);
        }
        self.is_active = all;
    }

    /// Takes a step back at the vertices of `faults`, and as many at their neighbours as keep the change even; whether any
    /// vertex did.
    fn step_back(&mut self, faults: &[FaceId]) -> bool {
        let changed = step_on(self.kin, &mut self.steps, faults);
        if changed.is_empty() {
            return false;
        }
        let (states, steps, points) = (self.states, &self.steps, &mut self.points);
        let moved = changed.into_iter().filter(|&vertex| {
            let place = states.at(vertex, STEPS[usize::from(steps[vertex])]);
            std::mem::replace(&mut points[vertex], place) != place
        });
        self.is_active = reached(self.kin.child.level(), moved);
        self.skin.update(&self.points, &self.is_active);
        true
    }

    /// Active faces that are turned over, and were not before.
    fn turned(&mut self) -> Vec<FaceId> {
        let mut turned = self.skin.turned(&self.is_active, &self.normals);
        self.know(&turned);
        let parent_face = |f: FaceId| self.kin.derivation.parent_face(f);
        turned.retain(|&f| {
            let p = parent_face(f);
            !self.before.is_turned(p, self.before.normal(p), ALREADY_TURNED)
        });
        turned
    }

    /// Pairs of faces that cross, and faces with themselves that are turned over, and did not before.
    fn faults(&mut self) -> Vec<[FaceId; 2]> {
        let mut crossing = self.skin.crossings(&self.is_active);
        let faces: Vec<FaceId> = crossing.iter().flatten().copied().collect();
        self.know(&faces);
        let (mut scratch, derivation) = (Scratch::default(), self.kin.derivation);
        crossing.retain(|pair| {
            let [f, g] = pair.map(|face| derivation.parent_face(face));
            !self.before.cross(f, g, &mut scratch)
        });
        crossing.extend(self.turned().into_iter().map(|f| [f, f]));
        crossing
    }

    /// Measures the parents of some faces.
    fn know(&mut self, faces: &[FaceId]) {
        let mut is_parent = IdVec::filled(false, self.kin.parent.topology.faces.len());
        faces.iter().for_each(|&f| is_parent[self.kin.derivation.parent_face(f)] = true);
        self.before.update(self.kin.parent_points, &is_parent);
    }
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
