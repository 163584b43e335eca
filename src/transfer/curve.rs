//! Paths of edges of the simulation mesh along curves of the baseline.

use super::Sites;
use super::snap::Surface;
use crate::mesh::{CornerId, FaceId, Id, IdVec, VertexId};
use glam::Vec3;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

/// What distance from the curve adds to the length of an edge one target length away, as a share: more follows the curve
/// closer and zigzags, less is shorter and cuts its corners. The first whose path is as long as the curve is taken, and
/// the last finds the shortest path that there is.
const STRAYS: [f64; 4] = [0.5, 0.125, 0.03, 0.0];
/// How much longer or shorter than its curve a path may be, as a share.
const LENGTH_SLACK: f64 = 0.05;
/// What a path must gain in length, as a share of its curve's, to be worth straying farther.
const LENGTH_GAIN: f64 = 0.005;
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

/// The vertices of the simulation mesh beside a curve, on the same part of the surface, by their place in a list.
pub(super) struct Corridor<'a> {
    surface: &'a Surface<'a>,
    curve: &'a Curve,
    /// Ascending by vertex.
    vertices: Vec<Beside>,
    /// What leaves each vertex: from its number here to the next one's.
    first: Vec<usize>,
    /// The other ends of the edges inside the corridor.
    ends: Vec<usize>,
}

/// A vertex beside a curve.
struct Beside {
    vertex: VertexId,
    on: OnCurve,
    /// Distance from the curve, in target lengths.
    off: f32,
    /// Whether a chain or another path of the same set passes here.
    is_passed: bool,
}

/// A path along a curve.
#[derive(Clone)]
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

impl<'a> Corridor<'a> {
    /// Those at most `reach` target lengths from the curve, along `path` on the baseline; `is_passed` are those of other
    /// paths.
    pub fn new(
        surface: &'a Surface<'a>,
        sites: &Sites<'_>,
        (curve, path): (&'a Curve, &[VertexId]),
        reach: f32,
        is_passed: impl Fn(VertexId) -> bool,
        scratch: &mut Scratch,
    ) -> Self {
        let near = beside(surface, curve, path, reach, scratch);
        let beside = |(vertex, on): (VertexId, OnCurve)| Beside {
            vertex,
            on,
            off: on.distance / surface.product.target[vertex],
            is_passed: surface.is_constrained[vertex] || is_passed(vertex),
        };
        let mut vertices: Vec<Beside> = near.into_iter().map(beside).collect();
        vertices.sort_unstable_by_key(|v| v.vertex);
        vertices.iter().enumerate().for_each(|(i, v)| scratch.vertices.set(v.vertex, i as u32));
        let t = &sites.net.topology;
        let is_inside = |c: CornerId| scratch.faces.get(surface.product.places[c].location.face) == Some(true);
        let (mut first, mut ends) = (vec![0], Vec::with_capacity(8 * vertices.len()));
        for beside in &vertices {
            for &corner in t.vertex_corners.row(beside.vertex).iter().filter(|&&c| is_inside(c)) {
                let around = [t.faces.next(corner), t.faces.prev(corner)].into_iter().filter(|&c| is_inside(c));
                ends.extend(around.filter_map(|c| scratch.vertices.get(t.faces.vertex(c))).map(|i| i as usize));
            }
            first.push(ends.len());
        }
        Self { surface, curve, vertices, first, ends }
    }

    /// The vertex that is nearest to the curve.
    pub fn nearest(&self) -> Option<VertexId> {
        let key = |v: &Beside| (v.is_passed, v.on.distance.to_bits(), v.vertex);
        self.vertices.iter().map(key).min().map(|k| k.2)
    }

    /// The path between two vertices that follows the curve closest of those that are as long as it, or as near to that
    /// as edges can come; once round a closed curve from a vertex to itself. None of fewer than `least` vertices.
    pub fn best_path(&self, from: VertexId, to: VertexId, least: usize) -> Option<Found> {
        let wanted = f64::from(self.curve.length());
        let off = |length: f64| ((length - wanted).abs() - LENGTH_SLACK * wanted).max(0.0);
        let number = |v: VertexId| self.vertices.binary_search_by_key(&v, |b| b.vertex).ok();
        let (from, to) = (number(from)?, number(to)?);
        let mut paths: Vec<(f64, Vec<usize>)> = Vec::with_capacity(STRAYS.len());
        for stray in STRAYS {
            let is_direct = least <= 2;
            let Some(path) = self.path_through(from, to, stray, is_direct).filter(|p| p.len() >= least) else {
                continue;
            };
            let length = path.windows(2).map(|p| self.distance(p[0], p[1])).sum();
            paths.push((length, path));
            if off(length) == 0.0 {
                break;
            }
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
        let [a, b] = [a, b].map(|i| self.surface.product.points[self.vertices[i].vertex]);
        f64::from(a.distance(b))
    }

    fn cost(&self, a: usize, b: usize, stray: f64) -> f64 {
        let off = 0.5 * f64::from(self.vertices[a].off + self.vertices[b].off);
        self.distance(a, b) * (1.0 + stray * off * off)
    }

    /// Whether a step goes over the place where a closed curve begins: backwards, not, or forwards, from 0 to 2.
    fn turn(&self, a: usize, b: usize) -> usize {
        let (step, half) = (self.vertices[b].on.s - self.vertices[a].on.s, 0.5 * self.curve.length());
        match self.curve.is_loop {
            true if step < -half => 2,
            true if step > half => 0,
            _ => 1,
        }
    }

    /// The cheapest path; round a closed curve one that begins and ends where it is asked to, if there is one: others
    /// may meet it there.
    fn path_through(&self, from: usize, to: usize, stray: f64, is_direct: bool) -> Option<Vec<usize>> {
        let mut avoided = Vec::new();
        loop {
            let path = self.path(from, to, stray, is_direct, &avoided)?;
            if path[0] == from || avoided.len() == MAX_AVOIDED {
                return Some(path);
            }
            // The way there and the way back had this vertex in common.
            avoided.push(path[0]);
        }
    }

    /// The cheapest path, from its first vertex to its last; along the edge between them only if it may be direct.
    fn path(&self, from: usize, to: usize, stray: f64, is_direct: bool, avoided: &[usize]) -> Option<Vec<usize>> {
        // A state is a vertex and how often the way there has gone round the curve; 1 is not at all.
        let (start, goal) = (from * ROUNDS + 1, to * ROUNDS + if self.curve.is_loop { 2 } else { 1 });
        let mut best: Vec<(f64, usize)> = vec![(f64::INFINITY, usize::MAX); ROUNDS * self.vertices.len()];
        best[start].0 = 0.0;
        // Costs are not negative, so that their bits are in their order.
        let mut queue = BinaryHeap::from([Reverse((0u64, start))]);
        while let Some(Reverse((bits, state))) = queue.pop() {
            let (cost, here) = (f64::from_bits(bits), state / ROUNDS);
            if state == goal {
                return Some(self.trace(&best, goal));
            }
            if cost > best[state].0 {
                continue;
            }
            for &there in &self.ends[self.first[here]..self.first[here + 1]] {
                if !is_direct && here == from && there == to {
                    continue;
                }
                let Some(rounds) = (state % ROUNDS + self.turn(here, there)).checked_sub(1).filter(|r| *r < ROUNDS)
                else {
                    continue;
                };
                let is_passed = self.vertices[there].is_passed || avoided.contains(&there);
                let is_passed = is_passed && there != to && there != from;
                let sum = cost + self.cost(here, there, stray) * if is_passed { PASSED } else { 1.0 };
                let next = there * ROUNDS + rounds;
                if sum < best[next].0 {
                    best[next] = (sum, state);
                    queue.push(Reverse((sum.to_bits(), next)));
                }
            }
        }
        None
    }

    /// The way to a state; of one round a closed curve only the round, without what leads to it.
    fn trace(&self, best: &[(f64, usize)], goal: usize) -> Vec<usize> {
        let mut states = vec![goal];
        while let Some(&(_, before)) = states.last().map(|&s| &best[s]).filter(|b| b.1 != usize::MAX) {
            states.push(before);
        }
        states.reverse();
        let mut path: Vec<usize> = Vec::with_capacity(states.len());
        for state in states {
            if let Some(first) = path.iter().position(|s| s / ROUNDS == state / ROUNDS) {
                if self.curve.is_loop && path[first] != state {
                    path.push(state);
                    return path[first..].iter().map(|s| s / ROUNDS).collect();
                }
                path.truncate(first);
            }
            path.push(state);
        }
        path.into_iter().map(|s| s / ROUNDS).collect()
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

fn half_edge(t: &crate::mesh::Topology, a: VertexId, b: VertexId) -> Option<CornerId> {
    t.vertex_corners.row(a).iter().copied().find(|&c| t.faces.vertex(t.faces.next(c)) == b)
}
