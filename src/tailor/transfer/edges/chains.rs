//! The part of an edge set that is on constraint chains.

use super::guide::Guide;
use super::vertex_locator::VertexLocator;
use std::collections::{BTreeMap, BTreeSet};
use tailor_mesh::connectivity::{ChainId, VertexId};

/// The cage edges of a set on each chain, by their indices along the chain's cage.
pub(super) type ChainEdges = BTreeMap<ChainId, BTreeSet<usize>>;

/// For cage vertices at ends of a set, by chain and index along its cage: the index along the chain of the simulation
/// mesh, and the vertex.
pub(super) struct ChainEnds(BTreeMap<(ChainId, usize), (usize, VertexId)>);

impl ChainEnds {
    /// The ends of a set's intervals on chains, and the ends of its guides on chains.
    pub fn new(locator: &VertexLocator<'_>, on_chains: &ChainEdges, guides: &[Guide]) -> Self {
        let mut wanted: BTreeMap<ChainId, BTreeSet<usize>> = BTreeMap::new();
        for (&chain, edges) in on_chains {
            wanted.entry(chain).or_default().extend(intervals(edges).into_iter().flatten());
        }
        for (chain, k) in guides.iter().flat_map(Guide::ends).filter_map(|end| locator.on_chain(end)) {
            wanted.entry(chain).or_default().insert(k);
        }
        let mut ends = BTreeMap::new();
        for (chain, vertices) in wanted {
            let vertices: Vec<usize> = vertices.into_iter().collect();
            let assigned = locator.assign_on_chain(chain, &vertices, on_chains.contains_key(&chain));
            ends.extend(vertices.into_iter().map(|k| (chain, k)).zip(assigned));
        }
        Self(ends)
    }

    /// The vertex of the simulation mesh at the end of a guide on a chain.
    pub fn vertex(&self, locator: &VertexLocator<'_>, end: VertexId) -> Option<VertexId> {
        self.0.get(&locator.on_chain(end)?).map(|e| e.1)
    }

    /// The edges of the simulation mesh on each interval of a set.
    pub fn edges<'a>(&self, locator: &VertexLocator<'a>, on_chains: &ChainEdges) -> Vec<&'a [[VertexId; 2]]> {
        let intervals =
            on_chains.iter().flat_map(|(&chain, edges)| intervals(edges).into_iter().map(move |i| (chain, i)));
        let part = |(chain, [from, to]): (ChainId, [usize; 2])| {
            let edges = &locator.product.chain_edges[chain][..];
            if edges.is_empty() || to - from + 1 >= locator.product.baseline.chains[chain].cage.len() {
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
