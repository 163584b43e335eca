//! The vertex of the simulation mesh nearest to a vertex of the cage, on the same chain or the same part of the
//! surface.

use crate::mesh::{ChainId, Csr, FaceId, IdVec, Topology, VertexId};
use crate::sim::SimProduct;
use crate::transfer::topology::edge_key;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::VecDeque;

/// Largest arc length between a cage vertex and its vertex on the chain, in target lengths. More finds the nearest
/// vertex in space; less keeps to the right turn of a winding chain.
const MAX_DRIFT: f32 = 2.0;

/// The vertices of the simulation mesh by triangles of the baseline and by chains.
pub(super) struct VertexLocator<'a> {
    pub product: &'a SimProduct,
    /// The topology of the simulation mesh.
    pub topology: &'a Topology,
    /// The vertices in each triangle of the baseline.
    pub in_face: Csr<FaceId, VertexId>,
    /// Which vertices are on chains.
    pub is_constrained: IdVec<VertexId, bool>,
    /// The chain of each cage vertex on one, and the vertex's index along the chain's cage.
    on_chain: FxHashMap<VertexId, (ChainId, usize)>,
    /// The chain of each cage edge on one, and the edge's index along the chain's cage.
    chain_edge: FxHashMap<[VertexId; 2], (ChainId, usize)>,
}

impl<'a> VertexLocator<'a> {
    pub fn new(product: &'a SimProduct, topology: &'a Topology) -> Self {
        let mut pairs: Vec<(FaceId, VertexId)> = Vec::with_capacity(2 * product.points.len());
        for vertex in product.points.ids() {
            let own = pairs.len();
            for &corner in topology.vertex_corners.row(vertex) {
                let pair = (product.places[corner].location.face, vertex);
                if !pairs[own..].contains(&pair) {
                    pairs.push(pair);
                }
            }
        }
        let faces = product.baseline.topology.faces.len();
        let in_face = Csr::group(faces, pairs.iter().copied(), VertexId::new(0));
        let mut is_constrained = IdVec::filled(false, product.points.len());
        product.chain_edges.iter().flatten().flatten().for_each(|&v| is_constrained[v] = true);
        let (mut on_chain, mut chain_edge) = (FxHashMap::default(), FxHashMap::default());
        for (id, chain) in product.baseline.chains.enumerated() {
            // Vertices of the cage keep their numbers on every level.
            let cage: Vec<VertexId> = chain.vertices.iter().step_by(chain.step().max(1)).copied().collect();
            for (k, &vertex) in cage.iter().enumerate() {
                on_chain.entry(vertex).or_insert((id, k));
            }
            for (k, pair) in cage.windows(2).enumerate() {
                chain_edge.insert(edge_key([pair[0], pair[1]]), (id, k));
            }
        }
        Self { product, topology, in_face, is_constrained, on_chain, chain_edge }
    }

    /// The chain that a cage vertex is on, and its index along the chain's cage.
    pub fn on_chain(&self, vertex: VertexId) -> Option<(ChainId, usize)> {
        self.on_chain.get(&vertex).copied()
    }

    /// The chain that a cage edge is on, and its index along the chain's cage.
    pub fn edge_on_chain(&self, edge: [VertexId; 2]) -> Option<(ChainId, usize)> {
        self.chain_edge.get(&edge_key(edge)).copied()
    }

    /// Distinct vertices for the cage vertices `wanted` of a chain, as far as it has enough: each by its index along
    /// the chain, and the vertex. Both are ascending. With `has_ends`, a loop is cut where its cage begins; else
    /// indices count from the first vertex.
    pub fn assign_on_chain(&self, chain: ChainId, wanted: &[usize], has_ends: bool) -> Vec<(usize, VertexId)> {
        let edges = self.product.chain_arcs[chain].iter().zip(&self.product.chain_edges[chain]);
        let first = edges.clone().next().map(|(arcs, edge)| (arcs[0], edge[0]));
        let mut along: Vec<(f32, VertexId)> =
            first.into_iter().chain(edges.map(|(arcs, edge)| (arcs[1], edge[1]))).collect();
        let is_loop = self.product.baseline.chains[chain].is_loop && !has_ends;
        if is_loop && let Some(&first) = wanted.first() {
            // A loop repeats its first vertex at the end.
            along.pop();
            let start = self.nearest_on_chain(chain, &along, first, is_loop);
            along.rotate_left(start);
        }
        let Some(last) = along.len().checked_sub(1) else { return Vec::new() };
        let mut indices: Vec<usize> =
            wanted.iter().map(|&k| self.nearest_on_chain(chain, &along, k, is_loop)).collect();
        for i in 1..indices.len() {
            indices[i] = indices[i].max(indices[i - 1] + 1);
        }
        for (after, index) in indices.iter_mut().rev().enumerate() {
            *index = (*index).min(last.saturating_sub(after));
        }
        indices.into_iter().map(|index| (index, along[index].1)).collect()
    }

    /// The index of the vertex nearest to cage vertex `k` of a chain, of those with their arc lengths in `along`.
    fn nearest_on_chain(&self, chain: ChainId, along: &[(f32, VertexId)], k: usize, is_loop: bool) -> usize {
        let curve = &self.product.baseline.chains[chain];
        let index = (k * curve.step()).min(curve.vertices.len() - 1);
        if index == 0 && !is_loop {
            return 0;
        }
        if index + 1 == curve.vertices.len() && !is_loop {
            return along.len().saturating_sub(1);
        }
        let (s, point) = (curve.along[index], self.product.baseline.points[curve.vertices[index]]);
        let distance = |(at, v): (f32, VertexId)| {
            let drift = (at - s).abs();
            let drift = if is_loop { drift.min(curve.length() - drift) } else { drift };
            (drift > MAX_DRIFT * self.product.target[v], self.product.points[v].distance_squared(point))
        };
        (1..along.len()).fold(0, |best, i| if distance(along[i]) < distance(along[best]) { i } else { best })
    }

    /// The vertex at a cage vertex: the nearest within a target length that `is_free` admits, else the nearest. None
    /// where the surface has no vertex.
    pub fn nearest(&self, vertex: VertexId, is_free: impl Fn(VertexId) -> bool) -> Option<VertexId> {
        if let Some((chain, k)) = self.on_chain(vertex) {
            return self.assign_on_chain(chain, &[k], false).first().map(|a| a.1);
        }
        let found = self.around(vertex);
        let mut near = found.iter().take_while(|f| f.0 <= self.product.target[f.1]);
        near.find(|f| is_free(f.1)).or(found.first()).map(|f| f.1)
    }

    /// The vertices within a target length of a cage vertex on its part of the surface, the nearest first.
    pub fn near(&self, vertex: VertexId) -> Vec<VertexId> {
        let found = self.around(vertex).into_iter();
        found.filter(|f| f.0 <= self.product.target[f.1]).map(|f| f.1).collect()
    }

    /// The vertices around a cage vertex on its part of the surface with their distances, the nearest first.
    fn around(&self, vertex: VertexId) -> Vec<(f32, VertexId)> {
        let base = &self.product.baseline;
        let t = &base.topology;
        let point = base.points[vertex];
        let mut queue: VecDeque<FaceId> = t.faces_at(vertex).collect();
        let mut seen: FxHashSet<FaceId> = queue.iter().copied().collect();
        let mut found: Vec<(f32, VertexId)> = Vec::new();
        let mut reach = f32::MAX;
        while let Some(face) = queue.pop_front() {
            let nearest = base.triangle(face).map(|p| p.distance(point)).into_iter().fold(f32::MAX, f32::min);
            if nearest > reach {
                continue;
            }
            for &v in self.in_face.row(face) {
                let distance = self.product.points[v].distance(point);
                found.push((distance, v));
                reach = reach.min(distance + self.product.target[v]);
            }
            let neighbours = t.faces.corners_of(face).filter_map(|c| base.open_twin(c)).map(|c| t.faces.face_of(c));
            queue.extend(neighbours.filter(|&other| seen.insert(other)));
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.dedup_by_key(|f| f.1);
        found
    }
}
