//! How fine a cage may be beside a seam: its lines need room in the faces there.

use super::options::SeamOptions;
use glam::Vec3;
use tailor_mesh::connectivity::{EdgeId, IdVec, Topology, VertexId};
use tailor_mesh::garment::Mesh;
use tailor_mesh::subdivide::edges_at;

/// Share of the room beside a seam that half its width may take. The lines reach a third further.
const MAX_SHARE: f32 = 0.5;
/// Share of the places that may be too narrow after one level, and after more. The surface gains most from the first one.
const MAX_SHORT: [f32; 2] = [0.5, 0.2];

/// The refinements after which half the width of a seam is still a small enough share of the room beside it, except for some
/// places where it narrows. \[levels\]
pub fn levels(garment: &Mesh, t: &Topology, options: &SeamOptions) -> u32 {
    let mut is_seam = IdVec::filled(false, t.edges.len());
    let edges = options.edges_of(garment);
    edges.iter().filter_map(|&[a, b]| t.find_edge(a, b)).for_each(|edge| is_seam[edge] = true);
    let mut ends: Vec<VertexId> = is_seam.ids().filter(|&e| is_seam[e]).flat_map(|e| t.edges[e]).collect();
    ends.sort_unstable();
    ends.dedup();
    let mut rooms: Vec<f32> = ends.iter().flat_map(|&v| rooms_at(garment, t, &is_seam, v)).collect();
    rooms.sort_unstable_by(f32::total_cmp);
    let levels = |short: f32| {
        let room = rooms.get((short * rooms.len() as f32) as usize).copied().unwrap_or(0.0);
        let room = MAX_SHARE * room / (0.5 * options.width);
        if room >= 1.0 { room.log2() as u32 } else { 0 }
    };
    let [first, more] = MAX_SHORT.map(levels);
    more.max(first.min(1))
}

/// How far the other edges at a vertex of a seam lead away from the seam: in skewed faces less than they are long. Those at its
/// end may lead on along it. \[mesh units\]
fn rooms_at(garment: &Mesh, t: &Topology, is_seam: &IdVec<EdgeId, bool>, vertex: VertexId) -> Vec<f32> {
    let along =
        |edge: EdgeId| t.edges[edge].map(|v| garment.points[v] - garment.points[vertex]).into_iter().sum::<Vec3>();
    let (seams, others): (Vec<EdgeId>, Vec<EdgeId>) = edges_at(t, vertex).partition(|&edge| is_seam[edge]);
    let seams: Vec<Vec3> = seams.into_iter().map(|edge| along(edge).normalize_or_zero()).collect();
    let is_end = seams.iter().all(|&direction| direction == seams[0]);
    let room = |edge: Vec3| match is_end {
        true => edge.length(),
        false => seams.iter().map(|&seam| edge.cross(seam).length()).fold(0.0, f32::max),
    };
    others.into_iter().map(|edge| room(along(edge))).collect()
}
