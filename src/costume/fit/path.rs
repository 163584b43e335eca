//! The way from one body to the other, in steps after which nothing new crosses.
//!
//! A step begins where nothing new crosses, with the body already in its next shape. What is near is held apart along the directions
//! that it has there. Triangles that cross nevertheless are held apart as wholes; if that does not help, the step is cut.

use super::bodies::Bodies;
use super::bound::BoundPoints;
use super::cage::Cage;
use super::clearance::Clearance;
use super::contacts::apart;
use super::crossings::{CrossingFaces, Crossings};
use super::rigid::{Goal, Limit, RigidCage};
use super::stretch::{Frame, Surroundings};
use super::{FitOptions, SEARCH_PART, work_limit};
use glam::{DQuat, DVec3};
use tailor::contact::WorkLimit;
use tailor_mesh::meter;

/// Steps of the whole way, and how often one of them may be cut in half.
const STEPS: usize = 8;
const MOST_CUTS: i32 = 6;
/// Rounds of the solver in the last shape.
const LAST_ROUNDS: usize = 8;
/// How often what has crossed is held apart.
const TRIES: usize = 6;
/// How often faces that cannot follow are let go, so that the others can.
const MOST_RELEASED: usize = 8;
/// Pull of a point to where its place on the body went, against the pull of an edge, and the share of the body's size at which it
/// is half of that.
const PULL: f64 = 0.1;
const FAR: f64 = 0.015;
/// From so many times that distance on, a point hangs: it goes where the body as a whole does there, and wholly from twice that on.
const HANGING: f64 = 2.0;

/// A garment on its way.
pub struct Path<'a> {
    pub cage: &'a Cage,
    pub rest: &'a [DVec3],
    pub bodies: &'a Bodies,
    pub bound: BoundPoints<'a>,
    pub clearance: Clearance<'a>,
    surroundings: Surroundings,
    /// How far each point hangs, from 0 to 1.
    hang: Vec<f64>,
    /// The work of the searches at the start.
    pub start: WorkLimit,
    /// The work of the steps.
    pub work: WorkLimit,
    rigid: RigidCage<'a>,
    /// What crossed in the last try of a step.
    pub stuck: CrossingFaces,
    released: usize,
    /// The share of the way that it went.
    pub share: f64,
    /// The points at shares of the way.
    pub steps: Vec<(f64, Vec<DVec3>)>,
}

/// A garment at a share of the way.
#[derive(Clone)]
struct State {
    share: f64,
    points: Vec<DVec3>,
    turns: Vec<DQuat>,
}

impl<'a> Path<'a> {
    /// A garment at the start, which is incomplete beyond the bound of its searches.
    pub fn new(cage: &'a Cage, rest: &'a [DVec3], bodies: &'a Bodies, options: &FitOptions) -> Self {
        let [start, work] = [SEARCH_PART, 1].map(|part| work_limit(cage, bodies, part));
        let bound = BoundPoints::new(bodies, &bodies.from, rest);
        let far = FAR * bodies.size().max(f64::MIN_POSITIVE);
        let pull = bound.distances().map(|distance| PULL / (1.0 + (distance / far).powi(2))).collect();
        let hanging = bound.distances().map(|distance| (distance / far - HANGING).max(0.0));
        let places: Vec<(usize, f64)> = bound.vertices().into_iter().zip(hanging).collect();
        Self {
            cage,
            rest,
            bodies,
            clearance: Clearance::new(cage, rest, bodies, &start),
            surroundings: Surroundings::new(bodies, &places, &start),
            hang: places.iter().map(|(_, hanging)| (0.5 * hanging).min(1.0)).collect(),
            rigid: RigidCage::new(cage, rest, pull, options),
            start,
            work,
            bound,
            stuck: CrossingFaces::default(),
            released: 0,
            share: 0.0,
            steps: Vec::new(),
        }
    }

    /// The points at the end of the way, or as far as the bound of work allows.
    pub fn run(&mut self) -> Vec<DVec3> {
        let mut state = State { share: 0.0, points: self.rest.to_vec(), turns: vec![DQuat::IDENTITY; self.rest.len()] };
        // Whole numbers, so that the end is met.
        let unit = STEPS << MOST_CUTS;
        let (mut at, mut step) = (0, 1 << MOST_CUTS);
        self.steps = vec![(0.0, state.points.clone())];
        while at < unit && !self.work.is_over() {
            // With half of the work left, faces that cannot follow are let go at once, so that the others arrive.
            let is_late = self.work.left() < self.work.spent();
            let next = (at + step).min(unit);
            let shape_share = next as f64 / unit as f64;
            let rounds = if next == unit { LAST_ROUNDS } else { 1 };
            match self.step(&state, shape_share, rounds) {
                Some(moved) => {
                    (state, at) = (moved, next);
                    self.steps.push((shape_share, state.points.clone()));
                    step = (2 * step).min(1 << MOST_CUTS);
                }
                None if step > 1 && !is_late => step /= 2,
                None if self.released < MOST_RELEASED || is_late => {
                    self.released += 1;
                    self.clearance.release(std::mem::take(&mut self.stuck));
                }
                None => break,
            }
        }
        self.share = at as f64 / unit as f64;
        self.rigid.snap(&mut state.points);
        if let Some((_, last)) = self.steps.last_mut() {
            last.clone_from(&state.points);
        }
        state.points
    }

    /// The edges as a shape of the body stretches them, before their ends turn.
    pub fn stretched_edges(&self, shape: &[DVec3]) -> Vec<DVec3> {
        self.stretched(&self.surroundings.frames(&self.bodies.from, shape))
    }

    fn stretched(&self, frames: &[Frame]) -> Vec<DVec3> {
        let mean = |[a, b]: [usize; 2]| (frames[a].stretch + frames[b].stretch) * 0.5;
        self.cage.edges.iter().map(|&[a, b]| mean([a, b]) * (self.rest[a] - self.rest[b])).collect()
    }

    /// Where each point is drawn: with its place on the body, and with the body around it where it hangs.
    fn targets(&self, frames: &[Frame], shape: &[DVec3]) -> Vec<DVec3> {
        let of = |(v, on_skin): (usize, DVec3)| on_skin.lerp(frames[v].carried(self.rest[v]), self.hang[v]);
        self.bound.carried(shape).into_iter().enumerate().map(of).collect()
    }

    /// The garment when the body has its shape at `share`; none if something new crosses.
    fn step(&mut self, from: &State, share: f64, rounds: usize) -> Option<State> {
        let shape = self.bodies.shape(share);
        let frames = self.surroundings.frames(&self.bodies.from, &shape);
        let (targets, edges) = (self.targets(&frames, &shape), self.rigid.kept(self.stretched(&frames)));
        let scale = self.scale(&edges);
        let mut state = from.clone();
        for round in 0..rounds {
            let body = if round == 0 { self.bodies.shape(from.share) } else { shape.clone() };
            let mut moved = State { share, ..state.clone() };
            self.rigid.turns(&edges, &state.points, &mut moved.turns);
            let goal = |limits| Goal { targets: &targets, edges: &edges, limits };
            match self.solved(&moved, &body, &shape, scale, goal) {
                Some(points) => state = State { points, ..moved },
                None if round == 0 => return None,
                None => break,
            }
        }
        Some(state)
    }

    /// The points that a goal asks for with nothing new crossing, from a state beside `body`.
    fn solved<'g>(
        &mut self,
        state: &State,
        body: &[DVec3],
        shape: &[DVec3],
        scale: f64,
        goal: impl Fn(Vec<Limit>) -> Goal<'g>,
    ) -> Option<Vec<DVec3>> {
        let (before, after) = ([&state.points[..], body].concat(), [&state.points[..], shape].concat());
        let contacts = self.clearance.contacts(&before, scale, &self.work);
        let mut held = Vec::new();
        for _ in 0..TRIES {
            meter::check();
            let mut limits = self.clearance.limits(&contacts, shape, scale);
            limits.extend_from_slice(&held);
            let goal = goal(limits);
            let mut points = state.points.clone();
            self.rigid.solve(&goal, &state.turns, &mut points, &self.work);
            let found = self.clearance.held_crossings(&points, shape, &self.work);
            if self.work.is_over() {
                return None;
            }
            if found.is_empty() {
                return Some(points);
            }
            self.stuck = found.faces(self.cage);
            self.clearance.squeeze(&goal.limits, &points);
            self.hold_apart(&found, &before, &after, &mut held);
        }
        None
    }

    /// Adds what keeps triangles apart that have crossed.
    fn hold_apart(&self, found: &Crossings, before: &[DVec3], after: &[DVec3], held: &mut Vec<Limit>) {
        let (count, triangle) = (self.rest.len(), |t: usize| self.cage.triangles[t]);
        for &[t, b] in &found.body {
            let pair = [triangle(t), self.clearance.body.triangles[b]];
            held.extend(apart(pair, before, after, count, self.clearance.least_of(t)));
        }
        for &[a, b] in &found.own {
            let least = self.clearance.least_of(a).min(self.clearance.least_of(b));
            held.extend(apart([triangle(a), triangle(b)], before, after, count, least));
        }
    }

    /// The mean change of the lengths of edges.
    fn scale(&self, edges: &[DVec3]) -> f64 {
        let own: f64 = self.cage.edges.iter().map(|&[a, b]| self.rest[a].distance(self.rest[b])).sum();
        let wanted: f64 = edges.iter().map(|edge| edge.length()).sum();
        if own > 0.0 { wanted / own } else { 1.0 }
    }
}
