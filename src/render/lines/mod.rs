//! Lines of edges beside marked edges: the topology that seams and hems share.
//!
//! ```text
//!  |   |   |   |            The marked edges (=) stay as they are. From each of their vertices *ribs* lead away: along
//!  o---o---o---o  hold      the unmarked edges there, or into the face where two marked edges meet in it (a mitre).
//!  o---o---o---o  width     Lines join ribs at equal steps, and what is left of each face is its core.
//!  *===*===*===*  marked
//!  o---o---o---o            Where several unmarked edges lie between two marked ones, as outside a bend, each face
//!  o---o---o---o            between them gets a corner block of quads about one more rib.
//!  |   |   |   |
//! ```
//!
//! A path that ends inside the surface tapers: its last vertex has no rib. Where lines turn a corner at the other end of
//! its last edge, that is cut halfway, so that what narrows to triangles does not begin at the corner: Catmull-Clark rounds
//! triangles and quads differently, and lines that lie closer than that would pass each other. A path that ends at a border
//! runs off it.

mod faces;
mod ribs;

use super::derivation::Builder;
use crate::mesh::{CornerId, EdgeId, FaceId, IdVec, Topology, VertexId};
use glam::Vec3;

/// What lines to insert.
pub struct Request<'a> {
    /// The parent's connectivity.
    pub topology: &'a Topology,
    /// Where its vertices are.
    pub points: &'a IdVec<VertexId, Vec3>,
    /// Edges that get lines.
    pub marked: IdVec<EdgeId, bool>,
    /// For each half-edge of a marked edge, the distance that shares are of. \[stage units\]
    pub distance: IdVec<CornerId, f32>,
    /// Vertices at which lines come together to nothing.
    pub tapers: IdVec<VertexId, bool>,
    /// Faces that may be cut; others only get the cuts of edges that they share with those.
    pub cuttable: IdVec<FaceId, bool>,
    /// How far into the face the lines are, as shares of the distance, ascending.
    pub shares: &'a [f32],
    /// The last line that keeps its distance where room is short; at most one follows, which gives way first.
    pub kept_line: usize,
}

/// A new vertex.
#[derive(Clone, Copy, Debug)]
pub struct LineVertex {
    /// The vertex.
    pub vertex: VertexId,
    /// Number of its line, from 0 nearest to the marked edge; none: on the marked edge.
    pub line: Option<usize>,
    /// The marked edge that the line belongs to.
    pub mark: EdgeId,
    /// How wide the lines are apart here, as a part of what was asked: less where they taper or have no room.
    pub part: f32,
}

/// A face between lines.
#[derive(Clone, Copy, Debug)]
pub struct StripFace {
    /// The face.
    pub face: FaceId,
    /// Number of the line on its outer side.
    pub line: usize,
    /// The marked edge that the line belongs to.
    pub mark: EdgeId,
}

/// A place where the lines had to be nearer than asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Narrowed {
    /// The vertex of the marked edges there.
    pub vertex: VertexId,
    /// The marked edge.
    pub mark: EdgeId,
    /// What is left of the distance, as a share.
    pub share: f32,
}

/// A mesh with lines.
pub struct Lines<'a> {
    /// The child so far.
    pub builder: Builder<'a>,
    /// Vertices of the lines, and those that cut marked edges.
    pub vertices: Vec<LineVertex>,
    /// Faces between them.
    pub strips: Vec<StripFace>,
    /// The child faces of each parent face begin here; one more than there are parents.
    pub first_child: Vec<usize>,
    /// Where there was less room than asked, at most one a rib.
    pub narrowed: Vec<Narrowed>,
    /// How wide they are at each parent vertex, as a share of what was asked.
    pub widths: IdVec<VertexId, f32>,
    /// Parent vertices of faces that were cut.
    pub near: IdVec<VertexId, bool>,
}

/// Inserts lines.
pub fn insert<'a>(request: &Request<'a>) -> Lines<'a> {
    let ribs = ribs::Ribs::new(request);
    faces::build(request, &ribs)
}
