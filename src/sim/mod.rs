//! The simulation mesh: triangles of the wanted size on the garment's surface, conforming to its seams and borders.

mod baseline;
mod constraints;
mod gaps;
mod options;
mod passes;
mod sim_mesh;
mod surface;

pub use baseline::facets::Facet;
pub use baseline::project::{Projection, closest_weights};
pub use baseline::{Baseline, Lengths, Location, holes};
pub use constraints::chain::{Chain, ChainKind};
pub use gaps::CurveGap;
pub use options::SimOptions;
pub use passes::drift::drift;
pub use passes::remesh::{Pass, RemeshReport, remesh};
pub use sim_mesh::{CurveSpan, SimMesh, UvLocation, VertexConstraint};

use crate::mesh::{ChainId, Compact, CornerId, IdVec, VertexId};
use glam::Vec3;

/// A finished simulation mesh with all that transfer needs.
pub struct SimProduct {
    /// The surface that it lies on.
    pub baseline: Baseline,
    /// Positions. \[stage units\]
    pub points: IdVec<VertexId, Vec3>,
    /// The triangles.
    pub triangles: Vec<[VertexId; 3]>,
    /// Target edge length at each vertex. \[stage units\]
    pub target: IdVec<VertexId, f32>,
    /// Place of each corner on the baseline, with the constraint UVs.
    pub places: IdVec<CornerId, UvLocation>,
    /// The edges on each chain, in order and direction of the chain.
    pub chain_edges: IdVec<ChainId, Vec<[VertexId; 2]>>,
    /// Arc length of the chain at the ends of each of those edges. \[stage units\]
    pub chain_arcs: IdVec<ChainId, Vec<[f32; 2]>>,
    /// Where each chain's curve is farthest from those edges.
    pub gaps: IdVec<ChainId, CurveGap>,
    /// What the remesher did.
    pub report: RemeshReport,
}

/// Where an edge starts on its chain, its length there, and its vertices in the chain's direction.
type OnChain = (f32, f32, [VertexId; 2]);

/// Remeshes the surface of `baseline`.
pub fn simulate(baseline: Baseline, iterations: u32, max_faces: usize) -> SimProduct {
    let mut mesh = SimMesh::new(&baseline);
    let report = remesh(&mut mesh, iterations, max_faces);
    let Compact { triangles, old_vertex, old_corner } = mesh.topology.compact();
    let mut new_vertex = IdVec::<VertexId, Option<VertexId>>::filled(None, mesh.points.len());
    old_vertex.enumerated().for_each(|(new, &old)| new_vertex[old] = Some(new));
    let mut on_chain: IdVec<ChainId, Vec<OnChain>> = IdVec::filled(Vec::new(), baseline.chains.len());
    for half in mesh.topology.edges() {
        let Some(span) = mesh.span(half) else { continue };
        let ends = [mesh.topology.vertex(half), mesh.topology.target(half)].map(|v| new_vertex[v]);
        let [Some(a), Some(b)] = ends else { continue };
        let length = baseline.chains[span.chain].length();
        let (from, to) = (span.from.min(span.to), span.from.max(span.to));
        let start = if baseline.chains[span.chain].is_loop { from.rem_euclid(length) } else { from };
        on_chain[span.chain].push((start, to - from, if span.forward { [a, b] } else { [b, a] }));
    }
    for edges in on_chain.iter_mut() {
        // An edge without length comes before the one that starts where it does.
        edges.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    }
    let points: IdVec<VertexId, Vec3> = old_vertex.iter().map(|&v| mesh.points[v]).collect();
    let gaps = on_chain.enumerated().map(|(id, edges)| gaps::gap(&baseline, &baseline.chains[id], edges, &points));
    let gaps = gaps.collect();
    let arcs = |edges: &Vec<OnChain>| edges.iter().map(|&(start, length, _)| [start, start + length]).collect();
    let chain_arcs = on_chain.iter().map(arcs).collect();
    let chain_edges = on_chain.into_vec().into_iter().map(|edges| edges.into_iter().map(|(_, _, e)| e).collect());
    let chain_edges = chain_edges.collect();
    let places: IdVec<CornerId, UvLocation> = old_corner.iter().map(|&c| mesh.place(c)).collect();
    let mut target = IdVec::<VertexId, f32>::filled(0.0, points.len());
    let mut is_known = IdVec::<VertexId, bool>::filled(false, points.len());
    for (&v, place) in triangles.iter().flatten().zip(places.iter()) {
        if !std::mem::replace(&mut is_known[v], true) {
            target[v] = baseline.target_at(place.location);
        }
    }
    SimProduct { points, triangles, target, places, chain_edges, chain_arcs, gaps, report, baseline }
}
