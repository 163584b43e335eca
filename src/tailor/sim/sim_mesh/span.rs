//! The constraints on vertices and edges.

use super::SimMesh;
use std::num::NonZeroU32;
use tailor_mesh::connectivity::edit::prev;
use tailor_mesh::connectivity::{ChainId, CornerId, SpanId, VertexId};

/// The freedom of a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VertexConstraint {
    /// Moves anywhere on the surface.
    Free,
    /// Slides, splits and collapses along one chain.
    OnCurve(ChainId),
    /// Stays: an anchor.
    Fixed,
}

/// The part of a chain's curve that a constrained half-edge follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveSpan {
    /// The chain.
    pub chain: ChainId,
    /// Arc length at the half-edge's start. Loops may count beyond their length. \[mesh units\]
    pub from: f32,
    /// Arc length at its end. \[mesh units\]
    pub to: f32,
    /// Number of edges that the chain asks for up to `from` and up to `to`.
    pub counts: [f32; 2],
    /// Whether the half-edge runs along the chain. Arc lengths alone cannot tell for an edge of zero length.
    pub forward: bool,
}

impl CurveSpan {
    /// The span of the twin.
    pub fn reversed(self) -> Self {
        let [from, to] = self.counts;
        Self { from: self.to, to: self.from, counts: [to, from], forward: !self.forward, ..self }
    }

    /// Whether a span in its chain's direction has no length left.
    pub fn is_reversed(self) -> bool {
        self.from >= self.to
    }

    /// Number of edges that the chain asks for here.
    pub fn count(self) -> f32 {
        (self.counts[1] - self.counts[0]).abs()
    }

    /// The span in the chain's own direction.
    pub fn along(self) -> Self {
        if self.forward { self } else { self.reversed() }
    }
}

/// The id of a half-edge's span and its direction along it. `Option` of it takes four bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DirectedSpan(NonZeroU32);

impl DirectedSpan {
    pub fn new(span: SpanId, forward: bool) -> Self {
        Self(NonZeroU32::MIN.saturating_add(2 * span.index() as u32 + u32::from(forward)))
    }

    pub fn span(self) -> SpanId {
        SpanId::new((self.0.get() - 1) as usize / 2)
    }

    /// The same direction along the span whose index is larger by `by`.
    pub fn shifted(self, by: usize) -> Self {
        Self::new(SpanId::new(self.span().index() + by), self.is_forward())
    }

    pub fn is_forward(self) -> bool {
        (self.0.get() - 1) % 2 == 1
    }

    pub fn reversed(self) -> Self {
        Self::new(self.span(), !self.is_forward())
    }
}

/// The two constrained edges at a vertex of one chain.
pub struct CurveNeighbours {
    /// The half-edge that leaves the vertex along the chain; at a border it may be the one that arrives instead.
    pub ahead: CornerId,
    /// The half-edge that leaves against the chain; at a border it may be the one that arrives instead.
    pub back: CornerId,
    /// The span ahead, in the chain's direction.
    pub after: CurveSpan,
    /// The span behind, in the chain's direction. A loop's two spans may count from different turns.
    pub before: CurveSpan,
}

impl CurveNeighbours {
    /// Arc length at the vertex. \[mesh units\]
    pub fn arc_length(&self) -> f32 {
        self.before.to
    }

    /// Lengths of the curve behind the vertex and ahead of it. \[mesh units\]
    pub fn lengths(&self) -> [f32; 2] {
        [self.before.to - self.before.from, self.after.to - self.after.from]
    }
}

impl SimMesh<'_> {
    /// The constrained edges at a vertex of one chain.
    pub fn curve_neighbours(&self, vertex: VertexId) -> Option<CurveNeighbours> {
        let mut found = [None; 2];
        for c in self.topology.fan(vertex) {
            for half in [c, prev(c)] {
                let Some(span) = self.corner_span[half] else { continue };
                let leaves = half == c;
                let slot = &mut found[usize::from(span.is_forward() != leaves)];
                // The half-edge that leaves is preferred.
                if slot.is_none() || leaves {
                    *slot = Some(half);
                }
            }
        }
        let [ahead, back] = [found[0]?, found[1]?];
        Some(CurveNeighbours { ahead, back, after: self.span(ahead)?.along(), before: self.span(back)?.along() })
    }
}
