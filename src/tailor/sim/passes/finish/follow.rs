//! Follow: vertices of chains slide to where the chords beside them are near the curve. Relaxation puts them where triangles
//! are even; how far a chord cuts off a bend depends on its ends.

use super::polish::{FanAngles, THIN_COSINE, fan_angles, try_move, with_rings};
use crate::sim::passes::split::FAR;
use crate::sim::sim_mesh::{CurveSpan, Destination, SimMesh, VertexConstraint};
use glam::Vec3;
use rayon::prelude::*;
use tailor_mesh::connectivity::{ChainId, VertexId};

/// A curve is off its chord at more than this share of the target length, just below what users see as a gap.
const OFF: f32 = 0.0195;
/// Samples of the distance on each chord.
const SAMPLES: u8 = 8;
/// Range of the search, as a share of the chord. A smaller share leaves 0.2 % more of the curves off.
const REACH: f32 = 0.4;
/// Positions that the search tries in each direction.
const TRIALS: i8 = 8;
/// Weight of the angles' cost against the length of curve that is off, in target lengths. A larger value leaves more off;
/// without it the 5th percentile of the smallest angle is 0.1 degrees less.
const ANGLE_WEIGHT: f32 = 0.1;
/// Least gain of a move, in target lengths.
const MIN_GAIN: f32 = 0.01;
/// Passes; the second uses the freedom that moves of neighbours gave: 0.1 to 0.3 % less of the curves is off on the garments
/// with most of it.
const PASSES: usize = 2;

/// The chords at a vertex of a chain.
struct Chords {
    chain: ChainId,
    /// Arc lengths of the neighbour before, the vertex and the neighbour after. \[mesh units\]
    along: [f32; 3],
    /// Positions of the neighbours. \[mesh units\]
    ends: [Vec3; 2],
}

/// The distance of a curve from its chords, in target lengths.
#[derive(Clone, Copy)]
struct ChordError {
    /// Length of the curve that is off.
    length: f32,
    /// The largest distance.
    farthest: f32,
}

/// Slides the vertices of chains, in the order of their ids, so that the result is the same for any number of threads.
/// Returns the number of moves.
pub fn follow_curves(mesh: &mut SimMesh<'_>) -> usize {
    let vertices = (0..mesh.topology.vertex_slots()).into_par_iter().map(VertexId::new);
    let is_off = |&v: &VertexId| mesh.chords(v).is_some_and(|chords| mesh.chord_error(&chords, 0.0).length > 0.0);
    let mut waiting: Vec<VertexId> = vertices.filter(is_off).collect();
    let mut moves = 0;
    for _ in 0..PASSES {
        waiting.retain(|&v| follow(mesh, v));
        moves += waiting.len();
        waiting = with_rings(mesh, &waiting);
    }
    mesh.debug_check();
    moves
}

/// Slides a vertex to the best position that a search finds. Returns whether it moved.
fn follow(mesh: &mut SimMesh<'_>, vertex: VertexId) -> bool {
    let Some(chords) = mesh.chords(vertex) else { return false };
    let before = mesh.chord_error(&chords, 0.0);
    if before.length == 0.0 {
        return false;
    }
    let old = fan_angles(mesh, vertex, mesh.points[vertex]);
    let is_thin = |now: &FanAngles| now.worst > old.worst.max(THIN_COSINE);
    let [from, own, to] = chords.along;
    let cost = |by: f32| {
        let there = mesh.on_curve(chords.chain, own + by);
        let now = Some(fan_angles(mesh, vertex, there)).filter(|now| !is_thin(now))?;
        let error = mesh.chord_error(&chords, by);
        // Farther chords are split.
        let is_far = error.farthest > before.farthest.max(FAR);
        (!is_far).then_some(error.length + ANGLE_WEIGHT * (now.cost - old.cost).max(0.0))
    };
    let trials = (-TRIALS..=TRIALS).filter(|&k| k != 0).map(|k| {
        let chord = if k < 0 { own - from } else { to - own };
        REACH * chord * f32::from(k) / f32::from(TRIALS)
    });
    let best = trials.filter_map(|by| Some((cost(by)?, by))).min_by(|a, b| a.0.total_cmp(&b.0));
    let goal = best.filter(|&(cost, _)| cost < before.length - MIN_GAIN).map(|(_, by)| Destination::Along(by));
    goal.is_some_and(|goal| try_move(mesh, vertex, goal, |_| true))
}

impl SimMesh<'_> {
    /// The chords at a vertex that slides.
    fn chords(&self, vertex: VertexId) -> Option<Chords> {
        if !matches!(self.constraint[vertex], VertexConstraint::OnCurve(_)) {
            return None;
        }
        let near = self.curve_neighbours(vertex)?;
        let CurveSpan { chain, from, to, .. } = near.before;
        let ends = [near.back, near.ahead].map(|half| self.points[self.topology.other_end(half, vertex)]);
        Some(Chords { chain, along: [from, to, to + near.after.to - near.after.from], ends })
    }

    /// The error of the chords beside a vertex if it slides.
    fn chord_error(&self, chords: &Chords, by: f32) -> ChordError {
        let &Chords { chain, along: [from, own, to], ends: [a, b] } = chords;
        let p = self.on_curve(chain, own + by);
        let before = self.error_of_chord(chain, [from, own + by], [a, p]);
        let after = self.error_of_chord(chain, [own + by, to], [p, b]);
        ChordError { length: before.length + after.length, farthest: before.farthest.max(after.farthest) }
    }

    /// The error of one chord between two arc lengths.
    fn error_of_chord(&self, chain: ChainId, [from, to]: [f32; 2], ends: [Vec3; 2]) -> ChordError {
        let curve = self.chain(chain);
        let target = self.baseline.target[curve.vertices[curve.at(0.5 * (from + to)).segment]];
        let step = (to - from) / f32::from(SAMPLES);
        let samples = (0..SAMPLES).map(|k| from + step * (f32::from(k) + 0.5));
        let mut sum = ChordError { length: 0.0, farthest: 0.0 };
        for off in self.chord_distances(curve, from, samples, ends).map(|distance| distance / target) {
            sum.length += if off > OFF { step / target } else { 0.0 };
            sum.farthest = sum.farthest.max(off);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl SimMesh<'_> {
        /// Length of all chains' curves that is off their chords, in target lengths.
        pub fn length_off_chords(&self) -> f32 {
            let spans = self.topology.edges().filter_map(|half| Some((half, self.span(half)?.along())));
            spans.map(|(half, s)| self.error_of_chord(s.chain, [s.from, s.to], self.end_points(half)).length).sum()
        }
    }
}
