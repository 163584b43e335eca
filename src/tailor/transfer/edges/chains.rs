//! The part of an edge set that is on constraint chains.

use super::guide::{Guide, refined_path};
use crate::sim::SimProduct;
use crate::transfer::topology::edge_key;
use rustc_hash::FxHashMap;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use tailor_mesh::connectivity::{ChainId, IdVec, VertexId};

/// Largest arc length between a cage vertex and its vertex on the chain, in target lengths. More finds the nearest
/// vertex in space; less keeps to the right turn of a winding chain.
const MAX_DRIFT: f32 = 2.0;

/// The cage edges of a set on each chain, by their indices along the chain's cage.
pub(super) type ChainEdges = BTreeMap<ChainId, BTreeSet<usize>>;

/// The vertices of the cage and of the simulation mesh on chains.
pub(super) struct Chains<'a> {
    product: &'a SimProduct,
    /// The chain of each vertex of the traced level on one, and the vertex's index along the chain.
    on_chain: FxHashMap<VertexId, (ChainId, usize)>,
    /// The chain of each edge of the traced level on one, and the edge's index along the chain.
    chain_edge: FxHashMap<[VertexId; 2], (ChainId, usize)>,
    /// The vertices of the simulation mesh along each chain.
    along: IdVec<ChainId, AlongChain>,
}

/// The vertices of the simulation mesh along a chain.
struct AlongChain {
    /// Each with its arc length, ascending. A loop repeats its first vertex at the end. \[mesh units\]
    vertices: Vec<(f32, VertexId)>,
    /// The longest arc between a cage vertex and its vertex. \[mesh units\]
    reach: f32,
}

impl AlongChain {
    fn new(product: &SimProduct, chain: ChainId) -> Self {
        let edges = product.chain_arcs[chain].iter().zip(&product.chain_edges[chain]);
        let first = edges.clone().next().map(|(arcs, edge)| (arcs[0], edge[0]));
        let vertices: Vec<(f32, VertexId)> =
            first.into_iter().chain(edges.map(|(arcs, edge)| (arcs[1], edge[1]))).collect();
        let reach = vertices.iter().map(|v| MAX_DRIFT * product.target[v.1]).fold(0.0, f32::max);
        Self { vertices, reach }
    }

    /// The indices of the vertices within reach of an arc length.
    fn within_reach(&self, s: f32) -> Range<usize> {
        let from = self.vertices.partition_point(|v| v.0 < s - self.reach);
        from..self.vertices.partition_point(|v| v.0 <= s + self.reach).max(from)
    }
}

impl<'a> Chains<'a> {
    pub fn new(product: &'a SimProduct) -> Self {
        let (mut on_chain, mut chain_edge) = (FxHashMap::default(), FxHashMap::default());
        for (id, chain) in product.baseline.chains.enumerated() {
            // Vertices of a level keep their numbers on all finer ones.
            let cage: Vec<VertexId> = chain.vertices.iter().step_by(chain.step().max(1)).copied().collect();
            for (k, &vertex) in cage.iter().enumerate() {
                on_chain.entry(vertex).or_insert((id, k));
            }
            for (k, pair) in cage.windows(2).enumerate() {
                chain_edge.insert(edge_key([pair[0], pair[1]]), (id, k));
            }
        }
        let along = product.baseline.chains.ids().map(|chain| AlongChain::new(product, chain)).collect();
        Self { product, on_chain, chain_edge, along }
    }

    /// The chain that a cage vertex is on, and its index along the chain's cage.
    pub fn of_vertex(&self, vertex: VertexId) -> Option<(ChainId, usize)> {
        self.on_chain.get(&vertex).copied()
    }

    /// The chains that a cage edge is on, and the indices along them: one chain and index, or one for each half.
    pub fn of_edge(&self, edge: [VertexId; 2]) -> Option<Vec<(ChainId, usize)>> {
        edge.iter().all(|v| self.on_chain.contains_key(v)).then_some(())?;
        let baseline = &self.product.baseline;
        let path = refined_path(baseline, &edge);
        let ends: Vec<VertexId> = path.iter().step_by((path.len() - 1) >> baseline.traced).copied().collect();
        ends.windows(2).map(|pair| self.chain_edge.get(&edge_key([pair[0], pair[1]])).copied()).collect()
    }

    /// The vertex of the simulation mesh nearest to vertex `k` of a chain's cage.
    pub fn nearest(&self, chain: ChainId, k: usize) -> Option<VertexId> {
        let is_loop = self.product.baseline.chains[chain].is_loop;
        self.along_of(chain, is_loop).get(self.nearest_index(chain, k, 0, is_loop)).map(|a| a.1)
    }

    /// Distinct vertices for the cage vertices `wanted` of a chain, as far as it has enough: each by its index along
    /// the chain, and the vertex. Both are ascending. With `has_ends`, a loop is cut where its cage begins; else
    /// indices count from the first vertex.
    fn assign(&self, chain: ChainId, wanted: &[usize], has_ends: bool) -> Vec<(usize, VertexId)> {
        let is_loop = self.product.baseline.chains[chain].is_loop && !has_ends;
        let along = self.along_of(chain, is_loop);
        let Some(last) = along.len().checked_sub(1) else { return Vec::new() };
        let start = wanted.first().filter(|_| is_loop).map_or(0, |&k| self.nearest_index(chain, k, 0, is_loop));
        let mut indices: Vec<usize> = wanted.iter().map(|&k| self.nearest_index(chain, k, start, is_loop)).collect();
        for i in 1..indices.len() {
            indices[i] = indices[i].max(indices[i - 1] + 1);
        }
        for (after, index) in indices.iter_mut().rev().enumerate() {
            *index = (*index).min(last.saturating_sub(after));
        }
        indices.into_iter().map(|index| (index, along[(index + start) % along.len()].1)).collect()
    }

    /// The vertices along a chain with their arc lengths; those of a loop without the first one again.
    fn along_of(&self, chain: ChainId, is_loop: bool) -> &[(f32, VertexId)] {
        let all = &self.along[chain].vertices;
        &all[..all.len().saturating_sub(usize::from(is_loop))]
    }

    /// The index of the vertex nearest to cage vertex `k` of a chain, counted from vertex `start` on. Only vertices within
    /// reach are compared, unless there are none.
    fn nearest_index(&self, chain: ChainId, k: usize, start: usize, is_loop: bool) -> usize {
        let curve = &self.product.baseline.chains[chain];
        let along = self.along_of(chain, is_loop);
        let index = (k * curve.step()).min(curve.vertices.len() - 1);
        if index == 0 && !is_loop {
            return 0;
        }
        if index + 1 == curve.vertices.len() && !is_loop {
            return along.len().saturating_sub(1);
        }
        let (s, point) = (curve.along[index], self.product.baseline.points[curve.vertices[index]]);
        let key = |i: usize| {
            let (at, v) = along[i];
            let drift = (at - s).abs();
            let drift = if is_loop { drift.min(curve.length() - drift) } else { drift };
            let squared = self.product.points[v].distance_squared(point);
            // The bits of distances, which are not negative, sort as the distances do.
            (drift > MAX_DRIFT * self.product.target[v], squared.to_bits(), (i + along.len() - start) % along.len())
        };
        let turns = if is_loop { &[-1.0, 0.0, 1.0][..] } else { &[0.0] };
        let within = turns.iter().flat_map(|turn| self.along[chain].within_reach(s + turn * curve.length()));
        let near = within.filter(|&i| i < along.len()).map(key).min().filter(|key| !key.0);
        near.or_else(|| (0..along.len()).map(key).min()).map_or(0, |key| key.2)
    }
}

/// For cage vertices at ends of a set, by chain and index along its cage: the index along the chain of the simulation
/// mesh, and the vertex.
pub(super) struct ChainEnds(BTreeMap<(ChainId, usize), (usize, VertexId)>);

impl ChainEnds {
    /// The ends of a set's intervals on chains, and the ends of its guides on chains.
    pub fn new(chains: &Chains<'_>, on_chains: &ChainEdges, guides: &[Guide]) -> Self {
        let mut wanted: BTreeMap<ChainId, BTreeSet<usize>> = BTreeMap::new();
        for (&chain, edges) in on_chains {
            wanted.entry(chain).or_default().extend(intervals(edges).into_iter().flatten());
        }
        for (chain, k) in guides.iter().flat_map(Guide::ends).filter_map(|end| chains.of_vertex(end)) {
            wanted.entry(chain).or_default().insert(k);
        }
        let mut ends = BTreeMap::new();
        for (chain, vertices) in wanted {
            let vertices: Vec<usize> = vertices.into_iter().collect();
            let assigned = chains.assign(chain, &vertices, on_chains.contains_key(&chain));
            ends.extend(vertices.into_iter().map(|k| (chain, k)).zip(assigned));
        }
        Self(ends)
    }

    /// The vertex of the simulation mesh at the end of a guide on a chain.
    pub fn vertex(&self, chains: &Chains<'_>, end: VertexId) -> Option<VertexId> {
        self.0.get(&chains.of_vertex(end)?).map(|e| e.1)
    }

    /// The edges of the simulation mesh on each interval of a set.
    pub fn edges<'a>(&self, chains: &Chains<'a>, on_chains: &ChainEdges) -> Vec<&'a [[VertexId; 2]]> {
        let intervals =
            on_chains.iter().flat_map(|(&chain, edges)| intervals(edges).into_iter().map(move |i| (chain, i)));
        let part = |(chain, [from, to]): (ChainId, [usize; 2])| {
            let edges = &chains.product.chain_edges[chain][..];
            if edges.is_empty() || to - from + 1 >= chains.product.baseline.chains[chain].cage.len() {
                return edges;
            }
            let [from, to] = [from, to].map(|k| self.0[&(chain, k)].0);
            let from = from.min(edges.len() - 1);
            &edges[from..to.clamp(from + 1, edges.len())]
        };
        intervals.map(part).collect()
    }
}

/// The first vertex and the last vertex of each run of consecutive edges.
fn intervals(edges: &BTreeSet<usize>) -> Vec<[usize; 2]> {
    let edges: Vec<usize> = edges.iter().copied().collect();
    edges.chunk_by(|a, b| a + 1 == *b).map(|own| [own[0], own[own.len() - 1] + 1]).collect()
}
