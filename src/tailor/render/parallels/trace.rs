//! Lines at distances from chains as paths over a surface, which stays as it is: threads lie on them.

use super::chords::{self, Point};
use super::crossings::Crossings;
use super::{Chain, Field, ParallelRequest, Surface};
use std::collections::{BTreeMap, BTreeSet};
use tailor_mesh::connectivity::VertexId;

/// A path over a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceLine {
    /// Its points, each between two vertices: the share of the second one.
    pub points: Vec<([VertexId; 2], f32)>,
    /// True if its last point is beside its first one.
    pub is_closed: bool,
    /// The side of the chain: 0 on its left, 1 on its right.
    pub side: usize,
}

/// The lines beside chains: those at each of the ascending `distances` on the wanted sides, left and right. A distance of 0 is the
/// chains themselves. \[mesh units\]
pub fn lines(surface: &Surface, chains: &[Chain], sides: [bool; 2], distances: &[f32]) -> Vec<SurfaceLine> {
    let mut found = Vec::new();
    if distances.first() == Some(&0.0) {
        found.extend(chains.iter().map(|chain| on_chain(surface, chain)));
    }
    let beside: Vec<f32> = distances.iter().copied().filter(|&distance| distance > 0.0).collect();
    let Some(&furthest) = beside.last() else { return found };
    let request = ParallelRequest {
        field: Field::new(surface, chains, sides, furthest),
        chains,
        distances: [beside.clone(), beside.clone()],
        snap: 1e-3,
        fading: 0.0,
        blocks: Vec::new(),
    };
    let crossings = Crossings::new(&request);
    for line in 0..beside.len() {
        let mut ends: [BTreeSet<[Point; 2]>; 2] = Default::default();
        for (side, piece) in chords::pieces(&request, &crossings, line) {
            ends[side].insert(piece);
        }
        for (side, pieces) in ends.into_iter().enumerate() {
            found.extend(linked(&pieces).into_iter().map(|(path, is_closed)| {
                let points = path.into_iter().map(|point| place(surface, &crossings, point)).collect();
                SurfaceLine { points, is_closed, side }
            }));
        }
    }
    found
}

fn on_chain(surface: &Surface, chain: &Chain) -> SurfaceLine {
    let mut points: Vec<_> = chain.edges.iter().map(|&(_, start)| ([start; 2], 0.0)).collect();
    let end = chain.edges.last().map(|&(edge, start)| {
        let [a, b] = surface.topology.edges[edge];
        if a == start { b } else { a }
    });
    let is_closed = end == chain.edges.first().map(|&(_, start)| start);
    points.extend(end.filter(|_| !is_closed).map(|end| ([end; 2], 0.0)));
    SurfaceLine { points, is_closed, side: 0 }
}

fn place(surface: &Surface, crossings: &Crossings, point: Point) -> ([VertexId; 2], f32) {
    match point {
        Point::Vertex(vertex) => ([vertex; 2], 0.0),
        Point::Crossing(edge, number) => (surface.topology.edges[edge], crossings.of_edges[&edge][number].at),
    }
}

/// Paths of pieces, from end to end, and whether each is closed. Where more than two pieces meet, paths end.
fn linked(pieces: &BTreeSet<[Point; 2]>) -> Vec<(Vec<Point>, bool)> {
    let mut next: BTreeMap<Point, Vec<Point>> = BTreeMap::new();
    for &[a, b] in pieces {
        next.entry(a).or_default().push(b);
        next.entry(b).or_default().push(a);
    }
    let mut left: BTreeSet<[Point; 2]> = pieces.clone();
    let ordered = |a: Point, b: Point| if a < b { [a, b] } else { [b, a] };
    let mut paths = Vec::new();
    for is_closed in [false, true] {
        for (&start, around) in next.iter().filter(|(_, around)| is_closed || around.len() != 2) {
            for &second in around {
                if !left.remove(&ordered(start, second)) {
                    continue;
                }
                let mut path = vec![start, second];
                let mut at = second;
                while next[&at].len() == 2 {
                    let on = next[&at].iter().copied().find(|&to| left.remove(&ordered(at, to)));
                    let Some(to) = on else { break };
                    path.push(to);
                    at = to;
                }
                let closes = at == start;
                path.truncate(path.len() - usize::from(closes));
                paths.push((path, closes));
            }
        }
    }
    paths
}
