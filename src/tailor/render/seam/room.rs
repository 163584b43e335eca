//! How fine a cage may be beside a seam: its lines need room in the faces there.

use super::options::SeamOptions;
use tailor_mesh::connectivity::{IdVec, Topology, VertexId};
use tailor_mesh::garment::Mesh;
use tailor_mesh::subdivide::edges_at;

/// Share of an edge beside a seam that half its width may take. The lines reach a third further.
const MAX_SHARE: f32 = 0.5;
/// Share of the edges that may be too short after one level, and after more. The surface gains most from the first one.
const MAX_SHORT: [f32; 2] = [0.5, 0.2];

/// The refinements after which half the width of a seam is still a small enough share of the edges beside it, except for some
/// where it narrows. \[levels\]
pub fn levels(garment: &Mesh, t: &Topology, options: &SeamOptions) -> u32 {
    let mut is_end = IdVec::filled(false, t.vertex_count());
    let mut is_seam = IdVec::filled(false, t.edges.len());
    for [a, b] in options.edges_of(garment) {
        let Some(edge) = t.find_edge(a, b) else { continue };
        (is_seam[edge], is_end[a], is_end[b]) = (true, true, true);
    }
    let beside = is_end.ids().filter(|&v| is_end[v]).flat_map(|v| edges_at(t, v));
    let length = |[a, b]: [VertexId; 2]| garment.points[a].distance(garment.points[b]);
    let mut lengths: Vec<f32> = beside.filter(|&e| !is_seam[e]).map(|e| length(t.edges[e])).collect();
    lengths.sort_unstable_by(f32::total_cmp);
    let levels = |short: f32| {
        let length = lengths.get((short * lengths.len() as f32) as usize).copied().unwrap_or(0.0);
        let room = MAX_SHARE * length / (0.5 * options.width);
        if room >= 1.0 { room.log2() as u32 } else { 0 }
    };
    let [first, more] = MAX_SHORT.map(levels);
    more.max(first.min(1))
}
