//! Which seam lies on which, and in which passes their lines are cut.
//!
//! A later seam lies on an earlier one, as a tailor sews it last. A seam that ends at another one is tucked under it.

use super::chains::Network;
use tailor_mesh::connectivity::{Topology, VertexId};

/// The order of some seams.
pub struct Order {
    /// The place of each seam from below.
    pub rank: Vec<usize>,
    /// The seams that are cut together: those of later passes end at those of earlier ones, or cross them.
    pub passes: Vec<Vec<usize>>,
}

impl Order {
    /// The order of the seams of a network.
    pub fn new(t: &Topology, network: &Network, seams: usize) -> Self {
        // For each seam, the ones that it ends at and the ones that it meets in any way but end to end.
        let (mut bars, mut met) = (vec![Vec::new(); seams], vec![Vec::new(); seams]);
        for vertex in (0..t.vertex_count()).map(VertexId::new) {
            let here = network.counts_at(t, vertex);
            for &(seam, count) in &here {
                let others = here.iter().filter(|other| other.0 != seam);
                for &(other, its) in others.filter(|other| count > 1 || other.1 > 1) {
                    met[seam].push(other);
                    if count == 1 && its > 1 {
                        bars[seam].push(other);
                    }
                }
            }
        }
        let mut from_below: Vec<usize> = Vec::with_capacity(seams);
        for seam in 0..seams {
            let below = from_below.iter().position(|other| bars[seam].contains(other)).unwrap_or(from_below.len());
            from_below.insert(below, seam);
        }
        let (mut rank, mut pass) = (vec![0; seams], vec![None; seams]);
        from_below.iter().enumerate().for_each(|(place, &seam)| rank[seam] = place);
        let mut passes: Vec<Vec<usize>> = Vec::new();
        for &seam in from_below.iter().rev() {
            let after = met[seam].iter().filter_map(|&other| pass[other]).max().map_or(0, |last: usize| last + 1);
            pass[seam] = Some(after);
            passes.resize_with(passes.len().max(after + 1), Vec::new);
            passes[after].push(seam);
        }
        Self { rank, passes }
    }
}
