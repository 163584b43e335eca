//! The profile of a seam across: its lines and their heights.

use super::options::SeamOptions;

/// Lines of each side as shares of its width: two on the flank, one at the width, and the support loop outside.
pub const LINES: [f32; 4] = [1.0 / 3.0, 2.0 / 3.0, 1.0, 4.0 / 3.0];

/// Index of the line at the width. Lines before it are on the flank.
pub const WIDTH_LINE: usize = LINES.len() - 2;

impl SeamOptions {
    /// The height of a line over the surface; of the centre for none.
    pub(super) fn profile(&self, line: Option<usize>) -> f32 {
        match line {
            None => self.normal_offset,
            Some(0) => (1.0 - LINES[0]) * self.normal_offset + self.depth,
            _ => 0.0,
        }
    }

    /// The height at a share of the width from the centre, straight between lines.
    pub(super) fn profile_at(&self, share: f32) -> f32 {
        let next = LINES.iter().position(|&line| line > share);
        let Some(next) = next else { return 0.0 };
        let (before, line) = next.checked_sub(1).map_or((0.0, None), |line| (LINES[line], Some(line)));
        let part = (share - before) / (LINES[next] - before);
        (1.0 - part) * self.profile(line) + part * self.profile(Some(next))
    }
}
