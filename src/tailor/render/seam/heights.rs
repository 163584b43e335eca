//! The heights of seams: their profile across, and what becomes of it where seams meet.
//!
//! At a junction, the ridge of the seam that *goes through* keeps its height and width, and others end against it. A seam
//! with two edges there goes through before one that ends there, and a later one lies on an earlier one. Grooves meet at
//! their depths.

use super::Seams;
use super::profile::WIDTH_LINE;
use crate::render::operator::ControlRole;

/// A line of a seam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeamLine {
    /// Index of the seam.
    pub seam: usize,
    /// Index of the line, from 0 nearest to the edge; none on the edge itself.
    pub line: Option<usize>,
}

/// The part of a seam's profile that a vertex has. `share` is the share of its height: 1, less near an end or where the seam
/// is narrowed.
#[derive(Clone, Debug, PartialEq)]
pub enum Part {
    /// On an edge of these seams.
    Centre { seams: Vec<usize>, share: f32 },
    /// On a line beside an edge.
    Line { strand: SeamLine, share: f32 },
    /// Where a line of the seam that goes through a junction crosses one that ends against it.
    Crossing { through: SeamLine, other: SeamLine, share: f32 },
}

impl Part {
    /// The role of a control with this part.
    pub fn role(&self) -> ControlRole {
        match self {
            Self::Centre { .. } => ControlRole::Crest,
            Self::Crossing { through, other, .. } if through.line.is_none() || other.line.is_none() => {
                ControlRole::Crest
            }
            _ => ControlRole::Raised,
        }
    }

    /// Indices of its seams.
    pub fn seams(&self) -> Vec<usize> {
        match self {
            Self::Centre { seams, .. } => seams.clone(),
            Self::Line { strand, .. } => vec![strand.seam],
            Self::Crossing { through, other, .. } => vec![through.seam, other.seam],
        }
    }
}

impl Seams {
    /// The height of a part, and the seam that defines it.
    pub fn height(&self, part: &Part) -> (f32, usize) {
        let own = |strand: SeamLine| (self.profile(strand), strand.seam);
        let (share, (height, seam)) = match part {
            Part::Centre { seams, share } => {
                let heights = seams.iter().map(|&seam| own(SeamLine { seam, line: None }));
                (share, heights.reduce(junction).unwrap_or((0.0, 0)))
            }
            Part::Line { strand, share } => (share, own(*strand)),
            Part::Crossing { through, other, share } => (share, self.crossing(*through, *other)),
        };
        (share * height, seam)
    }

    /// The height of a seam's line over the surface.
    fn profile(&self, SeamLine { seam, line }: SeamLine) -> f32 {
        self.seams[seam].1.profile(line)
    }

    /// The height where a line of one seam crosses that of another which goes through.
    fn crossing(&self, through: SeamLine, other: SeamLine) -> (f32, usize) {
        let [offset, other_offset] = [through, other].map(|strand| self.seams[strand.seam].1.normal_offset);
        let (own, its) = ((self.profile(through), through.seam), (self.profile(other), other.seam));
        if offset < 0.0 && other_offset < 0.0 {
            return if its.0 < own.0 { its } else { own };
        }
        if offset == 0.0 {
            return its;
        }
        // Within its width a ridge takes up another one, up to its own height.
        let taken = (its.0.min(offset), its.1);
        let within = if through.line.is_some() && taken.0 > own.0.max(0.0) { taken } else { own };
        match through.line {
            Some(line) if line > WIDTH_LINE => its,
            // Between, the other one is halfway: it would be a step if it rose from one line to the next.
            Some(line) if line == WIDTH_LINE => (0.5 * (within.0 + its.0), its.1),
            _ => within,
        }
    }
}

/// The height where the edges of seams meet: the depth of the deeper of two grooves, or else the height of the seam that
/// goes through.
fn junction(through: (f32, usize), other: (f32, usize)) -> (f32, usize) {
    let are_grooves = through.0 < 0.0 && other.0 < through.0;
    if through.0 == 0.0 || are_grooves { other } else { through }
}
