//! Edge loops beside marked edges, for seams and hems: each face beside a marked edge is cut by lines parallel to it.
//!
//! ```text
//!  |   |   |   |            The marked edges (=) keep their position. From each of their vertices *ribs* lead away:
//!  o---o---o---o  support   along unmarked edges, or into a face where two of its marked edges meet (a mitre).
//!  o---o---o---o  width     Lines connect the ribs at equal steps. The rest of each face is its core.
//!  *===*===*===*  marked
//!  o---o---o---o            Where several unmarked edges are between two marked ones, as outside a bend, each face
//!  o---o---o---o            between them gets a corner block: quads on both sides of one more rib.
//!  |   |   |   |
//! ```
//!
//! At the end of a path inside the surface, lines lead around it. A path that ends at a border runs off it. Where paths
//! meet or turn, the lines of each cross those of the others.
//!
//! `paths` computes the share of the distance at each vertex, `ribs` the ribs and their steps in each face, `cuts` the
//! cuts of marked edges, `points` the weights of the new vertices; `faces` builds the faces between them, and `blocks` those of
//! junctions.

mod blocks;
mod cuts;
mod faces;
mod paths;
mod points;
mod ribs;

use super::child::ChildBuilder;
use super::operator::REPORTED;
use cuts::Cuts;
use glam::Vec3;
use paths::Widths;
use ribs::Ribs;
use tailor_mesh::connectivity::{CornerId, EdgeId, FaceId, IdVec, Topology, VertexId};

/// A request for lines beside marked edges.
pub struct LineRequest<'a> {
    /// The parent's connectivity.
    pub topology: &'a Topology,
    /// The positions of its vertices.
    pub points: &'a IdVec<VertexId, Vec3>,
    /// Their places on the surface, between which distances are measured.
    pub on_surface: &'a IdVec<VertexId, Vec3>,
    /// True for edges that get lines.
    pub marked: IdVec<EdgeId, bool>,
    /// For each half-edge of a marked edge, the distance that `shares` scale. \[mesh units\]
    pub distance: IdVec<CornerId, f32>,
    /// True for ends inside the surface, where heights go to nothing.
    pub tapers: IdVec<VertexId, bool>,
    /// True for other ends with a taper: their last edge is cut where it begins.
    pub ends: IdVec<VertexId, bool>,
    /// True for vertices without heights, whose lines keep their distance.
    pub flat: IdVec<VertexId, bool>,
    /// For each marked edge, the length of a taper at its end; 0 for none. \[mesh units\]
    pub taper_length: IdVec<EdgeId, f32>,
    /// True for ends inside the surface around which the lines have the heights beside them.
    pub round: IdVec<VertexId, bool>,
    /// True for faces that may be cut. The others get vertices on shared edges alone.
    pub cuttable: IdVec<FaceId, bool>,
    /// Distances of the lines from the marked edge, as ascending shares of `distance`.
    pub shares: &'a [f32],
    /// Index of the last line that keeps its distance in narrow faces. At most one line follows, which moves first.
    pub kept_line: usize,
    /// True if a narrow face also narrows the lines beside its neighbours, so that their width changes evenly.
    pub is_even: bool,
}

/// A new vertex.
#[derive(Clone, Copy, Debug)]
pub struct LineVertex {
    /// The vertex.
    pub vertex: VertexId,
    /// Index of its line, from 0 nearest to the marked edge; none on the marked edge itself.
    pub line: Option<usize>,
    /// The marked edge of the line.
    pub mark: EdgeId,
    /// Share of the height: below 1 at tapers and in narrow faces.
    pub height: f32,
    /// The line of another marked edge that crosses here, at a junction.
    pub crossing: Option<Crossing>,
}

/// A line that crosses another one.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    /// Index of the line.
    pub line: usize,
    /// Its marked edge.
    pub mark: EdgeId,
}

/// A face between lines.
#[derive(Clone, Copy, Debug)]
pub struct StripFace {
    /// The face.
    pub face: FaceId,
    /// Index of the line on its outer side.
    pub line: usize,
    /// The marked edge of the line.
    pub mark: EdgeId,
}

/// A vertex beside which lines are nearer than requested.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NarrowVertex {
    /// The vertex on the marked edge.
    pub vertex: VertexId,
    /// The marked edge.
    pub mark: EdgeId,
    /// Share of the requested distance.
    pub share: f32,
}

/// A mesh with lines.
pub struct Lines<'a> {
    /// The child, to which more elements can be added.
    pub builder: ChildBuilder<'a>,
    /// Vertices of the lines, and vertices that cut marked edges.
    pub vertices: Vec<LineVertex>,
    /// Faces between the lines.
    pub strips: Vec<StripFace>,
    /// Index of the first child of each parent face, and of the end of the last.
    pub first_child: Vec<usize>,
    /// The ends of marked edges with narrowed lines.
    pub narrowed: Vec<NarrowVertex>,
    /// Share of the height at each parent vertex.
    pub heights: IdVec<VertexId, f32>,
    /// True for parent vertices of cut faces.
    pub near: IdVec<VertexId, bool>,
}

/// Inserts lines.
pub fn insert<'a>(request: &LineRequest<'a>) -> Lines<'a> {
    let mut widths = Widths::tapered(request);
    let mut ribs = Ribs::new(request, &widths.shares);
    let own_room = ribs.room.clone();
    let mut room = own_room.clone();
    if request.is_even && room.iter().any(|&room| room < 1.0) {
        let eased = widths.ease(request, &room);
        ribs = Ribs::new(request, &widths.shares);
        room = eased.iter().zip(ribs.room.iter()).map(|(eased, room)| eased * room).collect();
    }
    widths.heights.iter_mut().zip(room.iter()).for_each(|(height, room)| *height *= room);
    let cuts = Cuts::new(request, &ribs, &widths);
    Lines { narrowed: narrow_ends(request, &own_room, &room), ..faces::build(request, &ribs, &cuts, &widths) }
}

/// The ends of marked edges with less room of their own than is worth a report, and what is left of the width there.
fn narrow_ends(
    request: &LineRequest,
    own_room: &IdVec<VertexId, f32>,
    room: &IdVec<VertexId, f32>,
) -> Vec<NarrowVertex> {
    let marked = request.marked.ids().filter(|&edge| request.marked[edge]);
    let ends = marked.flat_map(|mark| request.topology.edges[mark].map(|vertex| (vertex, mark)));
    let narrowed = ends.map(|(vertex, mark)| NarrowVertex { vertex, mark, share: room[vertex] });
    narrowed.filter(|n| own_room[n.vertex] < REPORTED && !request.tapers[n.vertex]).collect()
}
