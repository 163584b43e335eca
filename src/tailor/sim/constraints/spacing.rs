//! Spacing of vertices along a chain: its corners, and edge lengths short enough to follow its bends.

use super::chain::{Chain, CurvePoint, fraction, segment_of};
use crate::sim::geometry::angle;
use glam::Vec3;
use std::collections::BTreeSet;
use tailor_mesh::connectivity::{IdVec, VertexId};

/// Corners are at least this far from each other and from the ends, as a share of the target length. Smaller values make
/// shorter edges in small details, larger ones let chords cut those off.
const CORNER_DISTANCE: f32 = 0.2;
/// A chord may leave its curve by this share of the target length. Smaller values make shorter edges where curves bend.
const SAGITTA: f32 = 0.02;
/// Bends shorten edges to no less than this share of the target length: triangles beside shorter ones would be thin.
pub const SHORTEST: f32 = 0.6;

/// Edges between two nearby corners or ends of a chain shorten to the distance between them, but to no less than this
/// share of the target length. That makes the triangles there less thin. At 0.35 a fifth fewer are thin where corners are
/// close, and lengths are 2 % less even; without it male_worksuit01 has half as many thin ones again.
const SHORTEST_BETWEEN_CORNERS: f32 = 0.4;
/// The share on feature lines, whose corners belong to small details. 0.3 and 0.4 both leave a tenth more thin triangles on
/// male_worksuit01.
const SHORTEST_BETWEEN_FEATURE_CORNERS: f32 = 0.35;
/// Corners nearer than this share of the target length shorten nothing: triangles between them are thin at any length, and
/// shorter edges make more of them.
const CLOSEST: f32 = 0.2;

/// Segments of a curve that a turn is summed over on each side at most. Targets much longer than the edges of the baseline would
/// have each turn take the whole curve.
const MAX_SEGMENTS: usize = 512;

/// Largest change of edge length per length along the curve, so that neighbouring edges are similar.
const GRADING: f32 = 0.3;

impl Chain {
    /// Finds the corners of the curve and the lengths of edges that follow it. `target` is the target length
    /// at each vertex of the baseline; a curve that turns by more than `corner` within one target length has a corner at the
    /// vertex there, if that may be one. \[radians\]
    pub fn space(
        &mut self,
        points: &IdVec<VertexId, Vec3>,
        target: &IdVec<VertexId, f32>,
        may_be_corner: impl Fn(VertexId) -> bool,
        corner: f32,
    ) {
        let turns = self.turns(points);
        let targets: Vec<f32> = self.vertices.iter().map(|&v| target[v]).collect();
        self.pins = self.corners(&turns, &targets, may_be_corner, corner);
        let mut smooth = turns;
        self.pins.iter().for_each(|&pin| smooth[pin] = 0.0);
        self.lengths = (0..self.vertices.len())
            .map(|i| {
                let bend = self.turn_around(&smooth, i, 0.5 * targets[i]) / targets[i];
                // A chord of length l on a circle of curvature k leaves it by l² k / 8.
                let longest = (8.0 * SAGITTA * targets[i] / bend.max(f32::MIN_POSITIVE)).sqrt();
                longest.clamp(SHORTEST * targets[i], targets[i])
            })
            .collect();
        self.shorten_between_corners(&targets);
        self.grade_lengths();
        let mut sum = 0.0f64;
        let advance = |(along, lengths): (&[f32], &[f32])| {
            let mean = 0.5 * (1.0 / lengths[0] + 1.0 / lengths[1]);
            sum += f64::from((along[1] - along[0]) * mean);
            sum as f32
        };
        let spaced = self.along.windows(2).zip(self.lengths.windows(2)).map(advance);
        self.spaced = std::iter::once(0.0).chain(spaced).collect();
    }

    /// Shortens lengths where corners or ends are near each other.
    fn shorten_between_corners(&mut self, targets: &[f32]) {
        let last = self.vertices.len() - 1;
        let mut stops = self.pins.clone();
        match (self.is_loop, stops.first()) {
            (true, Some(&first)) => stops.push(first + last),
            (true, None) => {}
            (false, _) => {
                stops.insert(0, 0);
                stops.push(last);
            }
        }
        let shortest = if self.kind.feature { SHORTEST_BETWEEN_FEATURE_CORNERS } else { SHORTEST_BETWEEN_CORNERS };
        for pair in stops.windows(2) {
            let at = |i: usize| self.along[i % last] + if i >= last { self.length() } else { 0.0 };
            let gap = at(pair[1]) - at(pair[0]);
            for i in (pair[0]..=pair[1]).map(|i| if i > last { i - last } else { i }) {
                if gap > CLOSEST * targets[i] {
                    let wanted = gap.max(shortest * targets[i]);
                    self.lengths[i] = self.lengths[i].min(wanted);
                }
            }
        }
    }

    /// Makes lengths change gradually along the curve. A loop takes two rounds.
    fn grade_lengths(&mut self) {
        let n = self.lengths.len();
        for _ in 0..if self.is_loop { 2 } else { 1 } {
            for i in 1..n {
                let most = self.lengths[i - 1] + GRADING * (self.along[i] - self.along[i - 1]);
                self.lengths[i] = self.lengths[i].min(most);
            }
            for i in (1..n).rev() {
                let most = self.lengths[i] + GRADING * (self.along[i] - self.along[i - 1]);
                self.lengths[i - 1] = self.lengths[i - 1].min(most);
            }
            if self.is_loop {
                let least = self.lengths[0].min(self.lengths[n - 1]);
                self.lengths[0] = least;
                self.lengths[n - 1] = least;
            }
        }
    }

    /// Target edge length at a point of the curve. \[mesh units\]
    pub fn length_at(&self, at: CurvePoint) -> f32 {
        let (a, b) = (self.lengths[at.segment], self.lengths[at.segment + 1]);
        a + (b - a) * at.t
    }

    /// The angle by which the curve turns at each vertex. \[radians\]
    fn turns(&self, points: &IdVec<VertexId, Vec3>) -> Vec<f32> {
        let n = self.vertices.len();
        let at = |i: usize| points[self.vertices[i]];
        let turn = |a: usize, b: usize, c: usize| angle(at(b) - at(a), at(c) - at(b));
        let inside = 1..n.saturating_sub(1);
        let mut turns: Vec<f32> =
            (0..n).map(|i| if inside.contains(&i) { turn(i - 1, i, i + 1) } else { 0.0 }).collect();
        if self.is_loop && n > 2 {
            turns[0] = turn(n - 2, 0, 1);
            turns[n - 1] = turns[0];
        }
        turns
    }

    /// The turn within `reach` of a vertex, in both directions along the curve. \[radians\]
    fn turn_around(&self, turns: &[f32], vertex: usize, reach: f32) -> f32 {
        let n = turns.len() - 1;
        let length = self.length();
        let mut sum = turns[vertex];
        for forward in [true, false] {
            let (mut i, mut passed) = (vertex, 0.0);
            for _ in 0..MAX_SEGMENTS {
                if passed >= length {
                    break;
                }
                let to = match (forward, self.is_loop) {
                    (true, _) if i < n => i + 1,
                    (false, _) if i > 0 => i - 1,
                    (true, true) => 1,
                    (false, true) => n - 1,
                    _ => break,
                };
                let segment = if forward { to } else { to + 1 };
                passed += self.along[segment] - self.along[segment - 1];
                if passed > reach || to == vertex {
                    break;
                }
                sum += turns[to];
                i = to;
            }
        }
        sum
    }

    /// Indices of the cage's vertices at which the curve has a corner. Of two that are too close the sharper stays.
    fn corners(
        &self,
        turns: &[f32],
        targets: &[f32],
        may_be_corner: impl Fn(VertexId) -> bool,
        corner: f32,
    ) -> Vec<usize> {
        let n = self.vertices.len() - 1;
        let inside = if self.is_loop { 0..n } else { 1..n };
        let mut found: Vec<(f32, usize)> = inside
            .filter(|&i| may_be_corner(self.vertices[i]))
            .map(|i| (self.turn_around(turns, i, 0.5 * targets[i]), i))
            .filter(|&(turn, _)| turn > corner)
            .collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut pins: BTreeSet<usize> = if self.is_loop { BTreeSet::new() } else { [0, n].into() };
        for (_, i) in found {
            let is_apart = |&pin: &usize| {
                let d = (self.along[i] - self.along[pin]).abs();
                let d = if self.is_loop { d.min(self.length() - d) } else { d };
                d >= CORNER_DISTANCE * targets[i]
            };
            // The nearest on both sides, around a loop too.
            let before = pins.range(..i).next_back().or(pins.last());
            let after = pins.range(i..).next().or(pins.first());
            if before.into_iter().chain(after).all(is_apart) {
                pins.insert(i);
            }
        }
        pins.into_iter().filter(|&pin| self.is_loop || (1..n).contains(&pin)).collect()
    }

    /// Number of edges that the curve asks for up to arc length `s`, as a real number.
    pub fn count_to(&self, s: f32) -> f32 {
        let (turns, at) = self.at_with_turns(s);
        self.count_at(turns, at)
    }

    /// Number of edges up to a point that lies beyond `turns` full turns of a loop.
    pub fn count_at(&self, turns: f32, at: CurvePoint) -> f32 {
        let (a, b) = (self.spaced[at.segment], self.spaced[at.segment + 1]);
        turns * self.edge_count() + a + (b - a) * at.t
    }

    fn edge_count(&self) -> f32 {
        self.spaced[self.spaced.len() - 1]
    }

    /// The arc length at which the curve asks for `count` edges; the inverse of [`Self::count_to`]. \[mesh units\]
    pub fn at_count(&self, count: f32) -> f32 {
        let all = self.edge_count();
        let turn = if self.is_loop && all > 0.0 { (count / all).floor() } else { 0.0 };
        let rest = (count - turn * all).clamp(0.0, all);
        let i = segment_of(&self.spaced, rest);
        turn * self.length() + self.along[i] + (self.along[i + 1] - self.along[i]) * fraction(&self.spaced, rest, i)
    }
}
