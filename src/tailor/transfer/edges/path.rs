//! Paths of edges along curves, by shortest paths in corridors.
//!
//! The mesh is remeshed without these curves, so paths of its edges are longer than they are. In a lattice of
//! equilateral triangles, a line at the angle φ to the nearest edge direction, 0 to 30 degrees, is followed by edges of
//! two directions. Together they are cos φ + sin φ / √3 times as long: from 1 along edges to 2 / √3 halfway between,
//! 1.10 on the mean. The excess of a path over that is reported by the shortest path between its ends
//! (`shortestLength`). Only constraints, which move vertices to the curve, make it shorter.

use super::corridor::{Corridor, CorridorEdge, CorridorVertex};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use tailor_mesh::connectivity::VertexId;

/// Relative cost of an edge one target length off the curve, beyond its length: more follows the curve closer and
/// zigzags, less is shorter and cuts its corners. The first whose path is as long as the curve is taken.
const STRAYS: [f64; 3] = [0.5, 0.125, 0.03];
/// The stray cost of the shortest path.
const STRAIGHT: f64 = 0.0;
/// Largest difference in length of a path and its curve, as a share.
const LENGTH_SLACK: f64 = 0.05;
/// Least gain in length that is worth straying farther, as a share of the curve's length.
const LENGTH_GAIN: f64 = 0.005;
/// Cost factor of edges to vertices on a chain or on another path of the set: more keeps curves apart on longer ways.
const OCCUPIED: f64 = 20.0;
/// Vertices that the way to a loop may share with the way back before the loop is taken as it is.
const MAX_AVOIDED: usize = 3;
/// States of a vertex beside a closed curve: winding numbers -1, 0 and 1.
const WINDINGS: usize = 3;

/// The least cost of a state, and the state before it.
type Best = (f64, u32);
/// The state before the first.
const NO_STATE: u32 = u32::MAX;

/// A path along a curve.
pub(super) struct EdgePath {
    pub vertices: Vec<VertexId>,
    /// Largest distance of a vertex from the curve, in local target lengths.
    pub farthest: f32,
    /// Its length, or that of the shortest path between its ends if its own differs from the curve's by more than the
    /// slack. \[mesh units\]
    pub shortest: f64,
}

impl EdgePath {
    /// Its vertices without its ends; a loop has no ends.
    pub fn inner(&self, is_loop: bool) -> &[VertexId] {
        &self.vertices[1..self.vertices.len() - usize::from(!is_loop)]
    }
}

/// A search for a path.
struct PathQuery<'a> {
    from: usize,
    to: usize,
    /// Least number of vertices.
    least: usize,
    /// Vertices that cost more.
    occupied: &'a [bool],
}

impl Corridor {
    /// The vertex nearest to the curve, of those that are not occupied if there are any.
    pub fn nearest(&self, occupied: &[bool]) -> Option<VertexId> {
        let key = |(v, &is_occupied): (&CorridorVertex, &bool)| (is_occupied, v.nearest.distance.to_bits(), v.vertex);
        self.vertices.iter().zip(occupied).map(key).min().map(|k| k.2)
    }

    /// The path of at least `least` vertices between two vertices that follows the curve closest, of those that come
    /// nearest to its length. Once around a closed curve, from a vertex to itself.
    pub fn best_path(&self, ends: [VertexId; 2], least: usize, occupied: &[bool]) -> Option<EdgePath> {
        let [from, to] = [self.index(ends[0])?, self.index(ends[1])?];
        let paths = self.candidates(&PathQuery { from, to, least, occupied });
        let least_error = paths.iter().map(|p| self.length_error(p.0)).fold(f64::MAX, f64::min);
        let gain = if least_error > 0.0 { self.least_gain() } else { 0.0 };
        let shortest = paths.iter().map(|p| p.0).fold(f64::MAX, f64::min);
        let best = paths.into_iter().find(|p| self.length_error(p.0) <= least_error + gain);
        best.map(|(length, path)| EdgePath {
            farthest: path.iter().map(|&i| self.vertices[i].off).fold(0.0, f32::max),
            vertices: path.into_iter().map(|i| self.vertices[i].vertex).collect(),
            shortest: if self.length_error(length) > 0.0 { shortest } else { length },
        })
    }

    /// Paths with their lengths, each straying farther from the curve, up to the first of the curve's length.
    fn candidates(&self, query: &PathQuery<'_>) -> Vec<(f64, Vec<usize>)> {
        let path = |stray: f64| {
            let path = self.path_or_loop(query, stray).filter(|p| p.len() >= query.least)?;
            Some((path.windows(2).map(|p| self.edge_length(p[0], p[1])).sum(), path))
        };
        let is_found = |paths: &[(f64, _)]| paths.last().is_some_and(|p| self.length_error(p.0) == 0.0);
        let mut paths: Vec<(f64, Vec<usize>)> = path(STRAYS[0]).into_iter().collect();
        if is_found(&paths) {
            return paths;
        }
        let straight = path(STRAIGHT);
        // Paths between two of nearly the same length gain nothing.
        let is_straight = |s: &(f64, _)| paths.first().is_some_and(|p| p.0 - s.0 <= self.least_gain());
        if !straight.as_ref().is_some_and(is_straight) {
            for &stray in &STRAYS[1..] {
                paths.extend(path(stray));
                if is_found(&paths) {
                    break;
                }
            }
        }
        paths.extend(straight);
        paths
    }

    /// Difference in length from the curve beyond the slack. \[mesh units\]
    fn length_error(&self, length: f64) -> f64 {
        let wanted = f64::from(self.length);
        ((length - wanted).abs() - LENGTH_SLACK * wanted).max(0.0)
    }

    /// \[mesh units\]
    fn least_gain(&self) -> f64 {
        LENGTH_GAIN * f64::from(self.length)
    }

    /// \[mesh units\]
    fn edge_length(&self, a: usize, b: usize) -> f64 {
        let edge = self.edges_of(a).iter().find(|e| e.to as usize == b);
        edge.expect("consecutive vertices of a path share an edge").length
    }

    /// The cheapest path. Around a closed curve, a loop through its first vertex if there is one, since other paths may
    /// end there.
    fn path_or_loop(&self, query: &PathQuery<'_>, stray: f64) -> Option<Vec<usize>> {
        let mut avoided = Vec::new();
        loop {
            let path = self.path(query, stray, &avoided)?;
            if path[0] == query.from || avoided.len() == MAX_AVOIDED {
                return Some(path);
            }
            // The ways there and back share this vertex.
            avoided.push(path[0]);
        }
    }

    /// The cheapest path, by Dijkstra's algorithm over vertices and winding numbers.
    fn path(&self, query: &PathQuery<'_>, stray: f64, avoided: &[usize]) -> Option<Vec<usize>> {
        let PathQuery { from, to, least, occupied } = *query;
        let windings = self.windings();
        let (start, goal) = (from * windings + windings / 2, to * windings + windings - 1);
        let mut best: Vec<Best> = vec![(f64::INFINITY, NO_STATE); windings * self.vertices.len()];
        best[start].0 = 0.0;
        // The bits of costs, which are not negative, sort as the costs do.
        let mut queue = BinaryHeap::from([Reverse((0u64, start as u32))]);
        while let Some(Reverse((bits, state))) = queue.pop() {
            let (cost, here, winding) = (f64::from_bits(bits), state as usize / windings, state as usize % windings);
            if state as usize == goal {
                return Some(self.trace(&best, goal));
            }
            if cost > best[state as usize].0 {
                continue;
            }
            for edge in self.edges_of(here) {
                let there = edge.to as usize;
                if least > 2 && here == from && there == to {
                    continue;
                }
                let winding = (winding + self.winding_step(here, there)).checked_sub(1).filter(|w| *w < windings);
                let Some(winding) = winding else { continue };
                let is_occupied = (occupied[there] || avoided.contains(&there)) && there != to && there != from;
                let sum = cost + edge.cost(stray) * if is_occupied { OCCUPIED } else { 1.0 };
                let next = there * windings + winding;
                if sum < best[next].0 {
                    best[next] = (sum, state);
                    queue.push(Reverse((sum.to_bits(), next as u32)));
                }
            }
        }
        None
    }

    /// Number of states of a vertex.
    fn windings(&self) -> usize {
        if self.is_closed { WINDINGS } else { 1 }
    }

    /// One plus the change of the winding number over an edge, which passes the start of a closed curve backwards, not,
    /// or forwards.
    fn winding_step(&self, a: usize, b: usize) -> usize {
        let (step, half) = (self.vertices[b].nearest.s - self.vertices[a].nearest.s, 0.5 * self.length);
        match self.is_closed {
            true if step < -half => 2,
            true if step > half => 0,
            _ => 1,
        }
    }

    /// The path to a state. Around a closed curve only the loop, without the way to it.
    fn trace(&self, best: &[Best], goal: usize) -> Vec<usize> {
        let mut states = vec![goal];
        while let Some(&(_, before)) = states.last().map(|&s| &best[s]).filter(|b| b.1 != NO_STATE) {
            states.push(before as usize);
        }
        states.reverse();
        let windings = self.windings();
        let mut path: Vec<usize> = Vec::with_capacity(states.len());
        for state in states {
            if let Some(first) = path.iter().position(|s| s / windings == state / windings) {
                if self.is_closed && path[first] != state {
                    path.push(state);
                    return path[first..].iter().map(|s| s / windings).collect();
                }
                path.truncate(first);
            }
            path.push(state);
        }
        path.into_iter().map(|s| s / windings).collect()
    }
}

impl CorridorEdge {
    fn cost(&self, stray: f64) -> f64 {
        self.length * (1.0 + stray * f64::from(self.off))
    }
}
