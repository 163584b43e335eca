//! Refines a face-varying channel: numbers the child values, tags them, and gives the mask of each.
//!
//! Source: OpenSubdiv, `vtr/fvarRefinement.cpp` and `far/primvarRefiner.h`.

use super::{Channel, EdgeTag, Tag};
use crate::connectivity::{CornerId, EdgeId, FaceId, IdVec, Topology, ValueId};
use crate::garment::Scheme;
use crate::subdivide::level::{self, INFINITE_SHARPNESS, Level};
use crate::subdivide::masks;
use crate::subdivide::regular::Quads;
use crate::subdivide::split::{Numbering, child_corner, child_quads_of};
use crate::subdivide::stencil::Stencils;
use std::sync::Arc;

/// The refinement of one channel.
pub struct ChannelChild<'a> {
    level: &'a Level,
    parent: &'a Channel,
    quads: Option<Quads<'a, ValueId>>,
    values: Arc<ChildValues>,
}

impl<'a> ChannelChild<'a> {
    /// The refinement of a channel of `level`.
    pub fn new(level: &'a Level, parent: &'a Channel) -> Self {
        Self::of(level, parent, Arc::new(ChildValues::new(parent, level)))
    }

    /// The refinement of a channel whose child values are already numbered.
    pub fn of(level: &'a Level, parent: &'a Channel, values: Arc<ChildValues>) -> Self {
        let quads = if parent.is_linear(level) { None } else { Quads::new(level, &parent.corner_value) };
        Self { level, parent, quads, values }
    }

    /// Emits the row of an all-quad level; `false` without output if the row needs a sharp or face-varying mask.
    #[inline(always)]
    fn regular_row(&self, quads: &Quads<ValueId>, row: usize, sink: &mut impl FnMut(ValueId, f32)) -> bool {
        let (own, faces, t) = (self.parent.len(), self.values.faces, &self.level.topology);
        if row >= own && row < own + faces {
            quads.face(FaceId::new(row - own), sink);
            return true;
        }
        if self.values.tags[ValueId::new(row)] != Tag::Match {
            return false;
        }
        if row < own {
            return quads.vertex(t.faces.vertex(self.parent.value_corner[ValueId::new(row)]), sink);
        }
        quads.edge(t.corner_edge[self.values.halves[row - own - faces]], sink)
    }

    /// The value of each child corner.
    pub fn corner_values(&self) -> IdVec<CornerId, ValueId> {
        self.values.corner_values(self.parent, self.level, ValueId::new).into()
    }

    /// The value index of each child corner.
    pub fn indices(&self) -> Vec<u32> {
        self.values.corner_values(self.parent, self.level, |value| value as u32)
    }

    /// The child channel on the child's topology.
    pub fn into_channel(self, child: &Level) -> Channel {
        let t = &self.level.topology;
        let numbering = Numbering::new(self.level);
        let mut edges = IdVec::filled(EdgeTag::default(), child.topology.edges.len());
        for (edge, &tag) in self.parent.edges.enumerated().filter(|(_, t)| t.cut || t.linear) {
            for end in t.edges[edge] {
                if let Some(e) = child.topology.find_edge(end, numbering.of_edge(edge)) {
                    edges[e] = tag;
                }
            }
        }
        let value_corner = self.values.value_corners(self.parent, self.level);
        let corner_value = self.corner_values();
        Channel { corner_value, value_corner, tags: self.values.tags.clone(), edges, mode: self.parent.mode }
    }
}

impl Stencils for ChannelChild<'_> {
    type Source = ValueId;

    fn rows(&self) -> usize {
        self.values.tags.len()
    }

    #[inline(always)]
    fn row(&self, row: usize, sink: &mut impl FnMut(ValueId, f32)) {
        if self.quads.is_some_and(|quads| self.regular_row(&quads, row, sink)) {
            return;
        }
        let (parent, level) = (self.parent, self.level);
        let mut sink = |corner: CornerId, weight: f32| sink(parent.corner_value[corner], weight);
        let own = parent.len();
        let tag = self.values.tags[ValueId::new(row)];
        if row < own {
            parent.value_mask(level, ValueId::new(row), tag, &mut sink);
        } else if row < own + self.values.faces {
            masks::face(level, FaceId::new(row - own), 1.0, &mut sink);
        } else {
            let half = self.values.halves[row - own - self.values.faces];
            if tag == Tag::Match && !parent.is_linear(level) {
                masks::edge(level, level.topology.corner_edge[half], &mut sink);
            } else {
                sink(half, 0.5);
                sink(level.topology.faces.next(half), 0.5);
            }
        }
    }
}

impl Channel {
    /// The tags of the refined channel.
    fn child_tags(&self, parent: &Level, faces: usize, halves: &[CornerId]) -> IdVec<ValueId, Tag> {
        let t = &parent.topology;
        let mut tags = self.tags.clone();
        self.reclassify(parent, &mut tags);
        tags.resize(self.len() + faces, Tag::Match);
        let on_split_edge = if self.linear_boundaries() { Tag::Corner } else { Tag::Crease };
        tags.extend(halves.iter().map(|&half| {
            let tag = self.edges[t.corner_edge[half]];
            if tag.cut || tag.linear { on_split_edge } else { Tag::Match }
        }));
        tags
    }

    /// Tags semi-sharp values as creases once their sharp edges have faded.
    fn reclassify(&self, parent: &Level, tags: &mut IdVec<ValueId, Tag>) {
        let t = &parent.topology;
        let semi_values: Vec<ValueId> =
            self.tags.enumerated().filter(|(_, tag)| matches!(tag, Tag::Semi { .. })).map(|(v, _)| v).collect();
        let lasts = |s: f32| {
            let child = level::refined_sharpness(s);
            child > 0.0 && child < INFINITE_SHARPNESS
        };
        let mut spokes = Vec::new();
        for &value in &semi_values {
            let vertex = t.faces.vertex(self.value_corner[value]);
            if level::refined_sharpness(parent.vertex_sharpness[vertex]) > 0.0 {
                continue;
            }
            parent.spokes(vertex, &mut spokes);
            let sharp_around = spokes.iter().any(|s| lasts(parent.edge_sharpness[s.edge]));
            let is_dependent = self.tags[value] == (Tag::Semi { dependent: true });
            let sharp_within = || self.inner_edges(t, value).any(|e| lasts(parent.edge_sharpness[e]));
            if !sharp_around || !is_dependent && !sharp_within() {
                tags[value] = Tag::Crease;
            }
        }
        for value in semi_values {
            if tags[value] != (Tag::Semi { dependent: true }) {
                continue;
            }
            let other = self.siblings(t, value).find(|&v| v != value);
            if other.is_none_or(|v| !matches!(tags[v], Tag::Semi { .. })) {
                tags[value] = Tag::Semi { dependent: false };
            }
        }
    }

    /// The values of all corners at the vertex of `value`.
    fn siblings<'a>(&'a self, t: &'a Topology, value: ValueId) -> impl Iterator<Item = ValueId> + 'a {
        let vertex = t.faces.vertex(self.value_corner[value]);
        t.vertex_corners.row(vertex).iter().map(|&c| self.corner_value[c])
    }

    /// The corners that share `value`.
    fn corners_of<'a>(&'a self, t: &'a Topology, value: ValueId) -> impl Iterator<Item = CornerId> + 'a {
        let vertex = t.faces.vertex(self.value_corner[value]);
        t.vertex_corners.row(vertex).iter().copied().filter(move |&c| self.corner_value[c] == value)
    }

    /// The edges at the vertex of `value` inside its region.
    fn inner_edges<'a>(&'a self, t: &'a Topology, value: ValueId) -> impl Iterator<Item = EdgeId> + 'a {
        self.corners_of(t, value).map(|c| t.corner_edge[c]).filter(|&e| !self.edges[e].cut && !t.is_border(e))
    }

    fn is_region_border(&self, t: &Topology, edge: EdgeId) -> bool {
        self.edges[edge].cut || t.is_border(edge)
    }

    /// Emits the mask of the child of `value`; `child` is the tag of that child.
    #[inline(always)]
    fn value_mask(&self, level: &Level, value: ValueId, child: Tag, sink: &mut impl FnMut(CornerId, f32)) {
        let own = self.value_corner[value];
        if self.is_linear(level) {
            return sink(own, 1.0);
        }
        match child {
            Tag::Match => masks::vertex(level, level.topology.faces.vertex(own), sink),
            Tag::Corner | Tag::Semi { .. } => sink(own, 1.0),
            Tag::Crease => self.crease_mask(level, value, own, sink),
        }
    }

    #[inline(always)]
    fn crease_mask(&self, level: &Level, value: ValueId, own: CornerId, sink: &mut impl FnMut(CornerId, f32)) {
        let keep = self.fading_weight(level, value);
        sink(own, keep + 0.75 * (1.0 - keep));
        for end in self.crease_ends(&level.topology, value) {
            sink(end, 0.125 * (1.0 - keep));
        }
    }

    /// Weight of the corner mask while a semi-sharp value becomes a crease. \[0 to 1\]
    fn fading_weight(&self, level: &Level, value: ValueId) -> f32 {
        let t = &level.topology;
        let of = match self.tags[value] {
            Tag::Semi { dependent: false } => value,
            Tag::Semi { dependent: true } => self.siblings(t, value).find(|&v| v != value).unwrap_or(value),
            _ => return 0.0,
        };
        let vertex = t.faces.vertex(self.value_corner[value]);
        masks::fractional_weight(
            level.vertex_sharpness[vertex],
            self.inner_edges(t, of).map(|e| level.edge_sharpness[e]),
        )
    }

    /// The neighbouring corners along the border of the value's region, in both directions.
    fn crease_ends(&self, t: &Topology, value: ValueId) -> impl Iterator<Item = CornerId> {
        let mut leaving = None;
        let mut arriving = None;
        for corner in self.corners_of(t, value) {
            let prev = t.faces.prev(corner);
            if self.is_region_border(t, t.corner_edge[corner]) {
                leaving = leaving.or(Some(t.faces.next(corner)));
            }
            if self.is_region_border(t, t.corner_edge[prev]) {
                arriving = arriving.or(Some(prev));
            }
        }
        leaving.into_iter().chain(arriving)
    }
}

/// The numbering of a channel's child values.
///
/// Children of values come first, then those of faces, then those of edges. A cut edge has one child value per
/// half-edge.
pub struct ChildValues {
    own: usize,
    faces: usize,
    /// The half-edge behind each value of an edge.
    halves: Vec<CornerId>,
    /// The first value of each edge among `halves`.
    first: IdVec<EdgeId, u32>,
    tags: IdVec<ValueId, Tag>,
}

impl ChildValues {
    /// The child values of a channel of `level`.
    pub fn new(channel: &Channel, level: &Level) -> Self {
        let t = &level.topology;
        let mut halves = Vec::with_capacity(t.edges.len() + t.edges.len() / 8);
        let mut first = IdVec::with_capacity(t.edges.len());
        for (edge, tag) in channel.edges.enumerated() {
            first.push(halves.len() as u32);
            let row = t.edge_corners.row(edge);
            if tag.cut {
                halves.extend_from_slice(row);
            } else {
                halves.push(row[0]);
            }
        }
        let faces = if level.scheme == Scheme::Loop { 0 } else { t.faces.len() };
        let tags = channel.child_tags(level, faces, &halves);
        Self { own: channel.len(), faces, halves, first, tags }
    }

    /// Estimated memory. \[bytes\]
    pub fn bytes(&self) -> usize {
        size_of_val(self.halves.as_slice()) + size_of_val(self.first.as_slice()) + size_of_val(self.tags.as_slice())
    }

    /// The child value in the middle of half-edge `half`, on its own side of a cut.
    #[inline(always)]
    fn middle(&self, channel: &Channel, t: &Topology, half: CornerId) -> usize {
        let edge = t.corner_edge[half];
        let side = match channel.edges[edge].cut {
            true => t.edge_corners.row(edge).iter().position(|&h| h == half).unwrap_or(0),
            false => 0,
        };
        self.own + self.faces + self.first[edge] as usize + side
    }

    /// The value of each child corner, converted from its index by `value`.
    fn corner_values<T: Copy + Send>(
        &self,
        channel: &Channel,
        level: &Level,
        value: impl Fn(usize) -> T + Sync,
    ) -> Vec<T> {
        let t = &level.topology;
        let own = |corner: CornerId| value(channel.corner_value[corner].index());
        let middle = |corner: CornerId| value(self.middle(channel, t, corner));
        if level.scheme != Scheme::Loop {
            return child_quads_of(&t.faces, own, middle, |face| value(self.own + face.index()));
        }
        let mut values = Vec::with_capacity(12 * t.faces.len());
        for face in t.faces.ids() {
            let at = |k: usize| CornerId::new(t.faces.range(face).start + k);
            let ([v0, v1, v2], [e0, e1, e2]) = ([0, 1, 2].map(|k| own(at(k))), [0, 1, 2].map(|k| middle(at(k))));
            values.extend([v0, e0, e2, e0, v1, e1, e2, e1, v2, e1, e2, e0]);
        }
        values
    }

    /// A child corner of each child value.
    fn value_corners(&self, channel: &Channel, level: &Level) -> IdVec<ValueId, CornerId> {
        let faces = &level.topology.faces;
        // Child j of a triangle has corner j at position j and the middle of its edge at the next position.
        let in_triangle = |c: CornerId, step: usize| {
            let (face, j) = (c.index() / 3, c.index() % 3);
            CornerId::new(12 * face + 3 * j + (j + step) % 3)
        };
        let child = |c: CornerId, step: usize| match level.scheme {
            Scheme::Loop => in_triangle(c, step),
            _ => child_corner(faces, c, step),
        };
        let mut corners = Vec::with_capacity(self.own + self.faces + self.halves.len());
        corners.extend(channel.value_corner.iter().map(|&c| child(c, 0)));
        corners.extend((0..self.faces).map(|f| child(CornerId::new(faces.range(FaceId::new(f)).start), 2)));
        corners.extend(self.halves.iter().map(|&c| child(c, 1)));
        corners.into()
    }
}
