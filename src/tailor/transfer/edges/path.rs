//! Paths of edges along curves: the cheapest way through the vertices around the samples of a curve, in their order
//! (Viterbi 1967, as in map matching).
//!
//! The mesh is remeshed without these curves, so paths of its edges are longer than they are. In a lattice of
//! equilateral triangles, a line at the angle φ to the nearest edge direction, 0 to 30 degrees, is followed by edges of
//! two directions. Together they are cos φ + sin φ / √3 times as long: from 1 along edges to 2 / √3 halfway between,
//! 1.10 on the mean. Only constraints, which move vertices to the curve, make it shorter.

use super::EdgeTransfer;
use super::guide::Guide;
use crate::sim::{distance_to_segment, half_edge};
use glam::Vec3;
use rustc_hash::{FxHashMap, FxHashSet};
use tailor_mesh::connectivity::{FaceId, VertexId};

/// Samples of a curve in each target length: fewer miss triangles whose corner the curve cuts.
const SAMPLES: f32 = 4.0;
/// Most samples between two vertices of the baseline.
const MAX_SAMPLES: f32 = 4096.0;
/// Relative cost of an edge one target length off the curve, beyond its length: more follows the curve closer and
/// zigzags, less is shorter and cuts its corners.
const STRAY: f32 = 1.0;
/// Distance from the curve up to which a path may go, in target lengths.
const REACH: f32 = 0.5;
/// Cost factor of edges to vertices out of reach.
const BEYOND: f32 = 4.0;
/// Cost factor of edges to vertices on a chain or on another path of the set: more keeps curves apart on longer ways.
const OCCUPIED: f32 = 20.0;

/// A path along a curve.
pub(super) struct EdgePath {
    pub vertices: Vec<VertexId>,
    /// Largest distance of a vertex from the curve, in local target lengths.
    pub farthest: f32,
}

/// A vertex around a sample, with the cheapest way there.
struct State {
    vertex: VertexId,
    cost: f32,
    /// The state before it.
    from: usize,
}

/// A search for the paths of one set, in their order. A path avoids those before it.
pub(super) struct PathSearch<'a> {
    pub edges: &'a EdgeTransfer<'a>,
    /// Vertices at ends, on chains and borders of the set, and on paths that are found.
    pub used: FxHashSet<VertexId>,
    /// Number of states of all searches.
    pub visited: usize,
}

impl PathSearch<'_> {
    /// The path along a guide, from and to one of the vertices of each end; once around if the guide is closed.
    pub fn find(&mut self, guide: &Guide, ends: [&[VertexId]; 2]) -> Option<EdgePath> {
        let samples = self.samples(guide);
        let off = self.offsets(&samples);
        let factor = |v: VertexId| {
            let own = off.get(&v).copied().unwrap_or(0.0);
            (1.0 + STRAY * own * own) * if own > REACH { BEYOND } else { 1.0 }
        };
        let own = ends.concat();
        let is_free = |v| own.contains(&v) || !(self.used.contains(&v) || self.edges.is_constrained[v]);
        let start = |(from, &vertex): (usize, &VertexId)| State { vertex, cost: 0.0, from };
        let mut states: Vec<State> = ends[0].iter().enumerate().map(start).collect();
        let mut before = 0..states.len();
        for around in samples.iter().map(|s| s.1.as_slice()).chain([ends[1]]) {
            let first = states.len();
            for &vertex in around {
                let way = |from: usize| {
                    let State { vertex: other, cost, .. } = states[from];
                    if other == vertex {
                        return Some((cost, from));
                    }
                    self.edges.map.mesh.topology.find_edge(other, vertex)?;
                    let points = &self.edges.map.product.points;
                    let step = points[other].distance(points[vertex]) * 0.5 * (factor(other) + factor(vertex));
                    Some((cost + step * if is_free(vertex) { 1.0 } else { OCCUPIED }, from))
                };
                let best = before.clone().filter_map(way).min_by(|a, b| a.0.total_cmp(&b.0));
                states.extend(best.map(|(cost, from)| State { vertex, cost, from }));
            }
            before = first..states.len();
        }
        self.visited += states.len();
        let last = before.min_by(|&a, &b| states[a].cost.total_cmp(&states[b].cost))?;
        let vertices = trace(&states, last, guide.is_closed());
        self.used.extend(&vertices);
        let farthest = vertices.iter().filter_map(|v| off.get(v)).copied().fold(0.0, f32::max);
        (vertices.len() > if guide.is_closed() { 3 } else { 1 }).then_some(EdgePath { vertices, farthest })
    }

    /// Points along a guide with the vertices around each.
    fn samples(&self, guide: &Guide) -> Vec<(Vec3, Vec<VertexId>)> {
        let base = &self.edges.map.product.baseline;
        let mut samples = Vec::new();
        for pair in guide.vertices.windows(2) {
            let (forward, back) =
                (half_edge(&base.topology, pair[0], pair[1]), half_edge(&base.topology, pair[1], pair[0]));
            let Some(half) = forward.or(back) else { continue };
            let (from, to) = (base.points[pair[0]], base.points[pair[1]]);
            let target = base.target[pair[0]].min(base.target[pair[1]]);
            let count = (SAMPLES * from.distance(to) / target).min(MAX_SAMPLES).ceil().max(1.0) as usize;
            let (face, k) = (FaceId::new(half.index() / 3), half.index() % 3);
            for i in 0..=count {
                let t = i as f32 / count as f32;
                let t_half = if forward.is_some() { t } else { 1.0 - t };
                let weights = Vec3::AXES[k] * (1.0 - t_half) + Vec3::AXES[(k + 1) % 3] * t_half;
                if let Some((face, _)) = self.edges.locator.place(face, weights) {
                    samples.push((from.lerp(to, t), self.edges.around(face).collect()));
                }
            }
        }
        samples
    }

    /// The distance from the curve of each vertex around it, in target lengths.
    fn offsets(&self, samples: &[(Vec3, Vec<VertexId>)]) -> FxHashMap<VertexId, f32> {
        let product = self.edges.map.product;
        let mut off: FxHashMap<VertexId, f32> = FxHashMap::default();
        for pair in samples.windows(2) {
            for &vertex in pair.iter().flat_map(|s| &s.1) {
                let own = distance_to_segment(product.points[vertex], pair[0].0, pair[1].0) / product.target[vertex];
                off.entry(vertex).and_modify(|least| *least = least.min(own)).or_insert(own);
            }
        }
        off
    }
}

/// The vertices on the way to a state, each once; around a closed curve the first one is repeated at the end.
fn trace(states: &[State], last: usize, is_closed: bool) -> Vec<VertexId> {
    let mut way = vec![states[last].vertex];
    let mut at = last;
    while states[at].from != at {
        at = states[at].from;
        way.push(states[at].vertex);
    }
    way.dedup();
    way.reverse();
    let closing = way.pop_if(|_| is_closed);
    let mut path: Vec<VertexId> = Vec::with_capacity(way.len());
    let mut index: FxHashMap<VertexId, usize> = FxHashMap::default();
    for vertex in way {
        if let Some(&first) = index.get(&vertex) {
            // The way comes back here.
            path.drain(first..).for_each(|v| _ = index.remove(&v));
        }
        index.insert(vertex, path.len());
        path.push(vertex);
    }
    path.extend(closing);
    path
}
