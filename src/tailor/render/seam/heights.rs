//! The heights of seams: their profile across, and what becomes of it where seams meet.
//!
//! ```text
//!         .--------.        The seam on top keeps its profile. A ridge takes up another one within its width, up to its own
//!    ____/  on top  \____    crest; where grooves meet, the deeper one stays. A groove runs through a ridge below it, and a
//!   /    below         \    ridge over a groove, with a slope from two thirds of the width to the outermost line.
//! ```

use super::Seams;
use super::cut::Strand;
use super::profile::{LINES, OUTER};
use crate::render::operator::ControlRole;
use tailor_mesh::connectivity::VertexId;

/// Distance from the edges, as a share of the width, below which a vertex is on them.
const ON_EDGES: f32 = 1e-3;

impl Seams {
    /// The height of the strands of a vertex, the lowest first, and the seam that defines it.
    pub fn height(&self, strands: &[Strand]) -> (f32, usize) {
        let (mut height, mut seam, mut most) = (0.0, strands.first().map_or(0, |strand| strand.seam), 0.0);
        for strand in strands {
            let options = &self.seams[strand.seam].1;
            let (own, crest) = (options.height(strand.basis), options.crest());
            if crest == 0.0 {
                continue;
            }
            let part = strand.share.min(1.0) * ((OUTER - strand.across) / (OUTER - LINES[1])).clamp(0.0, 1.0);
            height = if height * crest > 0.0 {
                let under = if crest > 0.0 { height + part * (height.min(crest) - height) } else { height };
                if own * crest > 0.0 && own.abs() > under.abs() { own } else { under }
            } else {
                own + (1.0 - part) * height
            };
            if own.abs() >= most {
                (seam, most) = (strand.seam, own.abs());
            }
        }
        (height, seam)
    }
}

/// The role of a vertex with some strands.
pub fn role(vertex: VertexId, parents: usize, strands: &[Strand]) -> ControlRole {
    match strands.iter().map(|strand| strand.across).fold(f32::INFINITY, f32::min) {
        across if across < ON_EDGES => ControlRole::Crest,
        across if vertex.index() < parents && across >= 1.0 => ControlRole::Kept,
        _ => ControlRole::Raised,
    }
}
