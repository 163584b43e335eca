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
//! A path that ends inside the surface tapers: its last vertex has no rib. If the lines turn a corner at the other end
//! of the last edge, the edge is cut halfway, so that the triangles of the taper begin away from the corner.
//! Catmull-Clark rounds triangles and quads differently, and close lines would intersect there. A path that ends at a
//! border runs off it.
//!
//! `ribs` computes the ribs and their steps from the clearance in each face; `faces` builds the faces between them.

mod faces;
mod ribs;

use super::child::ChildBuilder;
use crate::mesh::{CornerId, EdgeId, FaceId, IdVec, Topology, VertexId};
use glam::Vec3;

/// A request for lines beside marked edges.
pub struct Request<'a> {
    /// The parent's connectivity.
    pub topology: &'a Topology,
    /// The positions of its vertices.
    pub points: &'a IdVec<VertexId, Vec3>,
    /// True for edges that get lines.
    pub marked: IdVec<EdgeId, bool>,
    /// For each half-edge of a marked edge, the distance that `shares` scale. \[mesh units\]
    pub distance: IdVec<CornerId, f32>,
    /// True for vertices where lines taper to nothing.
    pub tapers: IdVec<VertexId, bool>,
    /// True for faces that may be cut. The others get vertices on shared edges alone.
    pub cuttable: IdVec<FaceId, bool>,
    /// Distances of the lines from the marked edge, as ascending shares of `distance`.
    pub shares: &'a [f32],
    /// Index of the last line that keeps its distance in narrow faces. At most one line follows, which moves first.
    pub kept_line: usize,
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
    /// Share of the requested distance: below 1 at tapers and in narrow faces.
    pub part: f32,
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
pub struct Narrowed {
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
    /// Vertices with narrowed lines, at most one per rib.
    pub narrowed: Vec<Narrowed>,
    /// Share of the requested distance at each parent vertex.
    pub widths: IdVec<VertexId, f32>,
    /// True for parent vertices of cut faces.
    pub near: IdVec<VertexId, bool>,
}

/// Inserts lines.
pub fn insert<'a>(request: &Request<'a>) -> Lines<'a> {
    let ribs = ribs::Ribs::new(request);
    faces::build(request, &ribs)
}
