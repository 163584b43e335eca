//! How often a garment is refined.

use crate::sim::options::SimOptions;
use crate::sim::surface::lengths::Lengths;
use tailor_mesh::garment::Mesh;

/// Faces from which a garment is dense: refining it further than its target lengths need takes most of the time and memory.
const DENSE: usize = 50_000;
/// Length of an edge that is short enough for the surface. \[target lengths\]
const SHORT: f32 = 0.75;
/// Part of the edges that have to be short.
const MOST: f64 = 0.99;

/// The refinements that give the baseline: those of the options, and fewer for a dense garment whose edges are short
/// enough before, but one at least.
pub fn baseline_level(garment: &Mesh, options: &SimOptions, lengths: Lengths<'_>) -> u32 {
    let most = options.baseline_level;
    if garment.faces.len() < DENSE || most < 2 {
        return most;
    }
    // Edges inside the surface are counted twice.
    let mut missing = vec![0usize; most as usize + 1];
    for corner in garment.faces.corners().ids() {
        let [a, b] = [corner, garment.faces.next(corner)].map(|c| garment.faces.corners()[c]);
        let target = lengths.at(a).min(lengths.at(b));
        let ratio = garment.points[a].distance(garment.points[b]) / (SHORT * target);
        // Each refinement halves the edges. A ratio that is not a number needs all.
        let needed = (1..most).find(|&level| ratio <= (1u32 << level) as f32).unwrap_or(most);
        missing[needed as usize] += 1;
    }
    let allowed = ((1.0 - MOST) * garment.faces.corners().len() as f64) as usize;
    (1..most).find(|&level| missing[level as usize + 1..].iter().sum::<usize>() <= allowed).unwrap_or(most)
}
