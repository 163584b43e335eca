//! The cuts of marked edges: where a taper begins, and where the lines of other marked edges cross at a junction.
//!
//! ```text
//!  o--+--+--o--      A junction is a vertex of three or more marked edges. The lines of two neighbouring ones form a
//!  |  |  |  |        *block* there: a grid of lines, which leaves the vertex as regular as it was. Without it, all
//!  +--+--+--+--      mitres would meet in the vertex, and a raised junction would look like a star.
//!  +--+--+--+--
//!  *==+==+==+==
//! ```

use super::Request;
use super::paths::Widths;
use super::ribs::{Path, Ribs, ghost_part, sine};
use crate::mesh::{CornerId, EdgeId, IdVec, Topology, VertexId};
use std::collections::{BTreeMap, BTreeSet};

/// Largest share of an edge that a block takes. Where a face is smaller or a corner sharper, the lines of the junction
/// meet in mitres alone: the faces of blocks would be slivers.
const MAX_BLOCK_SHARE: f32 = 0.33;
/// Largest share of the edge beside the end of a taper that its lines take. Where faces are smaller, the whole last edge
/// tapers.
const MAX_TAPER_SIDE: f32 = 0.5;

/// Position of the cut, and share of the width there, where the whole last edge of a path tapers and is cut.
const HALFWAY: f32 = 0.5;
/// Shares of the longer and shorter edge of a long face that a mitre takes, below and above which a cut halfway would make a
/// quad beside it that intersects itself.
const LONG_AND_FULL: [f32; 2] = [0.2, 0.79];
/// Largest share of an unmarked edge that the lines beside a cut take.
const MAX_SPOKE_SHARE: f32 = 0.6;
/// Least ratio of the length of an edge to that of a marked one at the same vertex.
const MIN_EDGE_RATIO: f32 = 0.25;
/// Least sine of the angles between the last edge of a path and the edges beside it.
const MIN_SINE: f32 = 0.5;

/// A cut of a marked edge.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    /// Its position from the edge's first vertex, as a share of the edge.
    pub at: f32,
    /// Share of the requested distance.
    pub share: f32,
    /// The line of the block that crosses the edge here; none for a taper.
    pub block: Option<BlockLine>,
    /// True halfway through a taper, where the lines have narrowed by half.
    pub is_halfway: bool,
}

/// A line of a block at one end of an edge.
#[derive(Clone, Copy, Debug)]
pub struct BlockLine {
    /// The junction.
    pub vertex: VertexId,
    /// Index of the line, from 0 nearest to the junction.
    pub line: usize,
    /// The marked edge of the line.
    pub mark: EdgeId,
}

/// All cuts of a request.
pub struct Cuts {
    /// The cuts of each edge, from its first vertex on.
    of_edges: BTreeMap<EdgeId, Vec<Cut>>,
    /// The block at corners of junctions: positions of the lines along the edges after and before the corner.
    blocks: BTreeMap<CornerId, [Vec<f32>; 2]>,
}

/// Positions of the lines of a block along a marked edge, from the junction, with the marked edge of these lines.
type Positions = BTreeMap<(EdgeId, VertexId), (Vec<f32>, EdgeId)>;

impl Cuts {
    /// The cuts of a request with its ribs.
    pub fn new(request: &Request, ribs: &Ribs, widths: &Widths) -> Self {
        let t = request.topology;
        let corners = block_corners(request, ribs);
        let positions = positions(t, ribs, &corners);
        let of = |edge: EdgeId, corner: CornerId| positions[&(edge, t.faces.vertex(corner))].0.clone();
        let blocks = corners.iter().map(|&c| {
            let edges = [t.corner_edge[c], t.corner_edge[t.faces.prev(c)]];
            (c, edges.map(|edge| of(edge, c)))
        });
        let mut cuts = Self { blocks: blocks.collect(), of_edges: BTreeMap::new() };
        for (&(edge, vertex), (steps, mark)) in &positions {
            let is_first = t.edges[edge][0] == vertex;
            let share = widths.parts[vertex];
            let at = |step: f32| if is_first { step } else { 1.0 - step };
            let block = |line| Some(BlockLine { vertex, line, mark: *mark });
            let new = steps.iter().enumerate().map(|(line, &step)| Cut {
                at: at(step),
                share,
                block: block(line),
                is_halfway: false,
            });
            cuts.of_edges.entry(edge).or_default().extend(new);
        }
        cuts.add_tapers(request, ribs, widths);
        cuts.of_edges.values_mut().for_each(|all| all.sort_by(|a, b| a.at.total_cmp(&b.at)));
        cuts
    }

    /// Adds the cuts of tapers. Without room for one, the whole last edge tapers. If lines turn a corner at its other end,
    /// it is cut halfway: Catmull-Clark rounds triangles and quads differently, and close lines would intersect there. In a
    /// long face that the lines fill, it is not.
    fn add_tapers(&mut self, request: &Request, ribs: &Ribs, widths: &Widths) {
        let t = request.topology;
        for (edge, tapers) in widths.tapers.enumerated().filter(|(edge, _)| request.marked[*edge]) {
            for (from_second, part) in tapers.iter().enumerate() {
                let [end, other] = [t.edges[edge][from_second], t.edges[edge][1 - from_second]];
                let (is_taper, is_lone) = (request.tapers[end], request.tapers[other]);
                let has_room = |_: &f32| !is_taper || is_lone || has_room_beside(request, ribs, edge, [end, other]);
                let is_turn = || t.vertex_corners.row(other).iter().any(|&c| ribs.within(c).is_some());
                let full = if is_lone { 1.0 } else { widths.parts[other] };
                let (part, share, is_halfway) = match part.filter(has_room) {
                    Some(part) => (part, full, false),
                    None if is_taper && !is_long_and_full(ribs, other) && is_turn() => (HALFWAY, HALFWAY * full, true),
                    None => continue,
                };
                let at = if from_second == 0 { part } else { 1.0 - part };
                self.add_taper(edge, Cut { at, share, block: None, is_halfway }, from_second == 0);
            }
        }
    }

    /// Adds the cut of a taper from the first or second vertex, unless the block at the other end of the edge reaches it.
    fn add_taper(&mut self, edge: EdgeId, cut: Cut, from_first: bool) {
        let all = self.of_edges.entry(edge).or_default();
        let is_free = |other: &Cut| other.block.is_none() || from_first == (cut.at < other.at);
        if all.iter().all(is_free) {
            all.push(cut);
        }
    }

    /// The cuts of an edge from its first vertex on.
    pub fn of(&self, edge: EdgeId) -> &[Cut] {
        self.of_edges.get(&edge).map_or(&[], Vec::as_slice)
    }

    /// The edges with cuts.
    pub fn edges(&self) -> impl Iterator<Item = EdgeId> + '_ {
        self.of_edges.keys().copied()
    }

    /// The positions of the lines of the block at a corner, along the edges after and before it.
    pub fn block(&self, corner: CornerId) -> Option<&[Vec<f32>; 2]> {
        self.blocks.get(&corner)
    }
}

/// Whether lines at their full distance fit beside the last edge of a path, with no border or other marked edge near its
/// end.
fn has_room_beside(request: &Request, ribs: &Ribs, edge: EdgeId, [end, other]: [VertexId; 2]) -> bool {
    let t = request.topology;
    let is_alone = |e: EdgeId| e == edge || !request.marked[e] || t.edges[e].contains(&other);
    let is_inside = |e: EdgeId| t.is_border(edge) || !t.is_border(e);
    let mut around = t.faces_at(end).flat_map(|face| t.faces.corners_of(face)).map(|c| t.corner_edge[c]);
    let fits = |&half: &CornerId| {
        let is_tail = t.faces.vertex(half) == end;
        let [at_end, at_other] =
            if is_tail { [t.faces.prev(half), t.faces.next(half)] } else { [t.faces.next(half), t.faces.prev(half)] };
        let sines = [sine(request, end, [at_end, half]), sine(request, other, [at_other, half])];
        ghost_part(request, ribs, (end, at_end, half), 1.0) < MAX_TAPER_SIDE && sines.iter().all(|s| *s > MIN_SINE)
    };
    around.all(|e| is_alone(e) && is_inside(e))
        && !is_crowded(request, ribs, other)
        && t.edge_corners.row(edge).iter().all(fits)
}

/// Whether lines from a vertex take most of an edge, or an edge there is much shorter than a marked one.
fn is_crowded(request: &Request, ribs: &Ribs, vertex: VertexId) -> bool {
    let t = request.topology;
    let around = t.vertex_corners.row(vertex).iter().flat_map(|&c| [c, t.faces.prev(c)]).map(|c| t.corner_edge[c]);
    let (mut shortest, mut longest) = (f32::INFINITY, 0.0f32);
    for edge in around {
        let [a, b] = t.edges[edge].map(|v| request.points[v]);
        shortest = shortest.min(a.distance(b));
        longest = if request.marked[edge] { longest.max(a.distance(b)) } else { longest };
    }
    let takes_most = |path: Path| matches!(path, Path::Edge { part, .. } if part > MAX_SPOKE_SHARE);
    shortest < MIN_EDGE_RATIO * longest || ribs.from(vertex).any(|rib| takes_most(rib.path))
}

/// Whether a mitre at a vertex takes all that it may of the short edges of a long face.
fn is_long_and_full(ribs: &Ribs, vertex: VertexId) -> bool {
    let [long, full] = LONG_AND_FULL;
    let is_full = |path: Path| matches!(path, Path::Face { after, before, .. } if after.min(before) < long && after.max(before) > full);
    ribs.from(vertex).any(|rib| is_full(rib.path))
}

/// Corners of two marked edges at junctions with room for blocks.
fn block_corners(request: &Request, ribs: &Ribs) -> Vec<CornerId> {
    let t = request.topology;
    let mut mitres = junction_corners(request);
    let is_narrow = |c: &CornerId| {
        mitre_part(ribs, *c).is_some_and(|part| part > MAX_BLOCK_SHARE) || is_crowded(request, ribs, t.faces.vertex(*c))
    };
    let mut crowded: BTreeSet<VertexId> = mitres.iter().filter(|c| is_narrow(c)).map(|&c| t.faces.vertex(c)).collect();
    // So is the junction at the other end of a taper without room.
    for edge in request.marked.ids().filter(|&edge| request.marked[edge]) {
        let [a, b] = t.edges[edge];
        for (end, other) in [(a, b), (b, a)].into_iter().filter(|(end, _)| request.tapers[*end]) {
            if !has_room_beside(request, ribs, edge, [end, other]) {
                crowded.insert(other);
            }
        }
    }
    mitres.retain(|&c| !crowded.contains(&t.faces.vertex(c)) && mitre_part(ribs, c).is_some());
    mitres
}

/// Corners of two marked edges at vertices of three or more.
fn junction_corners(request: &Request) -> Vec<CornerId> {
    let t = request.topology;
    let mut marks: IdVec<VertexId, u32> = IdVec::filled(0, t.vertex_count());
    let marked = request.marked.ids().filter(|&e| request.marked[e]);
    marked.for_each(|edge| t.edges[edge].iter().for_each(|&v| marks[v] += 1));
    let is_mitre = |&c: &CornerId| {
        let edges = [t.corner_edge[c], t.corner_edge[t.faces.prev(c)]];
        marks[t.faces.vertex(c)] >= 3 && edges.iter().all(|&e| request.marked[e])
    };
    t.faces.corners().ids().filter(is_mitre).collect()
}

/// The larger share of an edge that the mitre at a corner takes.
fn mitre_part(ribs: &Ribs, corner: CornerId) -> Option<f32> {
    match ribs.within(corner).map(|rib| ribs.all[rib].path)? {
        Path::Face { after, before, .. } => Some(after.max(before)),
        _ => None,
    }
}

/// Lowers the room at junctions to that of a block, where that is `least` of the distance. Beside another layer, the faces of
/// a block would take the room that both share.
pub fn leave_room_for_blocks(request: &Request, ribs: &Ribs, least: f32, room: &mut IdVec<VertexId, f32>) {
    let mut needed: BTreeMap<VertexId, f32> = BTreeMap::new();
    for corner in junction_corners(request) {
        let part = mitre_part(ribs, corner).unwrap_or(f32::INFINITY);
        let most = needed.entry(request.topology.faces.vertex(corner)).or_insert(0.0);
        *most = most.max(part);
    }
    for (vertex, part) in needed {
        // A little less, as lines are not scaled exactly.
        let own = 0.99 * room[vertex] * MAX_BLOCK_SHARE / part;
        let is_free = request.is_open[vertex] && !is_crowded(request, ribs, vertex);
        if part > MAX_BLOCK_SHARE && own >= least && is_free {
            room[vertex] = own;
        }
    }
}

/// The positions along each marked edge of a junction: the nearer ones of the blocks on its two sides.
fn positions(t: &Topology, ribs: &Ribs, corners: &[CornerId]) -> Positions {
    let mut positions = Positions::new();
    for &corner in corners {
        let Some(rib) = ribs.within(corner).map(|rib| &ribs.all[rib]) else { continue };
        let Path::Face { after, before, .. } = rib.path else { continue };
        let edges = [t.corner_edge[corner], t.corner_edge[t.faces.prev(corner)]];
        for (edge, mark, part) in [(edges[0], edges[1], after), (edges[1], edges[0], before)] {
            let own: Vec<f32> = rib.steps.iter().map(|step| step * part).collect();
            let (known, _) = positions.entry((edge, rib.vertex)).or_insert_with(|| (own.clone(), mark));
            known.iter_mut().zip(&own).for_each(|(known, own)| *known = known.min(*own));
        }
    }
    positions
}
