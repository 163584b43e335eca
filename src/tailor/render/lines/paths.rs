//! Shares along paths of marked edges: of the height towards ends, and of the distance where faces are narrow.
//!
//! A path *tapers* where it ends inside the surface: over the taper length, and at most a third of the path, its height goes
//! to nothing. Its lines keep their distance and lead around the end. Where faces are too narrow for the lines, the share
//! of the distance decreases towards that place by a few percent from edge to edge, so that lines do not bead.

use super::LineRequest;
use tailor_mesh::connectivity::{Csr, EdgeId, IdVec, VertexId};

/// Largest part of a path that one taper takes.
const MAX_TAPER_SHARE: f32 = 1.0 / 3.0;
/// Part of an edge below which a taper ends at its vertex rather than at a cut close to it.
const SNAP: f32 = 0.2;
/// Largest ratio of the shares at the two ends of an edge, outside tapers.
const MAX_RATIO: f32 = 1.05;
/// Room below which a place narrows its neighbours no further.
const LEAST_EASED: f32 = 0.7;
/// Room below which a place does not narrow its neighbours: a sliver, beside which an even width is of no use.
const SLIVER: f32 = 0.4;
/// Sweeps that spread a narrow place. The ratio reaches 1 from [`LEAST_EASED`] in 8 edges.
const SWEEPS: usize = 9;

/// The shares of a request.
pub struct Widths {
    /// Share of the requested distance at each vertex.
    pub shares: IdVec<VertexId, f32>,
    /// Share of the height at each vertex: less towards ends, and where faces leave less room.
    pub heights: IdVec<VertexId, f32>,
    /// For each edge, the part from its first and second vertex after which it is cut, as a taper ends within it.
    pub cuts: IdVec<EdgeId, [Option<f32>; 2]>,
}

impl Widths {
    /// Shares below 1 of heights at tapers alone.
    pub fn tapered(request: &LineRequest) -> Self {
        let t = request.topology;
        let ends = request.marked.enumerated().filter(|(_, marked)| **marked).flat_map(|(edge, _)| {
            let [a, b] = t.edges[edge];
            [(a, edge), (b, edge)]
        });
        let marked_at = Csr::group(t.vertex_count(), ends, EdgeId::new(0));
        let full = IdVec::filled(1.0, t.vertex_count());
        let mut widths = Self { shares: full.clone(), heights: full, cuts: IdVec::filled([None; 2], t.edges.len()) };
        for end in request.tapers.ids().filter(|&v| request.tapers[v] || request.ends[v]) {
            if let &[first] = marked_at.row(end) {
                widths.taper(request, first, &path(request, &marked_at, end, first));
            }
        }
        request.flat.ids().filter(|&v| request.flat[v]).for_each(|v| widths.heights[v] = 0.0);
        widths
    }

    /// Lowers the height of a path towards its end, or finds where its last edge is cut. `path` has vertices with their
    /// distance along the path. A single edge has no room to taper.
    fn taper(&mut self, request: &LineRequest, first: EdgeId, path: &[(VertexId, f32)]) {
        let [(end, _), (_, first_length), .., (_, whole)] = *path else { return };
        let length = request.taper_length[first].min(MAX_TAPER_SHARE * whole);
        if request.tapers[end] {
            let tapered = path.iter().filter(|&&(_, along)| along < length);
            tapered.for_each(|&(v, along)| self.heights[v] = self.heights[v].min(along / length));
        } else if length < (1.0 - SNAP) * first_length {
            let from_second = usize::from(request.topology.edges[first][0] != end);
            self.cuts[first][from_second] = Some(length / first_length);
        }
    }

    /// Lowers the shares towards places with less than full `room`. Returns the factors.
    pub fn ease(&mut self, request: &LineRequest, room: &IdVec<VertexId, f32>) -> IdVec<VertexId, f32> {
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
fn path(
    request: &LineRequest,
    marked_at: &Csr<VertexId, EdgeId>,
    end: VertexId,
    first: EdgeId,
) -> Vec<(VertexId, f32)> {
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
