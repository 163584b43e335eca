//! Lines of sharp edges over the cage.

use super::feature_lines::SharpEdge;
use glam::Vec3;
use std::collections::{BTreeMap, BTreeSet};
use tailor_mesh::connectivity::{EdgeId, IdVec, Topology, VertexId};

/// Sharp edges of the cage.
pub(super) type SharpEdges = BTreeMap<EdgeId, SharpEdge>;

/// Least cosine between two edges of which one continues the other.
const STRAIGHT: f32 = 0.5;

/// Most sharp edges at a vertex that lines pass. Of more, as at a pole of pleats, each ends there.
const MOST_SHARP_EDGES: usize = 16;

/// A line of sharp edges, each of which continues the one before.
pub(super) struct SharpLine {
    /// Its edges, in order. A loop begins where it bends least.
    pub edges: Vec<EdgeId>,
    /// The sum of bends times lengths. \[target lengths\]
    pub strength: f32,
}

impl SharpLine {
    fn new(edges: Vec<EdgeId>, sharp_edges: &SharpEdges) -> Self {
        let strength = edges.iter().map(|edge| sharp_edges[edge].bend * sharp_edges[edge].length).sum();
        Self { edges, strength }
    }

    /// The longest parts of the line whose edges are all wanted.
    pub fn runs(&self, is_wanted: impl Fn(EdgeId) -> bool) -> impl Iterator<Item = &[EdgeId]> {
        let wanted: Vec<bool> = self.edges.iter().map(|&edge| is_wanted(edge)).collect();
        let mut first = 0;
        let lengths: Vec<usize> = wanted.chunk_by(|a, b| a == b).map(<[bool]>::len).collect();
        lengths.into_iter().filter_map(move |length| {
            let run = first..first + length;
            first += length;
            wanted[run.start].then(|| &self.edges[run])
        })
    }
}

/// All lines. At a vertex, two edges continue each other if each is the straightest continuation of the other.
pub(super) fn lines(t: &Topology, points: &IdVec<VertexId, Vec3>, sharp_edges: &SharpEdges) -> Vec<SharpLine> {
    let mut at = BTreeMap::<VertexId, Vec<EdgeId>>::new();
    sharp_edges.keys().for_each(|&edge| t.edges[edge].iter().for_each(|&v| at.entry(v).or_default().push(edge)));
    let away = |edge: EdgeId, from: VertexId| {
        let [a, b] = t.edges[edge].map(|v| points[v]);
        if t.edges[edge][0] == from { (b - a).normalize_or_zero() } else { (a - b).normalize_or_zero() }
    };
    let straightest = |edge: EdgeId, v: VertexId| {
        let all = &at[&v][..];
        let others = all.iter().copied().filter(|&other| other != edge && all.len() <= MOST_SHARP_EDGES);
        let straight = others.map(|other| (-away(edge, v).dot(away(other, v)), other)).filter(|s| s.0 > STRAIGHT);
        straight.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1))).map(|(_, other)| other)
    };
    let next = |edge: EdgeId, v: VertexId| straightest(edge, v).filter(|&other| straightest(other, v) == Some(edge));

    let mut used = BTreeSet::new();
    let mut lines = Vec::new();
    for &first in sharp_edges.keys() {
        if used.contains(&first) {
            continue;
        }
        let [a, b] = t.edges[first];
        let (mut edges, is_loop) = walk(t, first, a, next);
        if is_loop {
            let bend = |i: &usize| sharp_edges[&edges[*i]].bend;
            let weakest = (0..edges.len()).min_by(|i, j| bend(i).total_cmp(&bend(j))).unwrap_or(0);
            edges.rotate_left(weakest);
        } else {
            edges.reverse();
            edges.extend(&walk(t, first, b, next).0[1..]);
        }
        used.extend(edges.iter().copied());
        lines.push(SharpLine::new(edges, sharp_edges));
    }
    lines
}

/// The edges from `first` on, which is left through the vertex `through`, to the end of the line, and whether it leads back.
fn walk(
    t: &Topology,
    first: EdgeId,
    mut through: VertexId,
    next: impl Fn(EdgeId, VertexId) -> Option<EdgeId>,
) -> (Vec<EdgeId>, bool) {
    let mut edges = vec![first];
    let mut edge = first;
    while let Some(other) = next(edge, through) {
        if other == first {
            return (edges, true);
        }
        let [a, b] = t.edges[other];
        (edge, through) = (other, if a == through { b } else { a });
        edges.push(edge);
    }
    (edges, false)
}
