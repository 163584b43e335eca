//! Vertices of chains slide to where the chords beside them follow the curve: averages put them where triangles are
//! even, and how far a chord cuts off a bend hangs on where its ends lie.

use crate::mesh::{ChainId, CornerId, VertexId};
use crate::sim::passes::polish::{FanAngles, angles, try_move, with_rings};
use crate::sim::passes::relax::Destination;
use crate::sim::passes::split::FAR;
use crate::sim::sim_mesh::{SimMesh, VertexConstraint};
use glam::Vec3;
use rayon::prelude::*;

/// A curve is astray where its chord is farther from it than this share of the target length: what users see as a gap is
/// more, and less is not asked for.
const ASTRAY: f32 = 0.0195;
/// Places on each chord at which that is asked.
const SAMPLES: u8 = 8;
/// How far a vertex looks, as a share of the chord there. A smaller share leaves 0.2 % more of the curves astray.
const REACH: f32 = 0.4;
/// Places at which it looks, each way.
const PLACES: i8 = 8;
/// What angles lack counts by this against the length of the curve that is astray, in target lengths. A larger value
/// leaves more astray; without it the 5th percentile of the smallest angle is 0.1 degrees less.
const LACK: f32 = 0.1;
/// A gain of less, in target lengths, is not worth a move.
const LEAST: f32 = 0.01;
/// An angle below 33 degrees (its cosine) becomes no smaller.
const WORST: f32 = 0.838_67;
/// Passes; the second one finds what moves of neighbours made room for: 0.1 to 0.3 % less of the curves is astray on the
/// garments with most of it.
const PASSES: usize = 2;

/// A vertex of a chain with its neighbours there.
struct CurveNeighbours {
    chain: ChainId,
    /// Arc lengths of the neighbour before, the vertex and the neighbour after. \[stage units\]
    along: [f32; 3],
    /// Positions of the neighbours. \[stage units\]
    ends: [Vec3; 2],
}

/// How a chord follows its curve, in target lengths.
#[derive(Clone, Copy)]
struct ChordError {
    /// Length of the curve that is astray.
    length: f32,
    /// Where it is farthest from the chord.
    farthest: f32,
}

/// Slides the vertices of chains, one after the other in the order of their numbers, so the result is the same for any
/// number of threads. Returns the number of moves.
pub(crate) fn follow_curves(mesh: &mut SimMesh<'_>) -> usize {
    let vertices = (0..mesh.topology.vertex_slots()).into_par_iter().map(VertexId::new);
    let is_astray = |&v: &VertexId| mesh.between(v).is_some_and(|between| mesh.astray(&between, 0.0).length > 0.0);
    let mut waiting: Vec<VertexId> = vertices.filter(|&v| is_on_curve(mesh, v)).filter(is_astray).collect();
    let mut moves = 0;
    for _ in 0..PASSES {
        waiting.retain(|&v| is_on_curve(mesh, v) && follow(mesh, v));
        moves += waiting.len();
        waiting = with_rings(mesh, &waiting);
    }
    moves
}

fn is_on_curve(mesh: &SimMesh<'_>, vertex: VertexId) -> bool {
    matches!(mesh.constraint[vertex], VertexConstraint::OnCurve(_))
}

/// Slides a vertex to the best place that a search finds. Returns whether it moved.
fn follow(mesh: &mut SimMesh<'_>, vertex: VertexId) -> bool {
    let Some(between) = mesh.between(vertex) else { return false };
    let before = mesh.astray(&between, 0.0);
    if before.length == 0.0 {
        return false;
    }
    let old = angles(mesh, vertex, mesh.points[vertex]);
    let is_thin = |now: &FanAngles| now.worst > old.worst.max(WORST);
    let cost = |by: f32| {
        let there = mesh.on_curve(between.chain, between.along[1] + by);
        let now = Some(angles(mesh, vertex, there)).filter(|now| !is_thin(now))?;
        let astray = mesh.astray(&between, by);
        // Chords farther than that are split.
        let is_far = astray.farthest > before.farthest.max(FAR);
        (!is_far).then_some(astray.length + LACK * (now.lack - old.lack).max(0.0))
    };
    let [from, own, to] = between.along;
    let ways = (-PLACES..=PLACES).filter(|&k| k != 0).map(|k| {
        let chord = if k < 0 { own - from } else { to - own };
        REACH * chord * f32::from(k) / f32::from(PLACES)
    });
    let best = ways.filter_map(|by| Some((cost(by)?, by))).min_by(|a, b| a.0.total_cmp(&b.0));
    let goal = best.filter(|&(cost, _)| cost < before.length - LEAST).map(|(_, by)| Destination::Along(by));
    goal.is_some_and(|goal| try_move(mesh, vertex, goal, |_| true))
}

impl SimMesh<'_> {
    /// Length of all chains' curves that is astray, in target lengths.
    pub fn length_astray(&self) -> f32 {
        let spans = self.topology.edges().filter_map(|half| Some((half, self.span(half)?.along())));
        let chord = |(half, span): (CornerId, crate::sim::sim_mesh::CurveSpan)| {
            let ends = [self.topology.vertex(half), self.topology.target(half)].map(|v| self.points[v]);
            self.chord_astray(span.chain, [span.from, span.to], ends).length
        };
        spans.map(chord).sum()
    }

    fn between(&self, vertex: VertexId) -> Option<CurveNeighbours> {
        let [ahead, back] = self.chain_neighbours(vertex)?;
        let (after, before) = (self.span(ahead)?.along(), self.span(back)?.along());
        let other = |half: CornerId| {
            let start = self.topology.vertex(half);
            self.points[if start == vertex { self.topology.target(half) } else { start }]
        };
        // A loop's two edges may count from different turns.
        let along = [before.from, before.to, before.to + after.to - after.from];
        Some(CurveNeighbours { chain: after.chain, along, ends: [other(back), other(ahead)] })
    }

    /// How the chords beside a vertex follow the curve if it slides.
    fn astray(&self, between: &CurveNeighbours, by: f32) -> ChordError {
        let &CurveNeighbours { chain, along: [from, own, to], ends: [a, b] } = between;
        let p = self.on_curve(chain, own + by);
        let before = self.chord_astray(chain, [from, own + by], [a, p]);
        let after = self.chord_astray(chain, [own + by, to], [p, b]);
        ChordError { length: before.length + after.length, farthest: before.farthest.max(after.farthest) }
    }

    /// How a chord follows the curve between two arc lengths.
    fn chord_astray(&self, chain: ChainId, [from, to]: [f32; 2], ends: [Vec3; 2]) -> ChordError {
        let curve = self.chain(chain);
        let target = self.baseline.target[curve.vertices[curve.at(0.5 * (from + to)).segment]];
        let step = (to - from) / f32::from(SAMPLES);
        let places = (0..SAMPLES).map(|k| from + step * (f32::from(k) + 0.5));
        let mut sum = ChordError { length: 0.0, farthest: 0.0 };
        for off in self.off_chord(curve, from, places, ends).map(|off| off / target) {
            sum.length += if off > ASTRAY { step / target } else { 0.0 };
            sum.farthest = sum.farthest.max(off);
        }
        sum
    }
}
