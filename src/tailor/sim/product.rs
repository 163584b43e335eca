//! The finished simulation mesh.

use super::baseline::Baseline;
use super::constraints::chain::Chain;
use super::geometry::distance_to_segment;
use super::options::SimOptions;
use super::passes::remesh::{RemeshReport, remesh};
use super::shell_uvs::separate_shells;
use super::sides::{Sides, part_from_plane};
use super::sim_mesh::{BaselineUvPoint, SimMesh};
use glam::Vec3;
use tailor_mesh::connectivity::{ChainId, Compact, CornerId, FaceId, IdVec, VertexId};

/// A finished simulation mesh with all that transfer needs.
pub struct SimProduct {
    /// The surface that it lies on.
    pub baseline: Baseline,
    /// Positions. \[mesh units\]
    pub points: IdVec<VertexId, Vec3>,
    /// The triangles.
    pub triangles: Vec<[VertexId; 3]>,
    /// Target edge length at each vertex. \[mesh units\]
    pub target: IdVec<VertexId, f32>,
    /// Location of each corner on the baseline, with the constraint UVs.
    pub places: IdVec<CornerId, BaselineUvPoint>,
    /// The edges on each chain, in order and direction of the chain.
    pub chain_edges: IdVec<ChainId, Vec<[VertexId; 2]>>,
    /// Arc length of the chain at the ends of each of those edges. \[mesh units\]
    pub chain_arcs: IdVec<ChainId, Vec<[f32; 2]>>,
    /// The largest gap between each chain's curve and those edges.
    pub gaps: IdVec<ChainId, CurveGap>,
    /// Rounds and edits of the remesher.
    pub report: RemeshReport,
}

impl SimProduct {
    /// The baseline's triangle under the centroid of a triangle: the nearest of those that walks from its corners find.
    pub fn triangle_under(&self, triangle: FaceId) -> FaceId {
        let centroid = self.triangles[triangle.index()].map(|v| self.points[v]).iter().sum::<Vec3>() / 3.0;
        let starts = [0, 1, 2].map(|k| self.places[CornerId::new(3 * triangle.index() + k)].location.face);
        self.baseline.closest_from(starts, centroid).location.face
    }

    /// The garment's face under the centroid of a triangle.
    pub fn source_face(&self, triangle: FaceId) -> FaceId {
        self.baseline.source_face[self.triangle_under(triangle)]
    }
}

/// The point of a chain's curve that lies farthest from the edges that follow it.
#[derive(Clone, Copy, Debug)]
pub struct CurveGap {
    /// The distance, as a share of the target length there.
    pub distance: f32,
    /// The garment's vertex on the chain nearest to that point, counted along the curve.
    pub near: VertexId,
}

/// An edge of the finished mesh on a chain.
#[derive(Clone, Copy)]
pub(super) struct ChainEdge {
    /// Arc length at its start. \[mesh units\]
    pub start: f32,
    /// Its extent along the curve. \[mesh units\]
    pub length: f32,
    /// Its vertices in the chain's direction.
    pub ends: [VertexId; 2],
}

/// Remeshes the surface of `baseline`.
pub fn simulate(baseline: Baseline, options: &SimOptions, max_faces: usize) -> SimProduct {
    let mut mesh = SimMesh::new(&baseline);
    let report = remesh(&mut mesh, options, max_faces);
    let shared = part_from_plane(&mut mesh);
    let Compact { triangles, old_vertex, old_corner } = mesh.topology.compact();
    let points: IdVec<VertexId, Vec3> = old_vertex.iter().map(|&v| mesh.points[v]).collect();
    let places: IdVec<CornerId, BaselineUvPoint> = old_corner.iter().map(|&c| mesh.place(c)).collect();
    let edges = chain_edges(&mesh, &old_vertex);
    let twin = old_vertex.enumerated().map(|(v, old)| shared.contains(old).then_some(v)).collect();
    let sides = Sides { baseline: &baseline, points, triangles, places, edges, twin };
    let Sides { points, triangles, mut places, mut edges, .. } = sides.copied();
    for edges in edges.iter_mut() {
        // An edge of zero length comes before the one that starts at the same point.
        edges.sort_by(|a, b| a.start.total_cmp(&b.start).then(a.length.total_cmp(&b.length)));
    }
    separate_shells(&baseline, &points, &triangles, &mut places);
    let gaps = edges.enumerated().map(|(id, edges)| curve_gap(&baseline, &baseline.chains[id], edges, &points));
    let arcs = |edges: &Vec<ChainEdge>| edges.iter().map(|e| [e.start, e.start + e.length]).collect();
    SimProduct {
        target: targets(&baseline, &triangles, &places, points.len()),
        gaps: gaps.collect(),
        chain_arcs: edges.iter().map(arcs).collect(),
        chain_edges: edges.iter().map(|edges| edges.iter().map(|e| e.ends).collect()).collect(),
        points,
        triangles,
        places,
        report,
        baseline,
    }
}

/// The edges on each chain; `old_vertex` is the mesh's vertex behind each vertex.
fn chain_edges(mesh: &SimMesh<'_>, old_vertex: &IdVec<VertexId, VertexId>) -> IdVec<ChainId, Vec<ChainEdge>> {
    let chains = &mesh.baseline.chains;
    let mut new_vertex: IdVec<VertexId, VertexId> = mesh.points.ids().collect();
    old_vertex.enumerated().for_each(|(new, &old)| new_vertex[old] = new);
    let mut on_chain: IdVec<ChainId, Vec<ChainEdge>> = IdVec::filled(Vec::new(), chains.len());
    for (half, span) in mesh.topology.edges().filter_map(|half| Some((half, mesh.span(half)?))) {
        let [a, b] = mesh.topology.ends(half).map(|v| new_vertex[v]);
        let (from, to) = (span.from.min(span.to), span.from.max(span.to));
        let chain = &chains[span.chain];
        let start = if chain.is_loop { from.rem_euclid(chain.length()) } else { from };
        let ends = if span.forward { [a, b] } else { [b, a] };
        on_chain[span.chain].push(ChainEdge { start, length: to - from, ends });
    }
    on_chain
}

/// Target edge length at each vertex, at the location of its first corner. \[mesh units\]
fn targets(
    baseline: &Baseline,
    triangles: &[[VertexId; 3]],
    places: &IdVec<CornerId, BaselineUvPoint>,
    vertices: usize,
) -> IdVec<VertexId, f32> {
    let mut first = IdVec::<VertexId, CornerId>::filled(CornerId::new(0), vertices);
    triangles.as_flattened().iter().enumerate().rev().for_each(|(corner, &v)| first[v] = CornerId::new(corner));
    first.iter().map(|&corner| baseline.target_at(places[corner].location)).collect()
}

/// The largest gap of a chain; `edges` are all of its edges, and `points` the positions of the mesh.
fn curve_gap(baseline: &Baseline, chain: &Chain, edges: &[ChainEdge], points: &IdVec<VertexId, Vec3>) -> CurveGap {
    let (last, step) = (chain.vertices.len() - 1, chain.step());
    let mut largest = CurveGap { distance: 0.0, near: chain.cage[0] };
    for &ChainEdge { start, length, ends: [a, b] } in edges {
        let first = chain.along.partition_point(|&s| s <= start);
        // A loop's edge may cover the point where its curve begins.
        let rest = start + length - chain.length();
        let ahead = (first..=last).take_while(|&i| chain.along[i] < start + length);
        let wrapped = (1..last).take_while(|&i| chain.is_loop && chain.along[i] < rest);
        for i in ahead.chain(wrapped) {
            let vertex = chain.vertices[i];
            let distance = distance_to_segment(baseline.points[vertex], points[a], points[b]) / baseline.target[vertex];
            if distance > largest.distance {
                largest = CurveGap { distance, near: chain.cage[(i + step / 2) / step] };
            }
        }
    }
    largest
}
