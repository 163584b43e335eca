//! The share of the requested distance along paths of marked edges.
//!
//! A path *tapers* where it ends inside the surface: over the taper length, and at most a third of the path, its lines
//! narrow to nothing. Where faces are too narrow for the lines, the share decreases towards that place by a few percent
//! from edge to edge, so that lines do not bead.

use super::Request;
use crate::mesh::{Csr, EdgeId, IdVec, VertexId};

/// Largest part of a path that one taper takes.
const MAX_TAPER_SHARE: f32 = 1.0 / 3.0;
/// Part of an edge below which a taper ends at its vertex rather than at a cut close to it.
const SNAP: f32 = 0.2;
/// Largest ratio of the shares at the two ends of an edge, outside tapers.
const MAX_RATIO: f32 = 1.05;
/// Room below which a place narrows its neighbours no further.
pub const LEAST_EASED: f32 = 0.7;
/// Room below which a place does not narrow its neighbours: a sliver, beside which an even width is of no use.
const SLIVER: f32 = 0.4;
/// Sweeps that spread a narrow place. The ratio reaches 1 from [`LEAST_EASED`] in 8 edges.
const SWEEPS: usize = 9;

/// The shares of a request.
pub struct Widths {
    /// Share of the requested distance at each vertex.
    pub shares: IdVec<VertexId, f32>,
    /// Share of the height at each vertex: less than that of the distance where its faces leave less room.
    pub parts: IdVec<VertexId, f32>,
    /// For each edge, the part that a taper takes from its first and second vertex, if the taper ends within the edge.
    pub tapers: IdVec<EdgeId, [Option<f32>; 2]>,
}

impl Widths {
    /// Shares below 1 at tapers alone.
    pub fn tapered(request: &Request) -> Self {
        let t = request.topology;
        let ends = request.marked.enumerated().filter(|(_, marked)| **marked).flat_map(|(edge, _)| {
            let [a, b] = t.edges[edge];
            [(a, edge), (b, edge)]
        });
        let marked_at = Csr::group(t.vertex_count(), ends, EdgeId::new(0));
        let full = IdVec::filled(1.0, t.vertex_count());
        let mut widths = Self { shares: full.clone(), parts: full, tapers: IdVec::filled([None; 2], t.edges.len()) };
        for end in request.tapers.ids().filter(|&v| request.tapers[v] || request.ends[v]) {
            if let &[first] = marked_at.row(end) {
                widths.taper(request, first, &path(request, &marked_at, end, first));
            }
        }
        widths
    }

    /// Narrows a path from its end. `path` has vertices with their distance along the path.
    fn taper(&mut self, request: &Request, first: EdgeId, path: &[(VertexId, f32)]) {
        let [(end, _), (_, first_length), ..] = *path else { return };
        let most = MAX_TAPER_SHARE * path[path.len() - 1].1;
        let asked = request.taper_length[first];
        let is_lone = path.len() == 2;
        if asked == 0.0 && !is_lone {
            return;
        }
        let wanted = if asked == 0.0 { most } else { asked.min(most) };
        if wanted < (1.0 - SNAP) * first_length {
            let from_second = usize::from(request.topology.edges[first][0] != end);
            self.tapers[first][from_second] = Some(wanted / first_length);
            return;
        }
        if !request.tapers[end] {
            return;
        }
        let off = |length: f32| (length - wanted).abs();
        let within = path[1..].iter().map(|v| v.1).filter(|&length| length <= most.max(first_length) * (1.0 + SNAP));
        let length = within.fold(first_length, |best, length| if off(length) <= off(best) { length } else { best });
        let inside = path[1..].iter().take_while(|v| v.1 < length);
        inside.for_each(|&(v, along)| self.shares[v] = self.shares[v].min(along / length));
    }

    /// Lowers the shares towards places with less than full `room`. Returns the factors.
    pub fn ease(&mut self, request: &Request, room: &IdVec<VertexId, f32>) -> IdVec<VertexId, f32> {
        let factor = |&room: &f32| if room < SLIVER { 1.0 } else { room.max(LEAST_EASED) };
        let mut factors: IdVec<VertexId, f32> = room.iter().map(factor).collect();
        let marked = request.marked.ids().filter(|&edge| request.marked[edge]);
        let marked: Vec<[VertexId; 2]> = marked.map(|edge| request.topology.edges[edge]).collect();
        for _ in 0..SWEEPS {
            let mut is_even = true;
            for &[a, b] in &marked {
                for (low, high) in [(a, b), (b, a)] {
                    let most = MAX_RATIO * factors[low];
                    if factors[high] > most {
                        factors[high] = most;
                        is_even = false;
                    }
                }
            }
            if is_even {
                break;
            }
        }
        self.shares.iter_mut().zip(factors.iter()).for_each(|(share, factor)| *share *= factor);
        factors
    }
}

/// The vertices of a path from its end on, up to where it branches or ends, with their distance along it.
fn path(request: &Request, marked_at: &Csr<VertexId, EdgeId>, end: VertexId, first: EdgeId) -> Vec<(VertexId, f32)> {
    let (t, points) = (request.topology, request.points);
    let mut path = vec![(end, 0.0)];
    let (mut at, mut edge, mut length) = (end, first, 0.0);
    loop {
        let [a, b] = t.edges[edge];
        let next = if a == at { b } else { a };
        length += points[at].distance(points[next]);
        path.push((next, length));
        match *marked_at.row(next) {
            [x, y] if next != end && path.len() <= t.edges.len() => edge = if x == edge { y } else { x },
            _ => return path,
        }
        at = next;
    }
}
