//! Lines at distances from chains of edges, along the surface: they cut the faces that they lead through.
//!
//! ```text
//!  o-----o-----o-----o
//!  |   / | \   |     |     A line (/ - \) is where the distance from the chain (=) has its value. It crosses edges, and goes
//!  o--+--o--+--+-----+     straight through faces, with a bend in the middle where the chain turns. Lines of different
//!  | /   |   \-|-----|     distances never cross, and lines from two parts of a chain join where they meet.
//!  o+----*=====*=====*
//! ```
//!
//! `field` finds the distance from the chains (`waves`: over one triangle), `crossings` where lines cross edges, `chords` how
//! they go through faces, and `faces` builds the parts of the faces.

mod chords;
mod crossings;
mod faces;
mod field;
mod trace;
mod waves;

use super::child::ChildBuilder;
use crossings::Crossings;
pub use field::{Field, Surface};
use glam::Vec3;
use tailor_mesh::connectivity::{EdgeId, FaceId, IdVec, Topology, VertexId};
pub use trace::{SurfaceLine, lines};

/// A path of edges.
pub struct Chain {
    /// The edges in their order, each with the vertex where it starts.
    pub edges: Vec<(EdgeId, VertexId)>,
    /// Whether lines fade at the start and at the end of the chain. They go on to the border elsewhere.
    pub fades: [bool; 2],
}

/// Places beside which lines fade: those where the distance from other chains is one of some distances.
pub struct Block<'a> {
    /// The distance from the other chains.
    pub field: Field<'a>,
    /// The distances, on the left and on the right.
    pub at: [Vec<f32>; 2],
    /// How near to them lines end. \[mesh units\]
    pub width: f32,
}

/// A request for lines.
pub struct ParallelRequest<'a> {
    /// The distance from the chains.
    pub field: Field<'a>,
    /// The chains.
    pub chains: &'a [Chain],
    /// Ascending distances of the lines on the left and on the right of the chains, equally many. \[mesh units\]
    pub distances: [Vec<f32>; 2],
    /// The share of the distance to the next line within which a line leads through a vertex rather than beside it.
    pub snap: f32,
    /// The length over which lines fade. \[mesh units\]
    pub fading: f32,
    /// Where they fade.
    pub blocks: Vec<Block<'a>>,
}

/// The place of a vertex among the lines.
#[derive(Clone, Copy, Debug)]
pub struct LinePlace {
    /// Index of its line; none between lines.
    pub line: Option<usize>,
    /// The side of the chain: 0 on its left, 1 on its right.
    pub side: usize,
    /// Distance from the chain. \[mesh units\]
    pub distance: f32,
    /// Share of the height: less than 1 where lines fade.
    pub share: f32,
}

/// A piece of a line through a face.
#[derive(Clone, Copy, Debug)]
pub struct Passage {
    /// Index of the line.
    pub line: usize,
    /// Index of the chain beside it.
    pub chain: usize,
    /// The side of the chain.
    pub side: usize,
    /// The part of the chain beside it, as lengths from the start of the chain. \[mesh units\]
    pub along: [f32; 2],
}

/// A mesh with lines.
pub struct Parallels<'a> {
    /// The child.
    pub builder: ChildBuilder<'a>,
    /// Vertices on lines and between them.
    pub vertices: Vec<(VertexId, LinePlace)>,
    /// The parts of faces that lines lead through.
    pub faces: Vec<FaceId>,
    /// The pieces of lines.
    pub passages: Vec<Passage>,
    /// True for parent vertices of cut faces.
    pub near: IdVec<VertexId, bool>,
}

/// Inserts lines.
pub fn insert<'a>(request: &ParallelRequest<'a>) -> Parallels<'a> {
    let mut crossings = Crossings::new(request);
    chords::end_before_blocks(request, &mut crossings);
    let (chords, passages) = chords::all(request, &crossings);
    faces::build(request, &crossings, &chords, passages)
}

impl<'a> ParallelRequest<'a> {
    fn topology(&self) -> &'a Topology {
        self.field.surface.topology
    }

    fn points(&self) -> &'a IdVec<VertexId, Vec3> {
        self.field.surface.points
    }
}
