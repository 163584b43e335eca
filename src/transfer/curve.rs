//! Paths of edges of the simulation mesh along curves of the baseline.

use super::Sites;
use super::snap::Surface;
use crate::mesh::{CornerId, FaceId, IdVec, VertexId};
use glam::Vec3;
use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap, HashMap, HashSet, VecDeque};

/// What distance from the curve adds to the length of an edge one target length away, as a share: more follows the curve
/// closer and zigzags, less is shorter and cuts its corners.
const STRAY: f64 = 0.25;
/// What a vertex costs that a chain or another path of the same set passes, in edges: what is apart on the surface stays
/// apart where it can.
const PASSED: f64 = 20.0;

/// A path on the baseline, to measure distances from.
pub(super) struct Curve {
    points: Vec<Vec3>,
    /// Length up to each point. \[stage units\]
    along: Vec<f32>,
    pub is_loop: bool,
}

/// The place on a curve that is nearest to a point.
#[derive(Clone, Copy)]
pub(super) struct OnCurve {
    pub segment: usize,
    /// Length up to there. \[stage units\]
    pub s: f32,
    pub distance: f32,
}

impl Curve {
    pub fn new(vertices: &[VertexId], points: &IdVec<VertexId, Vec3>, is_loop: bool) -> Self {
        let points: Vec<Vec3> = vertices.iter().map(|&v| points[v]).collect();
        let mut along = vec![0.0];
        for pair in points.windows(2) {
            along.push(along[along.len() - 1] + pair[0].distance(pair[1]));
        }
        Self { points, along, is_loop }
    }

    pub fn length(&self) -> f32 {
        self.along[self.along.len() - 1]
    }

    pub fn segments(&self) -> usize {
        self.points.len() - 1
    }

    fn on_segment(&self, segment: usize, point: Vec3) -> OnCurve {
        let (a, b) = (self.points[segment], self.points[segment + 1]);
        let t = ((point - a).dot(b - a) / (b - a).length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        let s = self.along[segment] + t * (self.along[segment + 1] - self.along[segment]);
        OnCurve { segment, s, distance: a.lerp(b, t).distance(point) }
    }

    /// The nearest place, as far as it can be reached from a segment by ever nearer ones, a few at a time.
    pub fn nearest(&self, point: Vec3, start: usize) -> OnCurve {
        const STEPS: usize = 3;
        let n = self.segments();
        let mut best = self.on_segment(start.min(n - 1), point);
        loop {
            let here = best;
            for step in 1..=STEPS.min(n - 1) {
                let ahead = here.segment + step;
                let ahead = if self.is_loop { Some(ahead % n) } else { Some(ahead).filter(|&k| k < n) };
                let behind =
                    if self.is_loop { Some((here.segment + n - step) % n) } else { here.segment.checked_sub(step) };
                for other in [ahead, behind].into_iter().flatten() {
                    let there = self.on_segment(other, point);
                    if there.distance < best.distance {
                        best = there;
                    }
                }
            }
            if best.segment == here.segment {
                return best;
            }
        }
    }
}

/// The vertices of the simulation mesh beside a curve, on the same part of the surface.
pub(super) struct Corridor<'a> {
    surface: &'a Surface<'a>,
    sites: &'a Sites<'a>,
    curve: &'a Curve,
    faces: HashSet<FaceId>,
    vertices: HashMap<VertexId, OnCurve>,
}

/// A vertex, and how often the way there has gone round a closed curve.
type State = (VertexId, i8);

impl<'a> Corridor<'a> {
    /// Those at most `reach` target lengths from the curve, whose vertices are `path`.
    pub fn new(
        surface: &'a Surface<'a>,
        sites: &'a Sites<'a>,
        curve: &'a Curve,
        path: &[VertexId],
        reach: f32,
    ) -> Self {
        let base = &surface.product.baseline;
        let t = &base.topology;
        let mut corridor = Self { surface, sites, curve, faces: HashSet::new(), vertices: HashMap::new() };
        let mut queue = VecDeque::new();
        let mut seen = HashSet::new();
        for (segment, pair) in path.windows(2).enumerate() {
            for half in [(pair[0], pair[1]), (pair[1], pair[0])].into_iter().filter_map(|(a, b)| half_edge(t, a, b)) {
                let face = t.faces.face_of(half);
                if seen.insert(face) {
                    queue.push_back((face, segment));
                }
            }
        }
        while let Some((face, hint)) = queue.pop_front() {
            let corners = base.triangle(face);
            let centre = corners.iter().sum::<Vec3>() / 3.0;
            let size = corners.iter().map(|p| p.distance(centre)).fold(0.0, f32::max);
            let target = t.faces.vertices_of(face).iter().map(|&v| base.target[v]).fold(0.0, f32::max);
            let on = curve.nearest(centre, hint);
            if on.distance > reach * target + size {
                continue;
            }
            corridor.faces.insert(face);
            corridor.take_vertices(face, on.segment, reach);
            for corner in t.faces.corners_of(face).filter(|&c| !base.barrier[c]) {
                if let Some(other) = t.twin(corner).map(|c| t.faces.face_of(c))
                    && seen.insert(other)
                {
                    queue.push_back((other, on.segment));
                }
            }
        }
        corridor
    }

    fn take_vertices(&mut self, face: FaceId, hint: usize, reach: f32) {
        let product = self.surface.product;
        for &vertex in self.surface.in_face.row(face) {
            let on = self.curve.nearest(product.points[vertex], hint);
            if on.distance <= reach * product.target[vertex] {
                let own = self.vertices.entry(vertex).or_insert(on);
                if on.distance < own.distance {
                    *own = on;
                }
            }
        }
    }

    /// The vertex that is nearest to the curve.
    pub fn nearest(&self, passed: &BTreeSet<VertexId>) -> Option<VertexId> {
        let is_passed = |v: &VertexId| passed.contains(v) || self.surface.is_constrained[*v];
        let key = |(v, on): (&VertexId, &OnCurve)| (is_passed(v), on.distance.to_bits(), *v);
        self.vertices.iter().map(key).min().map(|k| k.2)
    }

    /// Distance of a vertex from the curve, in target lengths.
    pub fn distance(&self, vertex: VertexId) -> f32 {
        self.vertices.get(&vertex).map_or(f32::MAX, |on| on.distance / self.surface.product.target[vertex])
    }

    /// The neighbours of a vertex across edges inside the corridor.
    fn neighbours(&self, vertex: VertexId) -> impl Iterator<Item = VertexId> + '_ {
        let t = &self.sites.topology;
        let is_inside = |c: CornerId| self.faces.contains(&self.surface.product.places[c].location.face);
        t.vertex_corners.row(vertex).iter().flat_map(move |&corner| {
            let ends = [t.faces.next(corner), t.faces.prev(corner)];
            let own = is_inside(corner);
            ends.into_iter().filter(move |&c| own && is_inside(c)).map(move |c| t.faces.vertex(c))
        })
    }

    fn cost(&self, a: (VertexId, OnCurve), b: (VertexId, OnCurve)) -> f64 {
        let product = self.surface.product;
        let off = f64::from(a.1.distance + b.1.distance) / f64::from(product.target[a.0] + product.target[b.0]);
        f64::from(product.points[a.0].distance(product.points[b.0])) * (1.0 + STRAY * off * off)
    }

    /// Whether a step goes over the place where a closed curve begins: forwards, backwards or not.
    fn turn(&self, a: OnCurve, b: OnCurve) -> i8 {
        let (step, half) = (b.s - a.s, 0.5 * self.curve.length());
        match self.curve.is_loop {
            true if step < -half => 1,
            true if step > half => -1,
            _ => 0,
        }
    }

    /// The cheapest path between two vertices; once round a closed curve from a vertex to itself.
    pub fn path(&self, from: VertexId, to: VertexId, passed: &BTreeSet<VertexId>) -> Option<Vec<VertexId>> {
        if !self.vertices.contains_key(&from) || !self.vertices.contains_key(&to) {
            return None;
        }
        let (start, goal): (State, State) = ((from, 0), (to, i8::from(self.curve.is_loop)));
        let mut best: HashMap<State, (f64, Option<State>)> = HashMap::from([(start, (0.0, None))]);
        // Costs are not negative, so that their bits are in their order.
        let mut queue = BinaryHeap::from([Reverse((0u64, start))]);
        while let Some(Reverse((bits, state))) = queue.pop() {
            let cost = f64::from_bits(bits);
            if state == goal {
                return Some(self.trace(&best, goal));
            }
            if cost > best[&state].0 {
                continue;
            }
            let here = (state.0, self.vertices[&state.0]);
            for vertex in self.neighbours(state.0) {
                let Some(&on) = self.vertices.get(&vertex) else { continue };
                let next = (vertex, state.1 + self.turn(here.1, on));
                let is_passed =
                    (passed.contains(&vertex) || self.surface.is_constrained[vertex]) && vertex != to && vertex != from;
                let step = self.cost(here, (vertex, on)) * if is_passed { PASSED } else { 1.0 };
                if next.1.abs() <= 1 && best.get(&next).is_none_or(|b| cost + step < b.0) {
                    best.insert(next, (cost + step, Some(state)));
                    queue.push(Reverse(((cost + step).to_bits(), next)));
                }
            }
        }
        None
    }

    /// The way to a state; of one round a closed curve only the round, without what leads to it.
    fn trace(&self, best: &HashMap<State, (f64, Option<State>)>, goal: State) -> Vec<VertexId> {
        let mut states = vec![goal];
        while let Some(Some(before)) = best.get(&states[states.len() - 1]).map(|b| b.1) {
            states.push(before);
        }
        states.reverse();
        let mut path: Vec<State> = Vec::with_capacity(states.len());
        for state in states {
            if let Some(first) = path.iter().position(|s| s.0 == state.0) {
                if self.curve.is_loop && path[first].1 != state.1 {
                    path.push(state);
                    return path[first..].iter().map(|s| s.0).collect();
                }
                path.truncate(first);
            }
            path.push(state);
        }
        path.into_iter().map(|s| s.0).collect()
    }
}

fn half_edge(t: &crate::mesh::Topology, a: VertexId, b: VertexId) -> Option<CornerId> {
    t.vertex_corners.row(a).iter().copied().find(|&c| t.faces.vertex(t.faces.next(c)) == b)
}
