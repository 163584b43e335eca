//! Polylines on the baseline, from which distances are measured.

use glam::Vec3;
use tailor_mesh::connectivity::{IdVec, VertexId};

/// Segments that a search for the nearest point looks ahead.
const LOOK_AHEAD: usize = 3;

/// A path on the baseline.
pub(super) struct Polyline {
    segments: Vec<Segment>,
    /// \[mesh units\]
    pub length: f32,
    pub is_closed: bool,
}

struct Segment {
    from: Vec3,
    step: Vec3,
    /// Reciprocal of the squared length.
    inverse: f32,
    /// Length of the polyline before it, and its own. \[mesh units\]
    along: f32,
    length: f32,
}

/// The point of a polyline nearest to another point.
#[derive(Clone, Copy)]
pub(super) struct PolylinePoint {
    pub segment: usize,
    /// Arc length. \[mesh units\]
    pub s: f32,
    /// \[mesh units\]
    pub distance: f32,
}

impl Polyline {
    pub fn new(vertices: &[VertexId], points: &IdVec<VertexId, Vec3>, is_closed: bool) -> Self {
        let mut length = 0.0;
        let segment = |pair: &[VertexId]| {
            let (from, step) = (points[pair[0]], points[pair[1]] - points[pair[0]]);
            let inverse = step.length_squared().max(f32::MIN_POSITIVE).recip();
            let segment = Segment { from, step, inverse, along: length, length: step.length() };
            length += segment.length;
            segment
        };
        let segments = vertices.windows(2).map(segment).collect();
        Self { segments, length, is_closed }
    }

    /// The parameter of the nearest point of a segment, 0 to 1, and its squared distance.
    fn on_segment(&self, segment: usize, point: Vec3) -> (f32, f32) {
        let Segment { from, step, inverse, .. } = self.segments[segment];
        let t = ((point - from).dot(step) * inverse).clamp(0.0, 1.0);
        (t, (from + t * step).distance_squared(point))
    }

    /// The nearest point that a descent from the segment `start` reaches, a few segments at a time in both directions.
    pub fn nearest(&self, point: Vec3, start: usize) -> PolylinePoint {
        let n = self.segments.len();
        let start = start.min(n - 1);
        let (mut best, mut at) = (self.on_segment(start, point), start);
        // Numbers of segments ahead and behind that are visited, and that are to be visited.
        let mut seen = [0, 0];
        let mut reach = [LOOK_AHEAD; 2];
        while seen != reach {
            for direction in 0..2 {
                while seen[direction] < reach[direction] {
                    seen[direction] += 1;
                    let Some(other) = self.step(start, seen[direction], direction == 0) else { continue };
                    let there = self.on_segment(other, point);
                    if there.1 < best.1 {
                        (best, at) = (there, other);
                        reach[direction] = (seen[direction] + LOOK_AHEAD).min(n);
                    }
                }
            }
        }
        let segment = &self.segments[at];
        PolylinePoint { segment: at, s: segment.along + best.0 * segment.length, distance: best.1.sqrt() }
    }

    /// The segment some steps ahead of one, or behind it; none beyond the ends of an open polyline.
    fn step(&self, from: usize, steps: usize, is_ahead: bool) -> Option<usize> {
        let n = self.segments.len();
        match (self.is_closed, is_ahead) {
            (true, true) => Some((from + steps) % n),
            (true, false) => Some((from + n - steps % n) % n),
            (false, true) => Some(from + steps).filter(|&k| k < n),
            (false, false) => from.checked_sub(steps),
        }
    }
}
