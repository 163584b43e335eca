//! The vertex of the simulation mesh nearest to a vertex of the cage, on the same chain or the same part of the surface.

use crate::mesh::{ChainId, Csr, FaceId, IdVec, Topology, VertexId};
use crate::sim::SimProduct;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::VecDeque;

/// How far along its chain a vertex may be from a place on it, in target lengths. Longer finds the vertex that is nearest
/// in space; shorter keeps to the right turn of a winding chain.
const DRIFT: f32 = 2.0;

/// Where the vertices of the simulation mesh are on the baseline.
pub(super) struct Surface<'a> {
    pub product: &'a SimProduct,
    /// The vertices that lie in each triangle of the baseline.
    pub in_face: Csr<FaceId, VertexId>,
    /// Which vertices are on chains.
    pub is_constrained: IdVec<VertexId, bool>,
    /// Where vertices of the cage lie on chains: the chain, and the place in its curve.
    on_chain: FxHashMap<VertexId, (ChainId, usize)>,
    /// The chain between two neighbouring vertices of the cage, and which of its cage edges that is.
    pub chain_edge: FxHashMap<[VertexId; 2], (ChainId, usize)>,
}

impl<'a> Surface<'a> {
    /// Of the simulation mesh, whose `topology` is at hand.
    pub fn new(product: &'a SimProduct, topology: &Topology) -> Self {
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
        let (on_chain, chain_edge) = (FxHashMap::default(), FxHashMap::default());
        let mut surface = Self { product, in_face, is_constrained, on_chain, chain_edge };
        for (id, chain) in product.baseline.chains.enumerated() {
            let step = chain.step();
            // Vertices of the cage keep their numbers on every level.
            let cage: Vec<VertexId> = chain.vertices.iter().step_by(step.max(1)).copied().collect();
            for (k, &vertex) in cage.iter().enumerate() {
                surface.on_chain.entry(vertex).or_insert((id, k * step));
            }
            for (k, pair) in cage.windows(2).enumerate() {
                surface.chain_edge.insert(sorted(pair[0], pair[1]), (id, k));
            }
        }
        surface
    }

    /// The vertices of the simulation mesh along a chain, with their arc lengths.
    fn along(&self, chain: ChainId) -> Vec<(f32, VertexId)> {
        let edges = self.product.chain_arcs[chain].iter().zip(&self.product.chain_edges[chain]);
        let first = edges.clone().next().map(|(arcs, edge)| (arcs[0], edge[0]));
        first.into_iter().chain(edges.map(|(arcs, edge)| (arcs[1], edge[1]))).collect()
    }

    /// The places of cage vertices among the vertices of a chain of the simulation mesh: one for each where there are
    /// enough, in their order. `wanted` are the vertices' places in the cage's, ascending. Parts of a loop have ends where it
    /// begins (`has_ends`); else it begins anywhere, and places count from that of the first vertex.
    pub fn places_on_chain(&self, chain: ChainId, wanted: &[usize], has_ends: bool) -> Vec<(usize, VertexId)> {
        let mut along = self.along(chain);
        let is_round = self.product.baseline.chains[chain].is_loop && !has_ends;
        if is_round && let Some(&first) = wanted.first() {
            // Its last vertex is its first.
            along.pop();
            let start = self.nearest_on_chain(chain, &along, first, is_round);
            along.rotate_left(start);
        }
        let Some(last) = along.len().checked_sub(1) else { return Vec::new() };
        let mut places: Vec<usize> =
            wanted.iter().map(|&k| self.nearest_on_chain(chain, &along, k, is_round)).collect();
        for i in 1..places.len() {
            places[i] = places[i].max(places[i - 1] + 1);
        }
        let count = places.len();
        for (i, place) in places.iter_mut().enumerate() {
            *place = (*place).min(last.saturating_sub(count - 1 - i));
        }
        places.into_iter().map(|place| (place, along[place].1)).collect()
    }

    fn nearest_on_chain(&self, chain: ChainId, along: &[(f32, VertexId)], k: usize, is_round: bool) -> usize {
        let curve = &self.product.baseline.chains[chain];
        let index = (k * curve.step()).min(curve.vertices.len() - 1);
        if index == 0 && !is_round {
            return 0;
        }
        if index + 1 == curve.vertices.len() && !is_round {
            return along.len().saturating_sub(1);
        }
        let (s, point) = (curve.along[index], self.product.baseline.points[curve.vertices[index]]);
        let off = |(at, v): (f32, VertexId)| {
            let way = (at - s).abs();
            let way = if is_round { way.min(curve.length() - way) } else { way };
            let far = way > DRIFT * self.product.target[v];
            (far, self.product.points[v].distance_squared(point))
        };
        let nearer = |best: usize, i: usize| {
            let (a, b) = (off(along[i]), off(along[best]));
            if a.0 != b.0 { b.0 } else { a.1 < b.1 }
        };
        (1..along.len()).fold(0, |best, i| if nearer(best, i) { i } else { best })
    }

    /// The chain that a vertex of the cage lies on, and its place in the chain's cage.
    pub fn on_chain(&self, vertex: VertexId) -> Option<(ChainId, usize)> {
        let &(chain, index) = self.on_chain.get(&vertex)?;
        Some((chain, index / self.product.baseline.chains[chain].step().max(1)))
    }

    /// Whether a vertex of the cage lies on a chain.
    pub fn is_on_chain(&self, vertex: VertexId) -> bool {
        self.on_chain.contains_key(&vertex)
    }

    /// The nearest vertex to a vertex of the cage that `is_free` admits; if none is within a target length, the nearest of
    /// all. None where nothing of the surface is left.
    pub fn nearest(&self, vertex: VertexId, is_free: impl Fn(VertexId) -> bool) -> Option<VertexId> {
        if let Some((chain, k)) = self.on_chain(vertex) {
            return self.places_on_chain(chain, &[k], false).first().map(|p| p.1);
        }
        let found = self.around(vertex);
        let first = found.first()?;
        let near = found.iter().take_while(|f| f.0 <= self.product.target[f.1]);
        Some(near.map(|f| f.1).find(|&v| is_free(v)).unwrap_or(first.1))
    }

    /// The vertices within a target length of a vertex of the cage, the nearest first, on its part of the surface.
    pub fn vertices_near(&self, vertex: VertexId) -> Vec<VertexId> {
        let found = self.around(vertex).into_iter();
        found.filter(|f| f.0 <= self.product.target[f.1]).map(|f| f.1).collect()
    }

    /// The vertices around a vertex of the cage, the nearest first, on its part of the surface.
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
            for corner in t.faces.corners_of(face) {
                if let Some(other) = base.open_twin(corner).map(|c| t.faces.face_of(c))
                    && seen.insert(other)
                {
                    queue.push_back(other);
                }
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.dedup_by_key(|f| f.1);
        found
    }
}

/// An edge's vertices, the lower first.
pub(super) fn sorted(a: VertexId, b: VertexId) -> [VertexId; 2] {
    [a.min(b), a.max(b)]
}
