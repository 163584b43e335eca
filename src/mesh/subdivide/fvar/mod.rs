//! The topology of face-varying data, such as UVs: regions, cut edges, and the refinement rule of each value.
//!
//! A *value* is a row of the primvar that one or more corners of a vertex share. Faces joined by shared values form a
//! *region*. A vertex with one value and no cut edge follows the vertex masks. Elsewhere the border of the region
//! selects the mask, by `faceVaryingLinearInterpolation`. Source: OpenSubdiv, `vtr/fvarLevel.cpp`.

mod child;

pub use child::{ChannelChild, ChildValues};

use super::level::{self, INFINITE_SHARPNESS, Level};
use crate::connectivity::{CornerId, EdgeId, IdVec, Topology, ValueId, VertexId};
use crate::garment::{BoundaryInterpolation, FaceVaryingInterpolation, Scheme};

/// The rule that refines a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tag {
    /// The mask of the vertex.
    Match,
    /// The value stays.
    Corner,
    /// A crease along the border of the region.
    Crease,
    /// A corner while semi-sharp edges last, then a crease. A `dependent` value follows the sharp edges in the region
    /// of the vertex's other value.
    Semi { dependent: bool },
}

/// The state of an edge in a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct EdgeTag {
    /// The values of its faces differ.
    cut: bool,
    /// Its middle is linear and sharp at all finer levels.
    linear: bool,
}

/// The topology of one face-varying channel at one level.
#[derive(Clone, Debug)]
pub struct Channel {
    /// The value of each corner.
    pub corner_value: IdVec<CornerId, ValueId>,
    /// One corner of each value.
    pub value_corner: IdVec<ValueId, CornerId>,
    tags: IdVec<ValueId, Tag>,
    edges: IdVec<EdgeId, EdgeTag>,
    mode: FaceVaryingInterpolation,
}

impl Channel {
    /// Builds the channel of `level` from the primvar row of each corner; also returns the row of each value.
    pub fn base(
        level: &Level,
        rows: impl Fn(CornerId) -> usize,
        mode: FaceVaryingInterpolation,
        boundary: BoundaryInterpolation,
    ) -> (Self, Vec<u32>) {
        let t = &level.topology;
        let corners = t.faces.corners().len();
        let mut corner_value = IdVec::filled(ValueId::new(0), corners);
        let mut value_corner = IdVec::new();
        let mut value_rows: Vec<u32> = Vec::new();
        for vertex in (0..t.vertex_count()).map(VertexId::new) {
            let first = value_rows.len();
            for &corner in t.vertex_corners.row(vertex) {
                let row = rows(corner) as u32;
                let known = value_rows[first..].iter().position(|&r| r == row);
                corner_value[corner] = known.map_or_else(
                    || {
                        value_rows.push(row);
                        value_corner.push(corner)
                    },
                    |i| ValueId::new(first + i),
                );
            }
        }
        let mut channel = Self {
            tags: IdVec::filled(Tag::Match, value_rows.len()),
            edges: IdVec::filled(EdgeTag::default(), t.edges.len()),
            corner_value,
            value_corner,
            mode,
        };
        channel.tag_edges(t);
        channel.tag_values(level, boundary);
        (channel, value_rows)
    }

    /// Number of values.
    pub fn len(&self) -> usize {
        self.value_corner.len()
    }

    /// `true` if there is no value.
    pub fn is_empty(&self) -> bool {
        self.value_corner.is_empty()
    }

    /// `true` if the values of the faces at an edge differ.
    pub fn is_cut(&self, edge: EdgeId) -> bool {
        self.edges[edge].cut
    }

    /// Estimated memory. \[bytes\]
    pub fn bytes(&self) -> usize {
        let values = size_of_val(self.value_corner.as_slice()) + size_of_val(self.tags.as_slice());
        size_of_val(self.corner_value.as_slice()) + values + size_of_val(self.edges.as_slice())
    }

    fn linear_boundaries(&self) -> bool {
        matches!(self.mode, FaceVaryingInterpolation::All | FaceVaryingInterpolation::Boundaries)
    }

    fn dependent_sharpness(&self) -> bool {
        matches!(self.mode, FaceVaryingInterpolation::CornersPlus1 | FaceVaryingInterpolation::CornersPlus2)
    }

    fn is_linear(&self, level: &Level) -> bool {
        self.mode == FaceVaryingInterpolation::All || matches!(level.scheme, Scheme::Bilinear | Scheme::None)
    }

    /// The values at the two ends of a half-edge, in the edge's own direction.
    #[inline]
    fn ends(&self, t: &Topology, half: CornerId, edge: EdgeId) -> [ValueId; 2] {
        let ends = [self.corner_value[half], self.corner_value[t.faces.next(half)]];
        if t.faces.vertex(half) == t.edges[edge][0] { ends } else { [ends[1], ends[0]] }
    }

    fn tag_edges(&mut self, t: &Topology) {
        for edge in t.edges.ids() {
            let halves = t.edge_corners.row(edge);
            let first = self.ends(t, halves[0], edge);
            let cut = halves[1..].iter().any(|&h| self.ends(t, h, edge) != first);
            let linear = self.linear_boundaries() && (cut || halves.len() == 1);
            self.edges[edge] = EdgeTag { cut, linear };
        }
    }

    fn tag_values(&mut self, level: &Level, boundary: BoundaryInterpolation) {
        let t = &level.topology;
        let sharpen_smooth_corners =
            boundary != BoundaryInterpolation::EdgeAndCorner && self.mode != FaceVaryingInterpolation::None;
        for vertex in (0..t.vertex_count()).map(VertexId::new) {
            let corners = t.vertex_corners.row(vertex);
            let Some(&first) = corners.first() else { continue };
            let on_border = level::edges_at(t, vertex).any(|e| t.is_border(e));
            let several = corners.iter().any(|&c| self.corner_value[c] != self.corner_value[first]);
            if several
                || level::edges_at(t, vertex).any(|e| self.edges[e].cut)
                || on_border && self.linear_boundaries()
                || on_border && corners.len() == 1 && sharpen_smooth_corners
            {
                self.tag_mismatch(level, vertex, on_border);
            }
        }
    }

    /// Tags the values of a vertex that does not follow the vertex masks.
    fn tag_mismatch(&mut self, level: &Level, vertex: VertexId, on_border: bool) {
        let t = &level.topology;
        let non_manifold = level::is_non_manifold_vertex(t, vertex);
        let spans = self.spans(level, vertex, on_border, non_manifold);
        let plus2 = self.mode == FaceVaryingInterpolation::CornersPlus2;
        let corners_sharp = self.mode != FaceVaryingInterpolation::None;
        let sharpness = level.vertex_sharpness[vertex];
        let mut all_sharp = self.linear_boundaries()
            || sharpness >= INFINITE_SHARPNESS
            || non_manifold
            || self.dependent_sharpness() && spans.len() > 2
            || plus2 && spans.len() == 1 && !on_border;
        let mut dependent = false;
        if let (false, true, [a, b]) = (all_sharp, self.dependent_sharpness(), spans.as_slice()) {
            let sharp = |s: &Span| s.infinite > 0 || s.is_disjoint || plus2 && s.size == 1;
            all_sharp = sharp(a) || sharp(b);
            dependent = (a.semi > 0) != (b.semi > 0);
        }
        for span in &spans {
            let sharp = span.is_disjoint || all_sharp || span.infinite > 0 || span.size == 1 && corners_sharp;
            self.tags[span.value] = if sharp {
                Tag::Corner
            } else if span.semi > 0 || sharpness > 0.0 {
                Tag::Semi { dependent: false }
            } else if dependent {
                Tag::Semi { dependent: true }
            } else {
                Tag::Crease
            };
        }
    }

    /// Groups the faces around a vertex by value.
    fn spans(&self, level: &Level, vertex: VertexId, on_border: bool, non_manifold: bool) -> Vec<Span> {
        let t = &level.topology;
        let corners = t.vertex_corners.row(vertex);
        let mut spans: Vec<Span> = Vec::new();
        for &corner in corners {
            let value = self.corner_value[corner];
            let at = spans.iter().position(|s| s.value == value).unwrap_or_else(|| {
                spans.push(Span::new(value));
                spans.len() - 1
            });
            let span = &mut spans[at];
            span.size += 1;
            let edge = t.corner_edge[corner];
            if t.is_border(edge) {
                continue;
            }
            // An edge is inside the span if both of its faces have the value at this vertex.
            let before = t.twin(corner).map(|twin| self.corner_value[t.faces.next(twin)]);
            if before != Some(value) {
                span.begins += 1;
            } else if self.edges[edge].cut {
                span.slits += 1;
            } else {
                let sharpness = level.edge_sharpness[edge];
                span.infinite += usize::from(sharpness >= INFINITE_SHARPNESS);
                span.semi += usize::from(sharpness > 0.0 && sharpness < INFINITE_SHARPNESS);
            }
        }
        let single_interior = spans.len() == 1 && !on_border;
        for span in &mut spans {
            let open_start =
                corners.iter().any(|&c| self.corner_value[c] == span.value && t.is_border(t.corner_edge[c]));
            span.is_disjoint = non_manifold
                || if single_interior {
                    span.slits > 1
                } else {
                    span.slits > 0 || span.begins + usize::from(open_start) > 1
                };
        }
        spans
    }
}

/// The faces around a vertex that share a value.
struct Span {
    value: ValueId,
    /// Number of faces.
    size: usize,
    /// Edges at which the span begins.
    begins: usize,
    /// Cut edges inside the span: both faces have the value at this vertex, but not at the far end.
    slits: usize,
    /// Infinitely sharp edges inside the span.
    infinite: usize,
    /// Semi-sharp edges inside the span.
    semi: usize,
    /// The faces form more than one fan.
    is_disjoint: bool,
}

impl Span {
    fn new(value: ValueId) -> Self {
        Self { value, size: 0, begins: 0, slits: 0, infinite: 0, semi: 0, is_disjoint: false }
    }
}
