//! Operators make no face cross another, or turn over, that did not before: where one would, its heights are reduced
//! step by step, first to almost nothing, then together with the fit to the limit surface. What is left after that is
//! mended by small moves (`mend`, `untangle`): what looks away from the front of the input, second layers that cross the
//! first, and what else crosses (`apart`), on the last cage also on the second refinement (`close`, `ahead`).
//!
//! Only faces are looked at that have another layer near where they go, a bend, or a corner so narrow that they may pass a
//! neighbour in its plane: others are sound by how they are made.
//!
//! A face is looked at with its four children at once, in the lanes of vector registers (`lanes`, `piece`), and faces that
//! are near each other are near in memory (`tree::order`).

mod ahead;
mod apart;
mod choice;
mod close;
mod cross;
mod gap;
mod lanes;
mod marks;
mod mend;
mod piece;
mod skin;
mod tree;
mod untangle;

pub use ahead::Before;
use choice::{Tried, best_of_each};
use close::Nearness;
pub use gap::{Gap, OPEN};
use marks::Marks;
pub use skin::Skin;
pub use tree::order;
use untangle::Apart;

use super::derivation::Derivation;
use crate::mesh::{FaceId, IdVec, Topology, VertexId};
use crate::subdivide::{Connectivity, Level, Lineage};
use glam::Vec3;
use rayon::prelude::*;

/// Part of a height that is left in any case.
pub const LEAST_SHARE: f32 = 0.1;
/// Parts of the rest of the height that are left after each step, and whether the fit is. Finer steps leave more of both,
/// and take longer.
const STEPS: [(f32, bool); 4] = [(1.0, true), (0.3, true), (0.0, true), (0.0, false)];
/// The step of a vertex that was moved by the first attempt to untangle faces; those of more attempts follow.
const UNTANGLED: u8 = STEPS.len() as u8;
/// Cosine below which faces of the parent, and of the input, count as turned over themselves.
pub const ALREADY_TURNED: f32 = 0.3;

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
    /// The child.
    pub child: &'a Connectivity,
    /// The parent's.
    pub parent: &'a Level,
    /// The parent's points.
    pub parent_points: &'a IdVec<VertexId, Vec3>,
    /// What made the child of the parent.
    pub derivation: &'a Derivation,
    /// Pairs of a vertex and its copy, which keep together.
    pub pairs: &'a [[VertexId; 2]],
    /// Vertices on marked edges.
    pub marked: &'a IdVec<VertexId, bool>,
    /// The child's faces in an order in which neighbours are near.
    pub order: &'a [FaceId],
    /// Where the front of the input is for each of the child's faces, zero where either side may be.
    pub front: &'a IdVec<FaceId, Vec3>,
    /// Faces that may have moved, in their order.
    pub moved: &'a [FaceId],
    /// Those that have another layer near where they may have gone. Others may be unsound only where they are not even.
    pub near: &'a IdVec<FaceId, bool>,
    /// What is to be seen to on the second refinement, which is that of the last cage only.
    pub ahead: Option<LookAhead<'a>>,
}

/// What is to be seen to on the second refinement.
pub struct LookAhead<'a> {
    /// What may cross there.
    pub before: Before<'a>,
    /// Faces that have another layer all but in their place.
    pub close: IdVec<FaceId, bool>,
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
    let stepped = mending.stepped_back();
    let share = |&step: &u8| LEAST_SHARE + (1.0 - LEAST_SHARE) * STEPS[usize::from(step)].0;
    let shares = stepped.steps.iter().map(share).collect();
    let faults = mending.untangle(stepped);
    Sound { points: mending.points, shares, faults }
}

/// A mesh while its faults are mended.
struct Mending<'a> {
    kin: &'a Kin<'a>,
    states: &'a States<'a>,
    skin: Skin<'a>,
    /// The parent's skin, as far as it was asked about.
    before: Skin<'a>,
    /// How far each vertex has stepped back.
    steps: IdVec<VertexId, u8>,
    points: IdVec<VertexId, Vec3>,
    /// Faces whose children moved with the last step, in their order.
    moved: Vec<FaceId>,
    /// Those of them that may be unsound now, in their order.
    active: Vec<FaceId>,
    /// Whether faces are held to the front of the input, where it is known, and not to where the weights alone put them.
    by_front: bool,
    /// Where the points were when it was first seen what crosses on the second refinement. None where it is not looked at.
    parted_from: Option<IdVec<VertexId, Vec3>>,
    /// What is near each other there.
    nearness: Option<Nearness>,
    /// What parts all that was found to cross since.
    apart: Vec<Apart>,
    /// Where vertices are that were moved by each attempt to untangle faces.
    untangled: Vec<IdVec<VertexId, Vec3>>,
}

impl<'a> Mending<'a> {
    fn new(kin: &'a Kin<'a>, states: &'a States<'a>) -> Self {
        let points = states.raised.clone();
        let normals = linear_normals(kin.child.level(), states.linear);
        let skin = Skin::of(kin.child, &points, kin.order, Some(normals));
        let (before, steps) = (Skin::bare(kin.parent), IdVec::filled(0, points.len()));
        let mut mending = Self {
            kin,
            states,
            skin,
            before,
            steps,
            points,
            moved: Vec::new(),
            active: Vec::new(),
            by_front: false,
            parted_from: None,
            nearness: None,
            apart: Vec::new(),
            untangled: Vec::new(),
        };
        mending.see(kin.moved.to_vec());
        mending
    }

    /// Notes what moved, and what of it may be unsound.
    fn see(&mut self, moved: Vec<FaceId>) {
        let is_doubtful = |&f: &FaceId| self.kin.near[f] || !self.skin.is_even(f);
        self.active = moved.iter().copied().filter(is_doubtful).collect();
        self.moved = moved;
    }

    /// Steps back at what is turned over. Most of what crosses is there too, and this is found without a search for pairs.
    fn turn_back(&mut self) {
        let turned: Vec<[FaceId; 2]> = self.turned().into_iter().map(|f| [f, f]).collect();
        let moved = self.moved.clone();
        self.step_to(self.stepped_on(&turned, 1));
        self.see(moved);
    }

    /// The best of all steps back.
    fn stepped_back(&mut self) -> Tried {
        let mut tried: Vec<Tried> = Vec::with_capacity(STEPS.len() + 1);
        let mut pairs: Vec<[FaceId; 2]> = Vec::new();
        loop {
            self.search(&mut pairs);
            tried.push(Tried { steps: self.steps.clone(), pairs: pairs.clone() });
            // More find nearly nothing.
            if tried.len() == STEPS.len() || !self.step_to(self.stepped_on(&pairs, 1)) {
                return self.best(tried);
            }
        }
    }

    /// Goes to the best of what was tried, each part by itself; the last of it is how things are.
    fn best(&mut self, mut tried: Vec<Tried>) -> Tried {
        if let Some(steps) = best_of_each(&self.kin.child.level().topology, &tried, self.kin.pairs) {
            let mut pairs = tried.last().map_or_else(Vec::new, |last| last.pairs.clone());
            self.step_to(steps.clone());
            self.search(&mut pairs);
            tried.push(Tried { steps, pairs });
        }
        let best = tried.into_iter().min_by_key(Tried::faults);
        let best = best.unwrap_or_else(|| Tried { steps: self.steps.clone(), pairs: Vec::new() });
        self.step_to(best.steps.clone());
        best
    }

    /// Has each vertex step back so far; whether any did before by another step.
    fn step_to(&mut self, steps: IdVec<VertexId, u8>) -> bool {
        if steps == self.steps {
            return false;
        }
        let vertices = self.move_to(&steps);
        self.steps = steps;
        let t = &self.kin.child.level().topology;
        let at = faces_at(t, vertices.iter().copied());
        let moved = touching(t, &at);
        self.skin.update(&self.points, &at, &moved);
        if self.by_front {
            self.skin.loosen(&moved);
        }
        if let Some(nearness) = &mut self.nearness {
            nearness.update(&self.skin, &moved);
        }
        self.see(moved);
        true
    }

    /// The steps after so many more at the vertices of what crosses, and of what is turned over with what touches it. A
    /// marked edge steps back for its own faces only.
    fn stepped_on(&self, pairs: &[[FaceId; 2]], more: u8) -> IdVec<VertexId, u8> {
        let t = &self.kin.child.level().topology;
        let turned: Vec<FaceId> = pairs.iter().filter(|[f, g]| f == g).map(|pair| pair[0]).collect();
        let vertices_of = |face: FaceId| t.faces.vertices_of(face).iter().copied();
        let around = touching(t, &turned).into_iter().flat_map(vertices_of).filter(|&v| !self.kin.marked[v]);
        let mut steps = self.steps.clone();
        for vertex in around.chain(pairs.iter().flatten().copied().flat_map(vertices_of)) {
            steps[vertex] = self.steps[vertex].saturating_add(more).min(STEPS.len() as u8 - 1);
        }
        for &[vertex, copy] in self.kin.pairs {
            let most = steps[vertex].max(steps[copy]);
            (steps[vertex], steps[copy]) = (most, most);
        }
        steps
    }

    /// Moves the points to where vertices are that have stepped back so far; those that have moved.
    fn move_to(&mut self, steps: &IdVec<VertexId, u8>) -> Vec<VertexId> {
        let mut moved = Vec::new();
        for vertex in steps.ids().filter(|&v| steps[v] != self.steps[v]) {
            let step = STEPS.get(usize::from(steps[vertex]));
            let untangled = || self.untangled[usize::from(steps[vertex] - UNTANGLED)][vertex];
            let place = step.map_or_else(untangled, |&step| self.states.at(vertex, step));
            if std::mem::replace(&mut self.points[vertex], place) != place {
                moved.push(vertex);
            }
        }
        moved
    }

    /// Brings the pairs of faces that were found before up to date.
    fn search(&mut self, pairs: &mut Vec<[FaceId; 2]>) {
        // Faces that did not move are as they were; what crossed and did is looked at again.
        let moved = pairs.iter().flatten().copied().filter(|f| self.moved.binary_search(f).is_ok());
        self.active = each_once(self.active.iter().copied().chain(moved).collect());
        pairs.retain(|pair| pair.iter().all(|f| self.active.binary_search(f).is_err()));
        pairs.extend(self.faults());
        let found = self.parted_from.as_ref().and_then(|before| self.later(&self.moved, before));
        if let Some(found) = found {
            pairs.extend(found.pairs);
            self.apart.extend(found.apart);
        }
    }

    /// Faces that are turned over, and were not before. No even one is.
    fn turned(&mut self) -> Vec<FaceId> {
        let is_known = |f: &FaceId| self.by_front && self.kin.front[*f] != Vec3::ZERO;
        let (known, others): (Vec<FaceId>, Vec<FaceId>) = self.active.iter().partition(|f| is_known(f));
        let mut turned = self.skin.turned(&others);
        self.know(&turned);
        let parent_face = |f: FaceId| self.kin.derivation.parent_face(f);
        turned.retain(|&f| {
            let p = parent_face(f);
            !self.before.is_turned(p, self.before.normal(p), ALREADY_TURNED)
        });
        turned.extend(self.skin.turned_from(self.kin.front, &known));
        turned
    }

    /// Pairs of faces that cross, and faces with themselves that are turned over, and did not before.
    fn faults(&mut self) -> Vec<[FaceId; 2]> {
        let mut crossing = self.skin.crossings(&self.active);
        let faces: Vec<FaceId> = crossing.iter().flatten().copied().collect();
        self.know(&faces);
        let derivation = self.kin.derivation;
        crossing.retain(|pair| {
            let [f, g] = pair.map(|face| derivation.parent_face(face));
            !self.before.cross(f, g)
        });
        crossing.extend(self.turned().into_iter().map(|f| [f, f]));
        crossing
    }

    /// Measures the parents of some faces.
    fn know(&mut self, faces: &[FaceId]) {
        let parents = faces.iter().map(|&f| self.kin.derivation.parent_face(f)).filter(|&p| !self.before.knows(p));
        self.before.learn(self.kin.parent_points, &each_once(parents.collect()));
    }
}

/// Normals of the faces where the weights alone put them; none of faces without area.
fn linear_normals(level: &Level, points: &IdVec<VertexId, Vec3>) -> IdVec<FaceId, Vec3> {
    let faces = &level.topology.faces;
    let normal = |face| {
        let vertices = faces.vertices_of(face);
        let area = twice_area(vertices, points);
        let squared = |&v: &VertexId| points[v].distance_squared(points[vertices[0]]);
        let longest = vertices.iter().map(squared).fold(0.0, f32::max);
        if area.length() > 1e-3 * longest { area.normalize() } else { Vec3::ZERO }
    };
    (0..faces.len()).into_par_iter().map(|face| normal(FaceId::new(face))).collect::<Vec<_>>().into()
}

/// Twice the area of a face, as a vector.
pub fn twice_area(vertices: &[VertexId], points: &IdVec<VertexId, Vec3>) -> Vec3 {
    let at = |v: VertexId| points[v] - points[vertices[0]];
    vertices.windows(2).map(|pair| at(pair[0]).cross(at(pair[1]))).sum()
}

/// The faces of pairs, each once.
fn faces_of(pairs: &[[FaceId; 2]]) -> Vec<FaceId> {
    each_once(pairs.iter().flatten().copied().collect())
}

/// Elements in their order, each once.
fn each_once<I: Ord>(mut all: Vec<I>) -> Vec<I> {
    all.sort_unstable();
    all.dedup();
    all
}

/// Some faces and those that touch them, in their order.
fn touching(t: &Topology, faces: &[FaceId]) -> Vec<FaceId> {
    let mut vertices = Marks::new(t.vertex_count());
    faces.iter().flat_map(|&f| t.faces.vertices_of(f)).for_each(|&v| vertices.add(v));
    faces_at(t, vertices.list.into_iter())
}

/// The faces at some vertices, in their order.
fn faces_at(t: &Topology, vertices: impl Iterator<Item = VertexId>) -> Vec<FaceId> {
    let mut faces = Marks::new(t.faces.len());
    vertices.flat_map(|v| t.faces_at(v)).for_each(|face| faces.add(face));
    faces.list.sort_unstable();
    faces.list
}
