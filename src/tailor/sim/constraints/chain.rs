//! A chain: a path or loop of constrained edges with its curve on the surface.

use glam::Vec3;
use tailor_mesh::connectivity::{CornerId, VertexId};

/// The features that a constrained edge of the cage belongs to.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct ChainKind {
    /// A border of the mesh, or of its holes.
    pub border: bool,
    /// A border of a UV shell.
    pub seam: bool,
    /// An infinitely sharp edge inside the mesh: the surface has a sharp edge there at every level.
    pub sharp: bool,
    /// A feature line: sharper than the target length can follow, or beside one that is too near to be a chain itself.
    pub feature: bool,
    /// Indices into the garment's subsets: the edge subsets that hold the edge.
    pub subsets: Vec<usize>,
    /// The features of the twin of the edge, where both sides have the same triangles: chains end on both where they end on one.
    pub twin: Option<Box<Self>>,
}

impl ChainKind {
    /// Nothing but a feature line.
    pub const FEATURE: Self =
        Self { border: false, seam: false, sharp: false, feature: true, subsets: Vec::new(), twin: None };
}

/// A path or loop of constrained edges, with its curve on the baseline.
#[derive(Clone, Debug)]
pub struct Chain {
    /// The features that all its edges belong to.
    pub kind: ChainKind,
    /// Whether it closes without an anchor.
    pub is_loop: bool,
    /// The garment's vertices along the chain; a loop repeats its first at the end. Where chains follow edges of the first
    /// refinement, a new vertex has the garment's vertex that its edge or face has first.
    pub cage: Vec<VertexId>,
    /// Vertices of the baseline along the curve; a loop repeats its first at the end.
    pub vertices: Vec<VertexId>,
    /// Arc length of the curve up to each vertex. \[mesh units\]
    pub along: Vec<f32>,
    /// The baseline's half-edge on the left of each segment; none where there is no face.
    pub left: Vec<Option<CornerId>>,
    /// The half-edge on the right of each segment, in the other direction.
    pub right: Vec<Option<CornerId>>,
    /// Unit normals that triangles should have to the left and to the right of each segment. On a feature line they are taken
    /// half a target length away, as the sharp edge itself is rounded.
    pub normals: Vec<[Vec3; 2]>,
    /// Corners: indices into `vertices` of those that stay where they are although no chain ends there.
    pub pins: Vec<usize>,
    /// Target edge length at each vertex, shortened where the curve bends. \[mesh units\]
    pub lengths: Vec<f32>,
    /// Number of edges that the curve asks for up to each vertex, as a real number.
    pub spaced: Vec<f32>,
}

/// A point of a chain's curve.
#[derive(Clone, Copy, Debug)]
pub struct CurvePoint {
    /// The segment.
    pub segment: usize,
    /// The fraction along it, 0 to 1.
    pub t: f32,
}

impl Chain {
    /// Length of the curve. \[mesh units\]
    pub fn length(&self) -> f32 {
        self.along[self.along.len() - 1]
    }

    /// Segments of the curve for each edge of the cage, or of the first refinement.
    pub fn step(&self) -> usize {
        (self.vertices.len() - 1) / (self.cage.len() - 1)
    }

    /// The vertices at the two ends of a path; none for a loop.
    pub fn ends(&self) -> impl Iterator<Item = VertexId> {
        [0, self.vertices.len() - 1].into_iter().filter(|_| !self.is_loop).map(|i| self.vertices[i])
    }

    /// The point at arc length `s`, which wraps around a loop and is clamped to a path.
    pub fn at(&self, s: f32) -> CurvePoint {
        self.at_with_turns(s).1
    }

    /// The point at arc length `s`, searched from segment `near` on, which is updated. Fast for points in sequence.
    pub fn at_after(&self, s: f32, near: &mut usize) -> CurvePoint {
        let (_, s) = self.wrapped(s);
        if self.along[*near] > s {
            *near = self.segment_at(s);
        }
        while *near + 2 < self.along.len() && self.along[*near + 1] <= s {
            *near += 1;
        }
        self.in_segment(s, *near)
    }

    /// Unit normal of the surface beside the curve, on the left of a half-edge that runs `forward` along it or backward.
    pub fn normal_at(&self, at: CurvePoint, forward: bool) -> Vec3 {
        self.normals[at.segment][usize::from(!forward)]
    }

    /// Full turns around a loop up to arc length `s`, and the point there.
    pub fn at_with_turns(&self, s: f32) -> (f32, CurvePoint) {
        let (turns, s) = self.wrapped(s);
        (turns, self.in_segment(s, self.segment_at(s)))
    }

    /// Full turns around a loop up to arc length `s`, and the arc length left over.
    fn wrapped(&self, s: f32) -> (f32, f32) {
        let length = self.length();
        let turns = if self.is_loop && length > 0.0 { (s / length).floor() } else { 0.0 };
        (turns, (s - turns * length).clamp(0.0, length))
    }

    fn segment_at(&self, s: f32) -> usize {
        segment_of(&self.along, s)
    }

    fn in_segment(&self, s: f32, segment: usize) -> CurvePoint {
        CurvePoint { segment, t: fraction(&self.along, s, segment) }
    }
}

/// The segment of ascending `values` that holds `value`; the last one beyond their end.
pub fn segment_of(values: &[f32], value: f32) -> usize {
    values.partition_point(|&v| v <= value).saturating_sub(1).min(values.len() - 2)
}

/// The fraction of a segment of ascending `values` at which `value` lies, 0 to 1; 0 in an empty segment.
pub fn fraction(values: &[f32], value: f32, segment: usize) -> f32 {
    let extent = values[segment + 1] - values[segment];
    if extent > 0.0 { ((value - values[segment]) / extent).clamp(0.0, 1.0) } else { 0.0 }
}
