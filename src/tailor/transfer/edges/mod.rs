//! Edge sets: exact where their edges are constraints, else paths of edges along their curves on the baseline.

mod chains;
mod corridor;
mod guide;
mod path;
mod paths;
mod polyline;
mod vertex_locator;

use super::topology::edge_key;
use crate::sim::SimProduct;
use chains::{ChainEdges, ChainEnds};
use corridor::CorridorScratch;
use glam::Vec3;
use guide::{Guide, guides, refined_path};
use path::EdgePath;
use paths::{PathSearch, meeting};
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::{BTreeMap, BTreeSet};
use tailor_mesh::connectivity::{Csr, IdVec, Topology, VertexId};
use vertex_locator::VertexLocator;

/// Edges and vertices of the garment on the simulation mesh.
pub(super) struct EdgeTransfer<'a> {
    locator: VertexLocator<'a>,
    /// The cage edges of each edge of the garment that has a face on the surface; several where it is cut apart.
    cage_edges: FxHashMap<[VertexId; 2], Vec<[VertexId; 2]>>,
    /// The cage vertices of each vertex of the garment; several where it is cut apart.
    cage_vertices: Csr<VertexId, VertexId>,
}

/// An edge set on the simulation mesh.
#[derive(Default)]
pub(super) struct CarriedEdges {
    /// Its edges; those of a chain in the chain's order.
    pub edges: Vec<[VertexId; 2]>,
    /// The garment's edges without a counterpart.
    pub lost: Vec<[VertexId; 2]>,
    /// The garment's edges of each path that meets others because the mesh has too few vertices.
    pub merged: Vec<Vec<[VertexId; 2]>>,
    /// Length of the source's curves on the baseline. \[mesh units\]
    pub source_length: f64,
    /// Largest distance of a vertex from its curve, in local target lengths.
    pub farthest: f32,
    /// Triangles and vertices that the searches for its paths visited.
    pub visited: usize,
    /// Length of its edges, with the shortest path in place of each that is too long. \[mesh units\]
    pub shortest: f64,
}

impl CarriedEdges {
    fn add_path(&mut self, path: &EdgePath) {
        self.farthest = self.farthest.max(path.farthest);
        self.shortest += path.shortest;
        self.edges.extend(path.vertices.windows(2).map(|p| [p[0], p[1]]));
    }
}

impl<'a> EdgeTransfer<'a> {
    /// From a garment of `source_points` points; `topology` is that of the simulation mesh.
    pub fn new(product: &'a SimProduct, topology: &'a Topology, source_points: usize) -> Self {
        let manifold = &product.baseline.manifold;
        let mut cage_edges: FxHashMap<[VertexId; 2], Vec<[VertexId; 2]>> = FxHashMap::default();
        for &edge in manifold.level.topology.edges.iter() {
            cage_edges.entry(edge_key(edge.map(|v| manifold.vertex_source[v]))).or_default().push(edge);
        }
        let pairs = manifold.vertex_source.enumerated().map(|(own, &source)| (source, own));
        let cage_vertices = Csr::group(source_points, pairs, VertexId::new(0));
        Self { locator: VertexLocator::new(product, topology), cage_edges, cage_vertices }
    }

    /// The nearest vertices to a vertex of the garment, one for each part of the surface that it is on.
    pub fn nearest_vertices(&self, vertex: VertexId) -> impl Iterator<Item = VertexId> {
        self.cage_vertices.row(vertex).iter().filter_map(|&v| self.locator.nearest(v, |_| true))
    }

    /// Several sets of the garment's edges, independent of each other.
    pub fn carry_all(&self, sets: &[&[[VertexId; 2]]]) -> Vec<CarriedEdges> {
        let scratch = || CorridorScratch::new(&self.locator);
        sets.par_iter().map_init(scratch, |scratch, set| self.carry(set, scratch)).collect()
    }

    fn carry(&self, set: &[[VertexId; 2]], scratch: &mut CorridorScratch) -> CarriedEdges {
        let (locator, product) = (&self.locator, self.locator.product);
        let mut carried = CarriedEdges::default();
        let (on_chains, free) = self.divide(set, &mut carried);
        let guides = guides(&product.baseline, &free, |v| free[v].len() != 2 || locator.on_chain(*v).is_some());
        let chain_ends = ChainEnds::new(locator, &on_chains, &guides);
        for edges in chain_ends.edges(locator, &on_chains) {
            carried.shortest += length(edges.iter().copied(), &product.points);
            carried.edges.extend(edges);
        }
        let ends = self.snapped_ends(&guides, &chain_ends);
        self.carry_along(&guides, &ends, scratch, &mut carried);
        let mut seen = BTreeSet::new();
        carried.edges.retain(|&edge| seen.insert(edge_key(edge)));
        carried
    }

    /// Adds the paths of guides to the edges on chains.
    fn carry_along(
        &self,
        guides: &[Guide],
        ends: &BTreeMap<VertexId, VertexId>,
        scratch: &mut CorridorScratch,
        carried: &mut CarriedEdges,
    ) {
        let before = scratch.visited;
        let mut search = PathSearch::new(&self.locator, ends, &carried.edges, scratch);
        let found: Vec<Option<EdgePath>> = guides.iter().map(|guide| search.find(guide)).collect();
        carried.visited = scratch.visited - before;
        let sources = &self.locator.product.baseline.manifold.vertex_source;
        let is_lost = |pair: &(&Guide, &Option<EdgePath>)| pair.1.is_none();
        let lost = guides.iter().zip(&found).filter(is_lost).flat_map(|(guide, _)| guide.edges(sources));
        carried.lost.extend(lost);
        let paths: Vec<(&Guide, &EdgePath)> =
            guides.iter().zip(&found).filter_map(|(guide, path)| Some((guide, path.as_ref()?))).collect();
        carried.merged = meeting(&paths, ends, &carried.edges).map(|guide| guide.edges(sources).collect()).collect();
        paths.into_iter().for_each(|(_, path)| carried.add_path(path));
    }

    /// The cage edges of a set on chains, and the neighbours of each cage vertex by its other edges.
    fn divide(
        &self,
        set: &[[VertexId; 2]],
        carried: &mut CarriedEdges,
    ) -> (ChainEdges, BTreeMap<VertexId, Vec<VertexId>>) {
        let baseline = &self.locator.product.baseline;
        let (mut on_chains, mut free) = (ChainEdges::new(), BTreeMap::<VertexId, Vec<VertexId>>::new());
        for &edge in set {
            let mut is_there = false;
            for &[a, b] in self.cage_edges.get(&edge_key(edge)).into_iter().flatten() {
                let path = refined_path(baseline, &[a, b]);
                if let Some(parts) = self.locator.edge_on_chains(&path) {
                    parts.into_iter().for_each(|(chain, k)| _ = on_chains.entry(chain).or_default().insert(k));
                } else if baseline.topology.find_edge(path[0], path[1]).is_some() {
                    free.entry(a).or_default().push(b);
                    free.entry(b).or_default().push(a);
                } else {
                    // Between two holes.
                    continue;
                }
                carried.source_length += length(path.windows(2).map(|p| [p[0], p[1]]), &baseline.points);
                is_there = true;
            }
            if !is_there {
                carried.lost.push(edge);
            }
        }
        (on_chains, free)
    }

    /// The vertex of the simulation mesh at each end of guides: distinct ones as far as there are enough.
    fn snapped_ends(&self, guides: &[Guide], chain_ends: &ChainEnds) -> BTreeMap<VertexId, VertexId> {
        let ends: BTreeSet<VertexId> = guides.iter().filter(|g| !g.is_loop).flat_map(Guide::ends).collect();
        let (on_chains, free): (Vec<_>, Vec<_>) =
            ends.into_iter().partition(|&end| self.locator.on_chain(end).is_some());
        // Ends on chains come first, because they have no choice.
        let vertex = |end| Some((end, chain_ends.vertex(&self.locator, end)?));
        let mut snapped: BTreeMap<VertexId, VertexId> = on_chains.into_iter().filter_map(vertex).collect();
        let mut taken: FxHashSet<VertexId> = snapped.values().copied().collect();
        for end in free {
            if let Some(vertex) = self.locator.nearest(end, |v| !taken.contains(&v)) {
                snapped.insert(end, vertex);
                taken.insert(vertex);
            }
        }
        snapped
    }
}

/// \[mesh units\]
fn length(edges: impl Iterator<Item = [VertexId; 2]>, points: &IdVec<VertexId, Vec3>) -> f64 {
    edges.map(|[a, b]| f64::from(points[a].distance(points[b]))).sum()
}
