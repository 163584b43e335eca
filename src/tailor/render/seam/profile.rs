//! The profile of a seam across: its lines and their heights.

use super::options::SeamOptions;

/// Lines of each side as shares of its width: two on the flank, one at the width, and the support loop outside.
pub const LINES: [f32; 4] = [1.0 / 3.0, 2.0 / 3.0, 1.0, 4.0 / 3.0];

/// The outermost line.
pub const OUTER: f32 = LINES[LINES.len() - 1];

/// The shares of the offset and of the depth that the height is the sum of, at a share of the width from the centre. They are
/// straight between lines.
pub fn basis_at(across: f32) -> [f32; 2] {
    let centre = [1.0, 0.0];
    let flank = [1.0 - LINES[0], 1.0];
    let between = |a: [f32; 2], b: [f32; 2], part: f32| [0, 1].map(|i| a[i] + part.clamp(0.0, 1.0) * (b[i] - a[i]));
    if across < LINES[0] {
        between(centre, flank, across / LINES[0])
    } else {
        between(flank, [0.0; 2], (across - LINES[0]) / (LINES[1] - LINES[0]))
    }
}

impl SeamOptions {
    /// The height with shares of the offset and of the depth.
    pub(super) fn height(&self, [offset, depth]: [f32; 2]) -> f32 {
        offset * self.normal_offset + depth * self.depth
    }

    /// The height at a share of the width from the centre.
    pub(super) fn profile_at(&self, across: f32) -> f32 {
        self.height(basis_at(across))
    }

    /// The height of the centre, or of the flank where that is further from the surface.
    pub(super) fn crest(&self) -> f32 {
        let [centre, flank] = [self.profile_at(0.0), self.profile_at(LINES[0])];
        if flank.abs() > centre.abs() { flank } else { centre }
    }
}
