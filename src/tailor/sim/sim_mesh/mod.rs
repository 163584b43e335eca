//! The mesh under remeshing: topology, positions, and the constraints on vertices and edges.

mod check;
mod edits;
mod moves;
mod patches;
mod quality;
mod reorder;
mod span;
mod start;
mod wedges;

pub use moves::{Destination, VertexMove};
pub use patches::{PATCH_SIZE, in_patches};
pub use quality::{Defect, MIN_COSINE, TriangleCorner};
pub use span::{CurveSpan, VertexConstraint};
pub use wedges::BaselineUvPoint;
pub use wedges::Wedge;

use crate::sim::baseline::Baseline;
use crate::sim::constraints::chain::{Chain, CurvePoint};
use crate::sim::geometry::distance_to_segment;
use glam::Vec3;
use patches::PatchVertex;
use span::DirectedSpan;
use tailor_mesh::connectivity::edit::EditMesh;
use tailor_mesh::connectivity::{ChainId, CornerId, IdVec, SpanId, VertexId, WedgeId};

/// The simulation mesh under remeshing.
#[derive(Clone)]
pub struct SimMesh<'a> {
    /// The surface that it lies on.
    pub baseline: &'a Baseline,
    /// Connectivity.
    pub topology: EditMesh,
    /// Positions. \[mesh units\]
    pub points: IdVec<VertexId, Vec3>,
    /// Target edge length at each vertex, shortened on chains that bend. \[mesh units\]
    pub target: IdVec<VertexId, f32>,
    /// The freedom of each vertex.
    pub constraint: IdVec<VertexId, VertexConstraint>,
    /// The span of each constrained half-edge.
    corner_span: IdVec<CornerId, Option<DirectedSpan>>,
    /// Parts of curves, in their chains' directions.
    spans: IdVec<SpanId, CurveSpan>,
    /// The wedge of each corner.
    pub corner_wedge: IdVec<CornerId, WedgeId>,
    /// The wedges. Those of removed vertices stay as gaps.
    pub wedges: IdVec<WedgeId, Wedge>,
    /// The vertices that a patch shares with others; empty for a whole mesh.
    patch_vertices: IdVec<VertexId, PatchVertex>,
}

impl<'a> SimMesh<'a> {
    /// The chain of an id.
    pub fn chain(&self, id: ChainId) -> &'a Chain {
        &self.baseline.chains[id]
    }

    /// Positions of a half-edge's ends. \[mesh units\]
    #[inline]
    pub fn end_points(&self, half: CornerId) -> [Vec3; 2] {
        self.topology.ends(half).map(|v| self.points[v])
    }

    /// Target length of the edge between two vertices. \[mesh units\]
    #[inline]
    pub fn target_between(&self, a: VertexId, b: VertexId) -> f32 {
        0.5 * (self.target[a] + self.target[b])
    }

    /// Target length of an edge. \[mesh units\]
    #[inline]
    pub fn target_of(&self, half: CornerId) -> f32 {
        self.target_between(self.topology.vertex(half), self.topology.target(half))
    }

    /// Length of a half-edge over its target, or the number of edges that a chain asks for there.
    #[inline]
    pub fn relative_length(&self, half: CornerId) -> f32 {
        match self.span(half) {
            Some(span) => span.count(),
            None => {
                let [a, b] = self.end_points(half);
                a.distance(b) / self.target_of(half)
            }
        }
    }

    /// Whether a half-edge is longer, or shorter, than a share of its target.
    #[inline]
    pub fn is_outside(&self, half: CornerId, share: f32, longer: bool) -> bool {
        if self.is_constrained(half) {
            return self.chain_edge_is_outside(half, share, longer);
        }
        let (a, b) = (self.topology.vertex(half), self.topology.target(half));
        let bound = share * self.target_between(a, b);
        (self.points[a].distance_squared(self.points[b]) > bound * bound) == longer
    }

    /// [`Self::is_outside`] for a constrained edge: out of line, which keeps the check of the many free edges fast.
    #[cold]
    fn chain_edge_is_outside(&self, half: CornerId, share: f32, longer: bool) -> bool {
        (self.relative_length(half) > share) == longer
    }

    /// Whether an edge is constrained.
    #[inline]
    pub fn is_constrained(&self, half: CornerId) -> bool {
        self.corner_span[half].is_some()
    }

    /// The part of a chain that a half-edge follows.
    #[inline]
    pub fn span(&self, half: CornerId) -> Option<CurveSpan> {
        self.corner_span[half].map(|own| {
            let span = self.spans[own.span()];
            if own.is_forward() { span } else { span.reversed() }
        })
    }

    /// Whether a half-edge's span has no length left: a vertex moved past the next one of its chain.
    #[inline]
    pub fn is_reversed(&self, half: CornerId) -> bool {
        self.corner_span[half].is_some_and(|own| self.spans[own.span()].is_reversed())
    }

    /// Sets the span of a half-edge and its twin.
    fn set_span(&mut self, half: CornerId, span: DirectedSpan) {
        self.corner_span[half] = Some(span);
        if let Some(t) = self.topology.twin(half) {
            self.corner_span[t] = Some(span.reversed());
        }
    }

    /// Adds a span, and sets it for a half-edge and its twin.
    fn add_span(&mut self, half: CornerId, span: CurveSpan) {
        let id = self.spans.push(span.along());
        self.set_span(half, DirectedSpan::new(id, span.forward));
    }

    /// Position of a point of a chain's curve. \[mesh units\]
    #[inline]
    fn position_on(&self, curve: &Chain, at: CurvePoint) -> Vec3 {
        let (a, b) = (curve.vertices[at.segment], curve.vertices[at.segment + 1]);
        self.baseline.points[a].lerp(self.baseline.points[b], at.t)
    }

    /// Position at arc length `s` of a chain's curve. \[mesh units\]
    pub fn on_curve(&self, chain: ChainId, s: f32) -> Vec3 {
        let curve = self.chain(chain);
        self.position_on(curve, curve.at(s))
    }

    /// Distances of a curve from a chord at ascending arc lengths from about `from` on. \[mesh units\]
    pub fn chord_distances(
        &self,
        curve: &Chain,
        from: f32,
        arc_lengths: impl Iterator<Item = f32>,
        [a, b]: [Vec3; 2],
    ) -> impl Iterator<Item = f32> {
        let mut near = curve.at(from).segment;
        arc_lengths.map(move |s| distance_to_segment(self.position_on(curve, curve.at_after(s, &mut near)), a, b))
    }
}
