//! The vertex of the simulation mesh nearest to a vertex of the cage, on the same chain or the same part of the
//! surface.

use crate::sim::SimProduct;
use crate::transfer::topology::edge_key;
use glam::Vec3;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::{BTreeSet, VecDeque};
use std::ops::Range;
use std::sync::OnceLock;
use tailor_mesh::connectivity::{ChainId, Csr, FaceId, IdVec, Topology, VertexId};

/// Largest arc length between a cage vertex and its vertex on the chain, in target lengths. More finds the nearest
/// vertex in space; less keeps to the right turn of a winding chain.
const MAX_DRIFT: f32 = 2.0;

/// Triangles of the baseline that a search around a vertex visits at most. Targets much longer than the edges of the baseline
/// would have each search visit all of them.
const MAX_VISITED: usize = 4096;

/// The vertices of the simulation mesh by triangles of the baseline and by chains.
pub(super) struct VertexLocator<'a> {
    pub product: &'a SimProduct,
    /// The topology of the simulation mesh.
    pub topology: &'a Topology,
    /// The vertices in each triangle of the baseline.
    pub in_face: Csr<FaceId, VertexId>,
    /// Which vertices are on chains.
    pub is_constrained: IdVec<VertexId, bool>,
    /// The chain of each vertex of the traced level on one, and the vertex's index along the chain.
    on_chain: FxHashMap<VertexId, (ChainId, usize)>,
    /// The chain of each edge of the traced level on one, and the edge's index along the chain.
    chain_edge: FxHashMap<[VertexId; 2], (ChainId, usize)>,
    /// The vertices along each chain.
    along: IdVec<ChainId, AlongChain>,
    /// A vertex near each triangle of the baseline; none on a part of the surface without any.
    any_near: OnceLock<IdVec<FaceId, Option<VertexId>>>,
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

impl<'a> VertexLocator<'a> {
    pub fn new(product: &'a SimProduct, topology: &'a Topology) -> Self {
        let mut pairs: Vec<(FaceId, VertexId)> = Vec::with_capacity(2 * product.points.len());
        for vertex in product.points.ids() {
            let faces = topology.vertex_corners.row(vertex).iter().map(|&c| product.places[c].location.face);
            pairs.extend(faces.collect::<BTreeSet<FaceId>>().into_iter().map(|face| (face, vertex)));
        }
        let faces = product.baseline.topology.faces.len();
        let in_face = Csr::group(faces, pairs.iter().copied(), VertexId::new(0));
        let mut is_constrained = IdVec::filled(false, product.points.len());
        product.chain_edges.iter().flatten().flatten().for_each(|&v| is_constrained[v] = true);
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
        let any_near = OnceLock::new();
        Self { product, topology, in_face, is_constrained, on_chain, chain_edge, along, any_near }
    }

    /// The chain that a cage vertex is on, and its index along the chain's cage.
    pub fn on_chain(&self, vertex: VertexId) -> Option<(ChainId, usize)> {
        self.on_chain.get(&vertex).copied()
    }

    /// The chains that a cage edge is on, whose vertices on the baseline are `path`, and the indices along them: one chain and
    /// index, or one for each half.
    pub fn edge_on_chains(&self, path: &[VertexId]) -> Option<Vec<(ChainId, usize)>> {
        let ends: Vec<VertexId> =
            path.iter().step_by((path.len() - 1) >> self.product.baseline.traced).copied().collect();
        ends.windows(2).map(|pair| self.chain_edge.get(&edge_key([pair[0], pair[1]])).copied()).collect()
    }

    /// Distinct vertices for the cage vertices `wanted` of a chain, as far as it has enough: each by its index along
    /// the chain, and the vertex. Both are ascending. With `has_ends`, a loop is cut where its cage begins; else
    /// indices count from the first vertex.
    pub fn assign_on_chain(&self, chain: ChainId, wanted: &[usize], has_ends: bool) -> Vec<(usize, VertexId)> {
        let is_loop = self.product.baseline.chains[chain].is_loop && !has_ends;
        let along = self.along_of(chain, is_loop);
        let Some(last) = along.len().checked_sub(1) else { return Vec::new() };
        let start =
            wanted.first().filter(|_| is_loop).map_or(0, |&first| self.nearest_on_chain(chain, first, 0, is_loop));
        let mut indices: Vec<usize> = wanted.iter().map(|&k| self.nearest_on_chain(chain, k, start, is_loop)).collect();
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
    fn nearest_on_chain(&self, chain: ChainId, k: usize, start: usize, is_loop: bool) -> usize {
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

    /// The vertex at a cage vertex: the nearest within a target length that `is_free` admits, else the nearest. None
    /// where the surface has no vertex.
    pub fn nearest(&self, vertex: VertexId, is_free: impl Fn(VertexId) -> bool) -> Option<VertexId> {
        if let Some((chain, k)) = self.on_chain(vertex) {
            let is_loop = self.product.baseline.chains[chain].is_loop;
            return self.along_of(chain, is_loop).get(self.nearest_on_chain(chain, k, 0, is_loop)).map(|a| a.1);
        }
        let found = self.around(vertex);
        let mut near = found.iter().take_while(|f| f.0 <= self.product.target[f.1]);
        near.find(|f| is_free(f.1)).or(found.first()).map(|f| f.1)
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
            if seen.len() > MAX_VISITED {
                found.extend(self.any_near(face).filter(|_| found.is_empty()).map(|v| (self.distance(v, point), v)));
                break;
            }
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

    fn distance(&self, vertex: VertexId, point: Vec3) -> f32 {
        self.product.points[vertex].distance(point)
    }

    /// A vertex near a triangle on the same part of the surface, by one search from all triangles with vertices.
    fn any_near(&self, face: FaceId) -> Option<VertexId> {
        let near = self.any_near.get_or_init(|| {
            let base = &self.product.baseline;
            let faces = &base.topology.faces;
            let mut near: IdVec<FaceId, Option<VertexId>> =
                faces.ids().map(|f| self.in_face.row(f).first().copied()).collect();
            let mut queue: VecDeque<FaceId> = faces.ids().filter(|&f| near[f].is_some()).collect();
            while let Some(face) = queue.pop_front() {
                for other in faces.corners_of(face).filter_map(|c| base.open_twin(c)).map(|c| faces.face_of(c)) {
                    if near[other].is_none() {
                        near[other] = near[face];
                        queue.push_back(other);
                    }
                }
            }
            near
        });
        near[face]
    }
}
