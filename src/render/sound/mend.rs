//! Mends by small moves what stepping back leaves: what looks away from the front of the input, second layers that cross
//! the first, and what else crosses, on the last cage also on the second refinement. The better of both states of each part
//! stays.

use super::ahead::{Later, crossing_later};
use super::apart::apart_now;
use super::choice::Tried;
use super::close::Nearness;
use super::untangle::{Layer, Untangled, Wanted, untangled};
use super::{LEAST_SHARE, LookAhead, Mending, STEPS, UNTANGLED, each_once, faces_of, touching, twice_area};
use crate::mesh::{FaceId, IdVec, VertexId};
use crate::subdivide::Lineage;
use glam::Vec3;

/// Part of its height that a second layer is moved to where it crosses the first. Less leaves some of them crossing.
const APART: f32 = 0.6;
/// How many times what crosses is parted, at most.
const PARTINGS: usize = 3;

impl Mending<'_> {
    /// Turns back what looks away from the front of the input, where it is known; the faces with a fault that is left.
    pub(super) fn untangle(&mut self, mut stepped: Tried) -> Vec<FaceId> {
        let front = self.kin.front;
        self.by_front = true;
        // What looks to the front all the same may still be folded within its plane.
        let is_odd = |[f, g]: &[FaceId; 2]| f == g && front[*f] != Vec3::ZERO;
        let odd: Vec<[FaceId; 2]> = stepped.pairs.extract_if(.., |pair| is_odd(pair)).collect();
        let turned = self.skin.turned_from(front, self.kin.moved);
        stepped.pairs.extend(turned.iter().map(|&f| [f, f]));
        let turned = if turned.is_empty() { stepped } else { self.turned_to_front(stepped, turned) };
        let apart = self.layers_apart(turned);
        let mut best = self.all_apart(apart);
        let faces = &self.kin.child.level().topology.faces;
        let stays = |[face, _]: &[FaceId; 2]| faces.vertices_of(*face).iter().all(|&v| best.steps[v] < UNTANGLED);
        best.pairs.extend(odd.into_iter().filter(stays));
        faces_of(&best.pairs)
    }

    /// The better of a state and one where some faces are turned to the front by small moves.
    fn turned_to_front(&mut self, stepped: Tried, turned: Vec<FaceId>) -> Tried {
        let beside = self.with_areas(self.beside(&turned, &turned));
        let wanted = Wanted { turned: self.with_areas(turned), beside, moves_both: true, ..Wanted::default() };
        self.better(stepped, &wanted)
    }

    /// The better of a state and one where the second layer is moved away from where it crosses the first, and where the
    /// strip between them is folded.
    fn layers_apart(&mut self, stepped: Tried) -> Tried {
        if stepped.pairs.is_empty() {
            return stepped;
        }
        let mut over: IdVec<VertexId, VertexId> = self.states.linear.ids().collect();
        self.kin.pairs.iter().for_each(|&[vertex, copy]| over[copy] = vertex);
        let (crossing, folded) = (self.crossing_layers(&stepped, &over), self.folded_strips(&stepped, &over));
        if folded.is_empty() && crossing.is_empty() {
            return stepped;
        }
        let faces = &self.kin.child.level().topology.faces;
        let layer = |&[face, copy]: &[FaceId; 2]| {
            let step = |&v: &VertexId| self.states.linear[v] - self.states.linear[over[v]];
            let steps: Vec3 = faces.vertices_of(copy).iter().map(step).sum();
            Layer { over: face, copy, gap: APART / LEAST_SHARE / faces.valence(copy) as f32 * steps }
        };
        let around: Vec<FaceId> = faces_of(&crossing).into_iter().chain(folded.iter().copied()).collect();
        let beside = self.with_areas(self.beside(&around, &folded));
        let layers = crossing.iter().map(layer).collect();
        let wanted = Wanted { turned: self.with_areas(folded), beside, layers, ..Wanted::default() };
        self.better(stepped, &wanted)
    }

    /// The best of a state and some where what crosses has stepped back, and is parted, on the second refinement too if that
    /// is looked at.
    fn all_apart(&mut self, mut stepped: Tried) -> Tried {
        if self.kin.ahead.is_some() {
            self.nearness = Some(Nearness::new(&self.skin));
            let all: Vec<FaceId> = self.kin.child.level().topology.faces.ids().collect();
            let found = self.later(&all, &self.points).map_or_else(Vec::new, |found| found.pairs);
            if !found.is_empty() {
                stepped.pairs.extend(found);
                stepped = self.back_later(stepped);
            }
        }
        if stepped.pairs.is_empty() { stepped } else { self.parted(stepped) }
    }

    /// The best of a state and one where what crosses on the second refinement has stepped back.
    fn back_later(&mut self, stepped: Tried) -> Tried {
        self.parted_from = Some(self.points.clone());
        let (mut pairs, mut tried) = (stepped.pairs.clone(), vec![stepped]);
        // All the way at once: each step by itself leaves no less.
        if self.step_to(self.stepped_on(&pairs, STEPS.len() as u8)) {
            self.search(&mut pairs);
            tried.push(Tried { steps: self.steps.clone(), pairs });
        }
        self.best(tried)
    }

    /// The best of a state and some where what crosses is parted by small moves. What is parted may cross others, which are
    /// parted too the next time.
    fn parted(&mut self, stepped: Tried) -> Tried {
        let before = self.points.clone();
        let found = self.later(&self.around(&stepped), &before);
        self.apart = found.map_or_else(Vec::new, |found| found.apart);
        self.parted_from = Some(before.clone());
        let mut tried = vec![stepped];
        while let Some(last) = tried.last().filter(|last| tried.len() <= PARTINGS && !last.pairs.is_empty()) {
            let mut apart = std::mem::take(&mut self.apart);
            apart.extend(apart_now(&self.skin, self.states.linear, &last.pairs));
            if apart.is_empty() {
                break;
            }
            let wanted = Wanted { apart, beside: self.with_areas(self.around(last)), ..Wanted::default() };
            let Untangled { points, moved } = untangled(&self.skin, &before, &wanted, self.kin.pairs);
            self.apart = wanted.apart;
            let next = self.moved_to(&tried[0].steps, &last.pairs, points, &moved);
            let is_better = next.faults() < last.faults();
            tried.push(next);
            if !is_better {
                break;
            }
        }
        self.best(tried)
    }

    /// The faces with a fault and those that touch them.
    fn around(&self, tried: &Tried) -> Vec<FaceId> {
        touching(&self.kin.child.level().topology, &faces_of(&tried.pairs))
    }

    /// What crosses on the second refinement, of some faces; nothing where it is not looked at. It is parted as it was where
    /// the points are `before`.
    pub(super) fn later(&self, faces: &[FaceId], before: &IdVec<VertexId, Vec3>) -> Option<Later> {
        let (LookAhead { before: input, close }, nearness) = (self.kin.ahead.as_ref()?, self.nearness.as_ref()?);
        let is_doubtful = |f: &FaceId| close[*f] || !self.skin.is_even(*f);
        let doubtful: Vec<FaceId> = faces.iter().copied().filter(is_doubtful).collect();
        let close = nearness.close(&self.skin, &doubtful);
        Some(crossing_later(&self.skin, before, &close, input))
    }

    /// Faces of the first layer with those of the second that they cross, of one face of the parent. `over` is what each
    /// vertex is a copy of, itself where it is none.
    fn crossing_layers(&self, tried: &Tried, over: &IdVec<VertexId, VertexId>) -> Vec<[FaceId; 2]> {
        let faces = &self.kin.child.level().topology.faces;
        let is_layer = |face: FaceId| faces.vertices_of(face).iter().all(|&v| over[v] != v);
        let parent = |face: FaceId| self.kin.derivation.parent_face(face);
        let of_one = tried.pairs.iter().filter(|[f, g]| f != g && parent(*f) == parent(*g));
        let layers = of_one.filter_map(|&[f, g]| match [f, g].map(is_layer) {
            [true, false] => Some([g, f]),
            [false, true] => Some([f, g]),
            _ => None,
        });
        layers.collect()
    }

    /// Faces between the layers that are turned over, in their order.
    fn folded_strips(&self, tried: &Tried, over: &IdVec<VertexId, VertexId>) -> Vec<FaceId> {
        let faces = &self.kin.child.level().topology.faces;
        let is_strip = |f: &FaceId| {
            let copies = faces.vertices_of(*f).iter().filter(|&&v| over[v] != v).count();
            0 < copies && copies < faces.valence(*f) && self.kin.front[*f] == Vec3::ZERO
        };
        let turned = tried.pairs.iter().filter(|[f, g]| f == g).map(|pair| pair[0]);
        each_once(turned.filter(is_strip).collect())
    }

    /// Faces that touch some, but for those that are turned.
    fn beside(&self, faces: &[FaceId], turned: &[FaceId]) -> Vec<FaceId> {
        let mut beside = touching(&self.kin.child.level().topology, faces);
        beside.retain(|face| turned.binary_search(face).is_err());
        beside
    }

    /// Faces with twice the areas that they have by the weights alone, to the side where they are to look.
    fn with_areas(&self, faces: Vec<FaceId>) -> Vec<(FaceId, Vec3)> {
        let (all, front) = (&self.kin.child.level().topology.faces, self.kin.front);
        let area = |face: FaceId| {
            let direction = if front[face] == Vec3::ZERO { self.skin.look(face) } else { front[face] };
            twice_area(all.vertices_of(face), self.states.linear).length() * direction
        };
        faces.into_iter().map(|face| (face, area(face))).collect()
    }

    /// The better of a state and one where points are moved to what is wanted, each part by itself.
    fn better(&mut self, stepped: Tried, wanted: &Wanted) -> Tried {
        let Untangled { points, moved } = untangled(&self.skin, &self.points, wanted, self.kin.pairs);
        let next = self.moved_to(&stepped.steps, &stepped.pairs, points, &moved);
        self.best(vec![stepped, next])
    }

    /// A state where some vertices of another are at these points. `pairs` were found in the last state.
    fn moved_to(
        &mut self,
        steps: &IdVec<VertexId, u8>,
        pairs: &[[FaceId; 2]],
        points: IdVec<VertexId, Vec3>,
        moved: &[VertexId],
    ) -> Tried {
        let step = UNTANGLED + self.untangled.len() as u8;
        self.untangled.push(points);
        let (mut steps, mut pairs) = (steps.clone(), pairs.to_vec());
        moved.iter().for_each(|&vertex| steps[vertex] = step);
        self.step_to(steps.clone());
        self.search(&mut pairs);
        Tried { steps, pairs }
    }
}
