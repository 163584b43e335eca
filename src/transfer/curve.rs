//! Paths of edges of the simulation mesh along curves of the baseline.
//!
//! The mesh knows nothing of these curves, and no path of its edges is as short. In a lattice of equilateral triangles a
//! straight line at the angle φ to the nearest edge direction, 0 to 30 degrees, is followed by edges of two directions,
//! together cos φ + sin φ / √3 times as long: from 1 along edges to 2 / √3, 15 % more, halfway between, and 10 % more on the
//! mean over all angles. What a path has beyond that is reported, by the shortest one between the same ends
//! (`shortestLength`); only moving vertices to the curve, as constraints do, makes it shorter.

use super::snap::Surface;
use crate::mesh::{CornerId, FaceId, Id, IdVec, Topology, VertexId};
use glam::Vec3;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

/// What distance from the curve adds to the length of an edge one target length away, as a share: more follows the curve
/// closer and zigzags, less is shorter and cuts its corners. The first whose path is as long as the curve is taken.
const STRAYS: [f64; 3] = [0.5, 0.125, 0.03];
/// The same for the shortest path that there is.
const STRAIGHT: f64 = 0.0;
/// How much longer or shorter than its curve a path may be, as a share.
const LENGTH_SLACK: f64 = 0.05;
/// What a path must gain in length, as a share of its curve's, to be worth straying farther.
const LENGTH_GAIN: f64 = 0.005;
/// What a vertex costs that a chain or another path of the same set passes, in edges: what is apart on the surface stays
/// apart where it can.
const PASSED: f64 = 20.0;

/// A path on the baseline, to measure distances from.
pub(super) struct Curve {
    segments: Vec<Segment>,
    length: f32,
    pub is_loop: bool,
}

/// A straight piece of a curve.
struct Segment {
    from: Vec3,
    step: Vec3,
    /// 1 over the square of its length.
    inverse: f32,
    /// Length of the curve up to it, and its own. \[stage units\]
    along: f32,
    length: f32,
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
        let mut length = 0.0;
        let segment = |pair: &[VertexId]| {
            let (from, step) = (points[pair[0]], points[pair[1]] - points[pair[0]]);
            let inverse = step.length_squared().max(f32::MIN_POSITIVE).recip();
            let segment = Segment { from, step, inverse, along: length, length: step.length() };
            length += segment.length;
            segment
        };
        let segments = vertices.windows(2).map(segment).collect();
        Self { segments, length, is_loop }
    }

    /// How far along a segment a point is, 0 to 1, and the square of its distance.
    fn on_segment(&self, segment: usize, point: Vec3) -> (f32, f32) {
        let Segment { from, step, inverse, .. } = self.segments[segment];
        let t = ((point - from).dot(step) * inverse).clamp(0.0, 1.0);
        (t, (from + t * step).distance_squared(point))
    }

    /// The nearest place, as far as it can be reached from a segment by ever nearer ones, a few at a time.
    pub fn nearest(&self, point: Vec3, start: usize) -> OnCurve {
        const STEPS: usize = 3;
        let n = self.segments.len();
        let start = start.min(n - 1);
        let (mut best, mut at) = (self.on_segment(start, point), start);
        // Segments around the first that were looked at: so many ahead and so many behind.
        let mut seen = [0, 0];
        let mut reach = [STEPS; 2];
        while seen != reach {
            for way in 0..2 {
                while seen[way] < reach[way] {
                    seen[way] += 1;
                    let Some(other) = self.step(start, seen[way], way == 0) else { continue };
                    let there = self.on_segment(other, point);
                    if there.1 < best.1 {
                        (best, at) = (there, other);
                        reach[way] = (seen[way] + STEPS).min(n);
                    }
                }
            }
        }
        let segment = &self.segments[at];
        OnCurve { segment: at, s: segment.along + best.0 * segment.length, distance: best.1.sqrt() }
    }

    /// The segment some steps ahead of one, or behind it; loops go round, paths end.
    fn step(&self, from: usize, steps: usize, is_ahead: bool) -> Option<usize> {
        let n = self.segments.len();
        match (self.is_loop, is_ahead) {
            (true, true) => Some((from + steps) % n),
            (true, false) => Some((from + n - steps % n) % n),
            (false, true) => Some(from + steps).filter(|&k| k < n),
            (false, false) => from.checked_sub(steps),
        }
    }
}

/// The vertices of the simulation mesh beside a curve, on the same part of the surface, by their place in a list.
pub(super) struct Corridor {
    /// Length of the curve. \[stage units\]
    length: f32,
    is_loop: bool,
    /// Ascending by vertex.
    vertices: Vec<Beside>,
    /// What leaves each vertex: from its number here to the next one's.
    first: Vec<usize>,
    /// The edges inside the corridor.
    edges: Vec<Edge>,
}

/// An edge that leaves a vertex beside a curve.
struct Edge {
    /// The other end, by its place in the corridor's list.
    to: u32,
    /// Mean distance of its ends from the curve, squared, in target lengths.
    off: f32,
    /// Its length. \[stage units\]
    length: f64,
}

/// A vertex beside a curve.
struct Beside {
    vertex: VertexId,
    on: OnCurve,
    /// Distance from the curve, in target lengths.
    off: f32,
    is_constrained: bool,
}

impl Edge {
    fn new(surface: &Surface<'_>, a: &Beside, b: &Beside, to: u32) -> Self {
        let points = &surface.product.points;
        let off = 0.5 * (a.off + b.off);
        Self { to, off: off * off, length: f64::from(points[a.vertex].distance(points[b.vertex])) }
    }

    fn cost(&self, stray: f64) -> f64 {
        self.length * (1.0 + stray * f64::from(self.off))
    }
}

/// What a path is asked for.
struct Way<'a> {
    from: usize,
    to: usize,
    stray: f64,
    /// Whether it may be the edge between its ends alone.
    is_direct: bool,
    passed: &'a [bool],
}

/// A path along a curve.
pub(super) struct Found {
    pub vertices: Vec<VertexId>,
    /// Largest distance of a vertex from the curve, in local target lengths.
    pub farthest: f32,
    /// Its length; where that is farther from the curve's than it may be, that of the shortest path in the corridor
    /// between the same ends. \[stage units\]
    pub shortest: f64,
}

impl Found {
    /// Its vertices without its ends; of a loop, which has none, all.
    pub fn inner(&self, is_loop: bool) -> &[VertexId] {
        &self.vertices[1..self.vertices.len() - usize::from(!is_loop)]
    }
}

/// Marks of elements that are all taken away at once.
struct Marks<I, T> {
    of: IdVec<I, (u32, T)>,
    now: u32,
}

impl<I: Id, T: Copy> Marks<I, T> {
    fn new(count: usize, filler: T) -> Self {
        Self { of: IdVec::filled((0, filler), count), now: 0 }
    }

    fn clear(&mut self) {
        self.now += 1;
    }

    fn get(&self, id: I) -> Option<T> {
        let (when, mark) = self.of[id];
        (when == self.now).then_some(mark)
    }

    fn set(&mut self, id: I, mark: T) {
        self.of[id] = (self.now, mark);
    }
}

/// What finding corridors marks on the way.
pub(super) struct Scratch {
    /// Triangles of the baseline that were reached, and whether they are in the corridor.
    faces: Marks<FaceId, bool>,
    /// The places in the corridor's list of the vertices of the simulation mesh.
    vertices: Marks<VertexId, u32>,
    queue: VecDeque<(FaceId, usize)>,
}

impl Scratch {
    pub fn new(surface: &Surface<'_>) -> Self {
        let faces = Marks::new(surface.product.baseline.topology.faces.len(), false);
        Self { faces, vertices: Marks::new(surface.product.points.len(), 0), queue: VecDeque::new() }
    }
}

/// Vertices that the way to a closed path and back may not have in common, before it is left as it is.
const MAX_AVOIDED: usize = 3;

/// Ways around a closed curve: none, or once in either direction.
const ROUNDS: usize = 3;

/// The least cost of a state, and the one before it.
type Best = (f64, u32);
/// The state before the first.
const NOWHERE: u32 = u32::MAX;

impl Corridor {
    /// Those at most `reach` target lengths from the curve, along `path` on the baseline.
    pub fn new(
        surface: &Surface<'_>,
        t: &Topology,
        (curve, path): (&Curve, &[VertexId]),
        reach: f32,
        scratch: &mut Scratch,
    ) -> Self {
        let near = beside(surface, curve, path, reach, scratch);
        let beside = |(vertex, on): (VertexId, OnCurve)| Beside {
            vertex,
            on,
            off: on.distance / surface.product.target[vertex],
            is_constrained: surface.is_constrained[vertex],
        };
        let mut vertices: Vec<Beside> = near.into_iter().map(beside).collect();
        vertices.sort_unstable_by_key(|v| v.vertex);
        vertices.iter().enumerate().for_each(|(i, v)| scratch.vertices.set(v.vertex, i as u32));
        let is_inside = |c: CornerId| scratch.faces.get(surface.product.places[c].location.face) == Some(true);
        let (mut first, mut edges) = (vec![0], Vec::<Edge>::with_capacity(6 * vertices.len()));
        for beside in &vertices {
            let own = edges.len();
            for &corner in t.vertex_corners.row(beside.vertex).iter().filter(|&&c| is_inside(c)) {
                let around = [t.faces.next(corner), t.faces.prev(corner)].into_iter().filter(|&c| is_inside(c));
                for to in around.filter_map(|c| scratch.vertices.get(t.faces.vertex(c))) {
                    if edges[own..].iter().all(|e| e.to != to) {
                        edges.push(Edge::new(surface, beside, &vertices[to as usize], to));
                    }
                }
            }
            first.push(edges.len());
        }
        Self { length: curve.length, is_loop: curve.is_loop, vertices, first, edges }
    }

    /// Which vertices a chain or another path of the same set passes, where `is_passed` says so of the paths.
    pub fn passed(&self, is_passed: impl Fn(VertexId) -> bool) -> Vec<bool> {
        self.vertices.iter().map(|v| v.is_constrained || is_passed(v.vertex)).collect()
    }

    /// The vertex that is nearest to the curve.
    pub fn nearest(&self, passed: &[bool]) -> Option<VertexId> {
        let key = |(v, &is_passed): (&Beside, &bool)| (is_passed, v.on.distance.to_bits(), v.vertex);
        self.vertices.iter().zip(passed).map(key).min().map(|k| k.2)
    }

    /// The path between two vertices that follows the curve closest of those that are as long as it, or as near to that
    /// as edges can come; once round a closed curve from a vertex to itself. None of fewer than `least` vertices.
    pub fn best_path(&self, [from, to]: [VertexId; 2], least: usize, passed: &[bool]) -> Option<Found> {
        let wanted = f64::from(self.length);
        let off = |length: f64| ((length - wanted).abs() - LENGTH_SLACK * wanted).max(0.0);
        let number = |v: VertexId| self.vertices.binary_search_by_key(&v, |b| b.vertex).ok();
        let (from, to) = (number(from)?, number(to)?);
        let path = |stray: f64| {
            let way = Way { from, to, stray, is_direct: least <= 2, passed };
            let path = self.path_through(&way).filter(|p| p.len() >= least)?;
            Some((path.windows(2).map(|p| self.distance(p[0], p[1])).sum(), path))
        };
        let mut paths: Vec<(f64, Vec<usize>)> = path(STRAYS[0]).into_iter().collect();
        let is_found = |paths: &[(f64, _)]| paths.last().is_some_and(|p| off(p.0) == 0.0);
        if !is_found(&paths) {
            let straight = path(STRAIGHT);
            // What lies between two that hardly differ is no better.
            let hardly = |straight: &(f64, _)| paths.first().is_some_and(|p| p.0 - straight.0 <= LENGTH_GAIN * wanted);
            let rest = if straight.as_ref().is_some_and(hardly) { &[] } else { &STRAYS[1..] };
            for &stray in rest {
                if !is_found(&paths) {
                    paths.extend(path(stray));
                }
            }
            paths.extend(straight);
        }
        let least_off = paths.iter().map(|p| off(p.0)).fold(f64::MAX, f64::min);
        let gain = if least_off > 0.0 { LENGTH_GAIN * wanted } else { 0.0 };
        let shortest = paths.iter().map(|p| p.0).fold(f64::MAX, f64::min);
        let best = paths.into_iter().find(|p| off(p.0) <= least_off + gain);
        best.map(|(length, path)| Found {
            farthest: path.iter().map(|&i| self.vertices[i].off).fold(0.0, f32::max),
            vertices: path.into_iter().map(|i| self.vertices[i].vertex).collect(),
            shortest: if off(length) > 0.0 { shortest } else { length },
        })
    }

    fn distance(&self, a: usize, b: usize) -> f64 {
        let mut edges = self.edges[self.first[a]..self.first[a + 1]].iter();
        edges.find(|e| e.to as usize == b).map_or(0.0, |e| e.length)
    }

    /// Whether a step goes over the place where a closed curve begins: backwards, not, or forwards, from 0 to 2.
    fn turn(&self, a: usize, b: usize) -> usize {
        let (step, half) = (self.vertices[b].on.s - self.vertices[a].on.s, 0.5 * self.length);
        match self.is_loop {
            true if step < -half => 2,
            true if step > half => 0,
            _ => 1,
        }
    }

    /// The cheapest path; round a closed curve one that begins and ends where it is asked to, if there is one: others
    /// may meet it there.
    fn path_through(&self, way: &Way<'_>) -> Option<Vec<usize>> {
        let mut avoided = Vec::new();
        loop {
            let path = self.path(way, &avoided)?;
            if path[0] == way.from || avoided.len() == MAX_AVOIDED {
                return Some(path);
            }
            // The way there and the way back had this vertex in common.
            avoided.push(path[0]);
        }
    }

    /// The cheapest path, from its first vertex to its last.
    fn path(&self, way: &Way<'_>, avoided: &[usize]) -> Option<Vec<usize>> {
        let Way { from, to, stray, is_direct, passed } = *way;
        // A state is a vertex and how often the way there has gone round a closed curve: once back, not, or once.
        let rounds = self.rounds();
        let (start, goal) = (from * rounds + rounds / 2, to * rounds + rounds - 1);
        let mut best: Vec<Best> = vec![(f64::INFINITY, NOWHERE); rounds * self.vertices.len()];
        best[start].0 = 0.0;
        // Costs are not negative, so that their bits are in their order.
        let mut queue = BinaryHeap::from([Reverse((0u64, start as u32))]);
        while let Some(Reverse((bits, state))) = queue.pop() {
            let (cost, here, turns) = (f64::from_bits(bits), state as usize / rounds, state as usize % rounds);
            if state as usize == goal {
                return Some(self.trace(&best, goal));
            }
            if cost > best[state as usize].0 {
                continue;
            }
            for edge in &self.edges[self.first[here]..self.first[here + 1]] {
                let there = edge.to as usize;
                if !is_direct && here == from && there == to {
                    continue;
                }
                let Some(turns) = (turns + self.turn(here, there)).checked_sub(1).filter(|r| *r < rounds) else {
                    continue;
                };
                let is_passed = passed[there] || avoided.contains(&there);
                let is_passed = is_passed && there != to && there != from;
                let sum = cost + edge.cost(stray) * if is_passed { PASSED } else { 1.0 };
                let next = there * rounds + turns;
                if sum < best[next].0 {
                    best[next] = (sum, state);
                    queue.push(Reverse((sum.to_bits(), next as u32)));
                }
            }
        }
        None
    }

    /// How many states a vertex has.
    fn rounds(&self) -> usize {
        if self.is_loop { ROUNDS } else { 1 }
    }

    /// The way to a state; of one round a closed curve only the round, without what leads to it.
    fn trace(&self, best: &[Best], goal: usize) -> Vec<usize> {
        let mut states = vec![goal];
        while let Some(&(_, before)) = states.last().map(|&s| &best[s]).filter(|b| b.1 != NOWHERE) {
            states.push(before as usize);
        }
        states.reverse();
        let rounds = self.rounds();
        let mut path: Vec<usize> = Vec::with_capacity(states.len());
        for state in states {
            if let Some(first) = path.iter().position(|s| s / rounds == state / rounds) {
                if self.is_loop && path[first] != state {
                    path.push(state);
                    return path[first..].iter().map(|s| s / rounds).collect();
                }
                path.truncate(first);
            }
            path.push(state);
        }
        path.into_iter().map(|s| s / rounds).collect()
    }
}

/// Marks the triangles of the baseline at most `reach` target lengths from a curve on the same part of the surface. Returns
/// the vertices of the simulation mesh in them that are no farther.
fn beside(
    surface: &Surface<'_>,
    curve: &Curve,
    path: &[VertexId],
    reach: f32,
    scratch: &mut Scratch,
) -> Vec<(VertexId, OnCurve)> {
    let product = surface.product;
    let base = &product.baseline;
    let t = &base.topology;
    let Scratch { faces, vertices, queue } = scratch;
    faces.clear();
    vertices.clear();
    let mut found: Vec<(VertexId, OnCurve)> = Vec::new();
    for (segment, pair) in path.windows(2).enumerate() {
        for half in [(pair[0], pair[1]), (pair[1], pair[0])].into_iter().filter_map(|(a, b)| half_edge(t, a, b)) {
            let face = t.faces.face_of(half);
            if faces.get(face).is_none() {
                faces.set(face, false);
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
        faces.set(face, true);
        for &vertex in surface.in_face.row(face) {
            let on = curve.nearest(product.points[vertex], on.segment);
            if on.distance <= reach * product.target[vertex] {
                match vertices.get(vertex) {
                    None => {
                        vertices.set(vertex, found.len() as u32);
                        found.push((vertex, on));
                    }
                    Some(i) if on.distance < found[i as usize].1.distance => found[i as usize].1 = on,
                    Some(_) => {}
                }
            }
        }
        for corner in t.faces.corners_of(face) {
            if let Some(other) = base.open_twin(corner).map(|c| t.faces.face_of(c))
                && faces.get(other).is_none()
            {
                faces.set(other, false);
                queue.push_back((other, on.segment));
            }
        }
    }
    found
}

fn half_edge(t: &Topology, a: VertexId, b: VertexId) -> Option<CornerId> {
    t.vertex_corners.row(a).iter().copied().find(|&c| t.faces.vertex(t.faces.next(c)) == b)
}
