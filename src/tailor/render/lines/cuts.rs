//! The cuts of marked edges: where a hem begins to taper, and where the lines of other marked edges cross at a corner.
//!
//! ```text
//!  o--+--+--o--      The lines of two marked edges of a face form a *block* at the corner between them: a grid of
//!  |  |  |  |        lines. It leaves a junction as regular as it was: if mitres met in the vertex, a raised one would
//!  +--+--+--+--      look like a star. And where a single path turns, its inner lines turn as sharply as the outer ones.
//!  +--+--+--+--
//!  *==+==+==+==
//! ```

use super::LineRequest;
use super::paths::Widths;
use super::ribs::{MAX_EDGE_SHARE, MAX_SHARED_SHARE, Path, Rib, Ribs, sine};
use std::collections::{BTreeMap, BTreeSet};
use tailor_mesh::connectivity::{CornerId, EdgeId, Topology, VertexId};

/// Largest share of an edge that a block takes.
const MAX_BLOCK_SHARE: f32 = 0.75;
/// Least sine of the angle between two marked edges whose lines cross.
const MIN_BLOCK_SINE: f32 = 0.3;

/// A cut of a marked edge.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    /// Its position from the edge's first vertex, as a share of the edge.
    pub at: f32,
    /// Share of the height.
    pub height: f32,
    /// The line of the block that crosses the edge here; none for a taper.
    pub block: Option<BlockLine>,
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
    pub fn new(request: &LineRequest, ribs: &Ribs, widths: &Widths) -> Self {
        let t = request.topology;
        let corners = block_corners(request, ribs);
        let positions = positions(request, ribs, &corners);
        let of = |edge: EdgeId, corner: CornerId| positions[&(edge, t.faces.vertex(corner))].0.clone();
        let blocks = corners.iter().map(|&c| {
            let edges = [t.corner_edge[c], t.corner_edge[t.faces.prev(c)]];
            (c, edges.map(|edge| of(edge, c)))
        });
        let mut cuts = Self { blocks: blocks.collect(), of_edges: BTreeMap::new() };
        for (&(edge, vertex), (steps, mark)) in &positions {
            let is_first = t.edges[edge][0] == vertex;
            let [from, to] = if is_first { t.edges[edge] } else { [vertex, t.edges[edge][0]] };
            let height = |step: f32| widths.heights[from] + step * (widths.heights[to] - widths.heights[from]);
            let at = |step: f32| if is_first { step } else { 1.0 - step };
            let block = |line| Some(BlockLine { vertex, line, mark: *mark });
            let new = steps.iter().enumerate().map(|(line, &step)| Cut {
                at: at(step),
                height: if request.tapers[vertex] { height(step) } else { height(0.0) },
                block: block(line),
            });
            cuts.of_edges.entry(edge).or_default().extend(new);
        }
        cuts.add_tapers(request, widths);
        cuts.of_edges.values_mut().for_each(|all| all.sort_by(|a, b| a.at.total_cmp(&b.at)));
        cuts
    }

    /// Adds the cuts of tapers.
    fn add_tapers(&mut self, request: &LineRequest, widths: &Widths) {
        let t = request.topology;
        for (edge, tapers) in widths.cuts.enumerated().filter(|(edge, _)| request.marked[*edge]) {
            for (from_second, part) in tapers.iter().enumerate().filter_map(|(i, part)| Some((i, (*part)?))) {
                let height = widths.heights[t.edges[edge][1 - from_second]];
                let at = if from_second == 0 { part } else { 1.0 - part };
                self.add_taper(edge, Cut { at, height, block: None }, from_second == 0);
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

/// Corners of two marked edges whose lines cross, rather than meet in a diagonal of a face. Where one corner of a vertex is too
/// sharp or small, all of its lines meet in diagonals: the faces of blocks would be slivers.
fn block_corners(request: &LineRequest, ribs: &Ribs) -> Vec<CornerId> {
    let t = request.topology;
    let is_marked = |c: CornerId| request.marked[t.corner_edge[c]];
    let corners = t.faces.corners().ids().filter(|&c| is_marked(c) && is_marked(t.faces.prev(c)));
    let mut corners: Vec<CornerId> = corners.filter(|&c| ribs.within(c).is_some()).collect();
    let crowded: BTreeSet<VertexId> =
        corners.iter().filter(|&&c| !has_room(request, ribs, c)).map(|&c| t.faces.vertex(c)).collect();
    corners.retain(|&c| !crowded.contains(&t.faces.vertex(c)));
    corners
}

/// Whether the lines of two marked edges can cross at a corner between them.
fn has_room(request: &LineRequest, ribs: &Ribs, corner: CornerId) -> bool {
    let t = request.topology;
    let Some(Path::Face { after, before, .. }) = ribs.within(corner).map(|rib| ribs.all[rib].path) else {
        return false;
    };
    t.faces.valence(t.faces.face_of(corner)) == 4
        && sine(request, corner) > MIN_BLOCK_SINE
        && after.max(before) < MAX_BLOCK_SHARE
}

/// Where the lines of blocks cross marked edges: the nearer ones of the blocks on both sides of an edge. The lines ahead of an
/// end cross its edge behind it too, so that the end is between even lines.
fn positions(request: &LineRequest, ribs: &Ribs, corners: &[CornerId]) -> Positions {
    let t = request.topology;
    let mut positions = Positions::new();
    let mut add = |(edge, mark): (EdgeId, EdgeId), rib: &Rib, part: f32| {
        let own: Vec<f32> = rib.steps.iter().map(|step| step * part).collect();
        let (known, _) = positions.entry((edge, rib.vertex)).or_insert_with(|| (own.clone(), mark));
        known.iter_mut().zip(&own).for_each(|(known, own)| *known = known.min(*own));
    };
    for &corner in corners {
        let Some(rib) = ribs.within(corner).map(|rib| &ribs.all[rib]) else { continue };
        let Path::Face { after, before, .. } = rib.path else { continue };
        let edges = [t.corner_edge[corner], t.corner_edge[t.faces.prev(corner)]];
        add((edges[0], edges[1]), rib, after);
        add((edges[1], edges[0]), rib, before);
    }
    let length = |edge: EdgeId| request.points[t.edges[edge][0]].distance(request.points[t.edges[edge][1]]);
    for rib in ribs.all.iter().filter(|rib| request.tapers[rib.vertex]) {
        let Path::Edge { to, part } = rib.path else { continue };
        let Some(along) = t.find_edge(rib.vertex, to) else { continue };
        add((rib.mark, rib.mark), rib, (part * length(along) / length(rib.mark)).min(MAX_EDGE_SHARE));
    }
    fit_between(t, &mut positions);
    positions
}

/// Draws the lines of two blocks on one edge together so that they stay apart.
fn fit_between(t: &Topology, positions: &mut Positions) {
    let last = |positions: &Positions, key| positions.get(&key).and_then(|(steps, _)| steps.last().copied());
    let edges: BTreeSet<EdgeId> = positions.keys().map(|&(edge, _)| edge).collect();
    for edge in edges {
        let keys = t.edges[edge].map(|vertex| (edge, vertex));
        let [Some(a), Some(b)] = keys.map(|key| last(positions, key)) else { continue };
        let scale = (MAX_SHARED_SHARE / (a + b)).min(1.0);
        for key in keys {
            if let Some((steps, _)) = positions.get_mut(&key) {
                steps.iter_mut().for_each(|step| *step *= scale);
            }
        }
    }
}
