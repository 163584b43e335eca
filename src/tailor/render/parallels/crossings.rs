//! Where lines cross edges, and which vertices they lead through.

use super::chords::Point;
use super::waves::{Foot, Wave};
use super::{LinePlace, ParallelRequest};
use std::collections::BTreeMap;
use tailor_mesh::connectivity::{EdgeId, VertexId};

/// Least share of an edge between a crossing and its ends.
const LEAST_PART: f32 = 1e-3;

/// A crossing of a line and an edge.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    /// Index of the line.
    pub line: usize,
    /// Share of the edge from its first vertex.
    pub at: f32,
    /// The place on the chain.
    pub foot: Foot,
    /// Share of the height.
    pub share: f32,
}

impl Crossing {
    /// Its place among the lines.
    pub fn place(&self) -> LinePlace {
        let Foot { side, distance, .. } = self.foot;
        LinePlace { line: Some(self.line), side, distance, share: self.share }
    }
}

/// All crossings.
pub struct Crossings {
    /// The crossings of each edge, from its first vertex on.
    pub of_edges: BTreeMap<EdgeId, Vec<Crossing>>,
    /// The line through each vertex, with the place of the vertex.
    pub through: BTreeMap<VertexId, (usize, Foot, f32)>,
}

/// A sample of an edge: its share of the edge, its foot, and its vertex.
type Sample = (f32, Foot, Option<VertexId>);

impl Crossings {
    /// The crossings of a request.
    pub fn new(request: &ParallelRequest) -> Self {
        let t = request.topology();
        let mut crossings = Self { of_edges: BTreeMap::new(), through: BTreeMap::new() };
        for vertex in (0..t.vertex_count()).map(VertexId::new) {
            let Some(foot) = request.field.off_chains(vertex) else { continue };
            let Some(line) = request.line_at(&foot) else { continue };
            let share = request.share(&foot, |block| block.field.around_vertex(vertex));
            crossings.through.insert(vertex, (line, foot, share));
        }
        for edge in t.edges.ids().filter(|&e| !request.field.is_chain(e)) {
            let found = crossings.of_edge(request, edge);
            if !found.is_empty() {
                crossings.of_edges.insert(edge, found);
            }
        }
        crossings
    }

    /// Ends a line at a point: it has no height there.
    pub fn end(&mut self, point: Point) {
        let share = match point {
            Point::Vertex(vertex) => self.through.get_mut(&vertex).map(|(.., share)| share),
            Point::Crossing(edge, number) => self.of_edges.get_mut(&edge).map(|crossings| &mut crossings[number].share),
        };
        share.into_iter().for_each(|share| *share = 0.0);
    }

    fn of_edge(&self, request: &ParallelRequest, edge: EdgeId) -> Vec<Crossing> {
        let [a, b] = request.topology().edges[edge];
        let samples = [
            (0.0, request.field.at_vertex(a, edge), Some(a)),
            (0.5, request.field.at_middle(edge), None),
            (1.0, request.field.at_vertex(b, edge), Some(b)),
        ];
        let known: Vec<Sample> = samples.into_iter().filter_map(|(at, foot, v)| Some((at, foot?, v))).collect();
        let [first, .., last] = known.as_slice() else { return Vec::new() };
        let through = |v: Option<VertexId>| v.and_then(|v| self.through.get(&v)).map(|(line, ..)| *line);
        let [at_first, at_last] = [first, last].map(|sample| through(sample.2));
        let mut found: Vec<Crossing> = Vec::new();
        for line in 0..request.distances[0].len() {
            let over = |sample: &Sample| request.over(line, &sample.1);
            if at_first == Some(line) || at_last == Some(line) || (over(first) > 0.0) == (over(last) > 0.0) {
                continue;
            }
            let is_before = |sample: &&Sample| (over(sample) > 0.0) == (over(first) > 0.0);
            let next = known.iter().take_while(is_before).count();
            let (low, high) = (&known[next - 1], &known[next]);
            let part = over(low) / (over(low) - over(high));
            let foot = between(&low.1, &high.1, part);
            let at = (low.0 + part * (high.0 - low.0)).clamp(LEAST_PART, 1.0 - LEAST_PART);
            let ends = [low, high].map(|sample| {
                request.share(&sample.1, |block| match sample.2 {
                    Some(vertex) => block.field.around_vertex(vertex),
                    None => block.field.around_middle(edge),
                })
            });
            found.push(Crossing { line, at, foot, share: ends[0] + part * (ends[1] - ends[0]) });
        }
        found.sort_by(|x, y| x.at.total_cmp(&y.at));
        found
    }
}

/// The foot at a share of the way between two.
fn between(a: &Foot, b: &Foot, part: f32) -> Foot {
    let nearer = if part < 0.5 { a } else { b };
    let distance = a.distance + part * (b.distance - a.distance);
    let is_same = (a.chain, a.side) == (b.chain, b.side);
    let is_near = (b.along - a.along).abs() <= 2.0 * (b.distance + a.distance);
    let along = if is_same && is_near { a.along + part * (b.along - a.along) } else { nearer.along };
    Foot { distance, along, ..*nearer }
}

impl ParallelRequest<'_> {
    /// How far a place is beyond a line.
    pub fn over(&self, line: usize, foot: &Foot) -> f32 {
        foot.distance - self.distances[foot.side][line]
    }

    /// The line that leads through a vertex.
    fn line_at(&self, foot: &Foot) -> Option<usize> {
        let lines = &self.distances[foot.side];
        let next = lines.partition_point(|&line| line < foot.distance);
        let candidates = [next.checked_sub(1), (next < lines.len()).then_some(next)].into_iter().flatten();
        let off = |line: usize| (lines[line] - foot.distance).abs();
        let nearest = candidates.min_by(|&a, &b| off(a).total_cmp(&off(b)))?;
        let below = nearest.checked_sub(1).map_or(lines[nearest], |line| lines[nearest] - lines[line]);
        let above = lines.get(nearest + 1).map_or(below, |line| line - lines[nearest]);
        (off(nearest) < self.snap * below.min(above)).then_some(nearest)
    }

    /// The share of the height beside a place of a chain: less near an end that fades, and near blocks.
    pub fn share(&self, foot: &Foot, at: impl Fn(&super::Block) -> Option<Foot>) -> f32 {
        let length = self.field.lengths()[foot.chain];
        let chain = &self.chains[foot.chain];
        let fading = self.fading.min(length / 3.0).max(f32::MIN_POSITIVE);
        let mut share: f32 = 1.0;
        for (fades, left) in chain.fades.into_iter().zip([foot.along, length - foot.along]) {
            if fades {
                let is_around = matches!(foot.wave, Wave::Circle(_)) && left <= 1e-4 * length;
                share = share.min(if is_around { 0.0 } else { left / fading });
            }
        }
        for block in &self.blocks {
            let Some(other) = at(block) else { continue };
            let off = block.at[other.side].iter().map(|at| (other.distance - at).abs()).fold(f32::INFINITY, f32::min);
            share = share.min((off - block.width) / self.fading.max(f32::MIN_POSITIVE));
        }
        share.clamp(0.0, 1.0)
    }
}
