//! The faces between ribs: strips beside marked edges, blocks at corners, and the core of each face.

use super::cuts::{Cut, Cuts};
use super::paths::Widths;
use super::points::{Sources, between, weights};
use super::ribs::{Path, Rib, Ribs};
use super::{Crossing, LineRequest, LineVertex, Lines, StripFace};
use crate::render::child::ChildBuilder;
use std::collections::BTreeMap;
use tailor_mesh::connectivity::{CornerId, EdgeId, FaceId, IdVec, Topology, VertexId};

/// A corner of the core of a face.
#[derive(Clone, Copy)]
struct CorePoint {
    vertex: VertexId,
    /// True if the core is concave at the vertex: it is split from there.
    is_reflex: bool,
}

impl CorePoint {
    fn new(vertex: VertexId) -> Self {
        Self { vertex, is_reflex: false }
    }
}

/// Builds the child face by face.
pub(super) struct LineBuilder<'a, 'r> {
    pub(super) request: &'r LineRequest<'a>,
    pub(super) ribs: &'r Ribs,
    pub(super) cuts: &'r Cuts,
    /// Share of the requested distance at each vertex.
    pub(super) widths: &'r Widths,
    pub(super) builder: ChildBuilder<'a>,
    /// Vertices of each rib, from the first line outwards.
    pub(super) columns: Vec<Vec<VertexId>>,
    /// The vertices of each block, line by line along the edge after its corner.
    pub(super) grids: BTreeMap<CornerId, Vec<VertexId>>,
    /// The vertex of each cut of an edge.
    pub(super) cut_vertices: BTreeMap<EdgeId, Vec<VertexId>>,
    /// For each half-edge of a cut edge and each of its cuts, the vertices of the lines beside the cut.
    beside_cuts: BTreeMap<(CornerId, usize), Vec<VertexId>>,
    pub(super) vertices: Vec<LineVertex>,
    strips: Vec<StripFace>,
}

/// Builds the child of a request.
pub fn build<'a>(request: &LineRequest<'a>, ribs: &Ribs, cuts: &Cuts, widths: &Widths) -> Lines<'a> {
    let mut lines = LineBuilder {
        request,
        ribs,
        cuts,
        widths,
        builder: ChildBuilder::new(request.topology),
        columns: Vec::with_capacity(ribs.all.len()),
        grids: BTreeMap::new(),
        cut_vertices: BTreeMap::new(),
        beside_cuts: BTreeMap::new(),
        vertices: Vec::new(),
        strips: Vec::new(),
    };
    let t = request.topology;
    ribs.all.iter().enumerate().for_each(|(number, rib)| lines.add_column(number, rib));
    cuts.edges().for_each(|edge| lines.cut(edge));
    let mut near = IdVec::filled(false, t.vertex_count());
    let mut first_child = Vec::with_capacity(t.faces.len() + 1);
    for face in t.faces.ids() {
        first_child.push(lines.builder.face_count());
        if lines.add_face(face) {
            t.faces.vertices_of(face).iter().for_each(|&v| near[v] = true);
        }
    }
    first_child.push(lines.builder.face_count());
    t.edges.ids().for_each(|edge| lines.add_edge(edge));
    let LineBuilder { builder, vertices, strips, .. } = lines;
    Lines { builder, vertices, strips, first_child, near, narrowed: Vec::new(), heights: widths.heights.clone() }
}

impl LineBuilder<'_, '_> {
    pub(super) fn topology(&self) -> &Topology {
        self.request.topology
    }

    pub(super) fn line_count(&self) -> usize {
        self.request.shares.len()
    }

    /// Adds the vertices of the lines on a rib, or of the block that replaces it.
    fn add_column(&mut self, number: usize, rib: &Rib) {
        if let Some(corner) = rib.corner().filter(|&c| self.cuts.block(c).is_some()) {
            return self.add_grid(corner, number);
        }
        let mut column = Vec::with_capacity(rib.steps.len());
        let height = if self.has_ended(rib) { 0.0 } else { self.widths.heights[rib.vertex] };
        for (line, &step) in rib.steps.iter().enumerate() {
            let vertex = self.builder.vertex(&weights(self.request.topology, rib, step));
            self.vertices.push(LineVertex { vertex, line: Some(line), mark: rib.mark, height, crossing: None });
            column.push(vertex);
        }
        self.columns.push(column);
    }

    /// True for a rib ahead of an end that is not round: no face beside it has the marked edge.
    fn has_ended(&self, rib: &Rib) -> bool {
        let (t, vertex) = (self.request.topology, rib.vertex);
        if !self.request.tapers[vertex] || self.request.round[vertex] {
            return false;
        }
        let Path::Edge { to, .. } = rib.path else { return true };
        let is_beside = |&c: &CornerId| {
            let prev = t.faces.prev(c);
            [t.corner_edge[c], t.corner_edge[prev]].contains(&rib.mark)
                && [t.faces.next(c), prev].iter().any(|&c| t.faces.vertex(c) == to)
        };
        !t.vertex_corners.row(vertex).iter().any(is_beside)
    }

    /// Cuts a marked edge and the strips beside it.
    fn cut(&mut self, edge: EdgeId) {
        let t = self.request.topology;
        let [a, b] = t.edges[edge];
        for (number, cut) in self.cuts.of(edge).iter().enumerate() {
            let vertex = self.builder.vertex(&[(a, 1.0 - cut.at), (b, cut.at)]);
            let crossing = cut.block.map(|block| Crossing { line: block.line, mark: block.mark });
            self.vertices.push(LineVertex { vertex, line: None, mark: edge, height: cut.height, crossing });
            self.cut_vertices.entry(edge).or_default().push(vertex);
            for &half in t.edge_corners.row(edge) {
                let beside = self.beside_cut(half, cut);
                self.beside_cuts.insert((half, number), beside);
            }
        }
    }

    /// The vertices of the lines beside a cut, in the face of a half-edge.
    fn beside_cut(&mut self, half: CornerId, cut: &Cut) -> Vec<VertexId> {
        let (t, n) = (self.request.topology, self.line_count());
        if let Some((corner, line)) = self.grid_of(half, cut) {
            let is_tail = corner == half;
            return (0..n).map(|i| self.grids[&corner][if is_tail { line * n + i } else { i * n + line }]).collect();
        }
        let edge = t.corner_edge[half];
        let is_forward = t.faces.vertex(half) == t.edges[edge][0];
        let at = if is_forward { cut.at } else { 1.0 - cut.at };
        let Some([tail, head]) = self.ends(half) else { return Vec::new() };
        let kept = if self.ends_within(half, cut) { n - 1 } else { n };
        // Where the other lines end, those of the seam that goes through are its own alone.
        let mut beside = Vec::with_capacity(kept);
        for line in 0..kept {
            let vertex = self.builder.vertex(&between(&tail[line], &head[line], at));
            self.vertices.push(LineVertex { vertex, line: Some(line), mark: edge, height: cut.height, crossing: None });
            beside.push(vertex);
        }
        beside
    }

    /// Whether a line of a seam that ends at a junction stops before the outermost line on the other side of the seam that
    /// goes through: an inner line would lead on into the face there and crease it.
    fn ends_within(&self, half: CornerId, cut: &Cut) -> bool {
        let is_inner = cut.block.is_some_and(|block| block.line + 1 < self.line_count());
        is_inner && self.grid_of(half, cut).is_none()
    }

    /// The sources of the lines at both ends of the strip beside a half-edge, if its face may be cut.
    fn ends(&self, half: CornerId) -> Option<[Vec<Sources>; 2]> {
        let t = self.request.topology;
        let end = |corner: CornerId, is_tail: bool| {
            let rib = &self.ribs.all[self.strip_rib(corner, is_tail)?];
            Some(rib.steps.iter().map(|&step| weights(t, rib, step)).collect())
        };
        Some([end(half, true)?, end(t.faces.next(half), false)?])
    }

    /// The vertices across the strip beside a half-edge at each of its cuts, in its direction. Inside a block there are
    /// none but at its last line.
    fn across_cuts(&self, half: CornerId) -> Vec<Vec<VertexId>> {
        let t = self.request.topology;
        let edge = t.corner_edge[half];
        let mut all: Vec<Vec<VertexId>> = Vec::new();
        for (number, cut) in self.cuts.of(edge).iter().enumerate() {
            if self.grid_of(half, cut).is_some_and(|(_, line)| line + 1 < self.line_count()) {
                continue;
            }
            let on_edge = self.cut_vertices[&edge][number];
            let beside = &self.beside_cuts[&(half, number)];
            all.push(std::iter::once(on_edge).chain(beside.iter().copied()).collect());
        }
        if t.faces.vertex(half) != t.edges[edge][0] {
            all.reverse();
        }
        all
    }

    /// Adds the children of a face. True if the face was cut.
    fn add_face(&mut self, face: FaceId) -> bool {
        let t = self.request.topology;
        let mut core: Vec<CorePoint> = Vec::with_capacity(2 * t.faces.valence(face));
        let before = self.builder.face_count();
        for corner in t.faces.corners_of(face) {
            self.add_core_corner(corner, &mut core);
            self.add_core_edge(corner, &mut core);
        }
        let is_cut = core.len() != t.faces.valence(face)
            || core.iter().zip(t.faces.vertices_of(face)).any(|(p, &v)| p.vertex != v);
        if is_cut {
            for corner in t.faces.corners_of(face) {
                self.add_strip(face, corner);
                self.add_grid_faces(face, corner);
                self.add_block(face, corner);
            }
        }
        self.add_core(face, core);
        is_cut || self.builder.face_count() > before + 1
    }

    fn is_marked(&self, corner: CornerId) -> bool {
        self.request.marked[self.topology().corner_edge[corner]]
    }

    /// The rib from a vertex along the edge of a half-edge.
    fn along(&self, half_edge: CornerId, vertex: VertexId) -> Option<usize> {
        let t = self.topology();
        self.ribs.along(t, t.corner_edge[half_edge], vertex)
    }

    /// The rib at a corner that bounds the strip beside a marked edge: the edge `after` the corner, or else the one
    /// before.
    fn strip_rib(&self, corner: CornerId, after: bool) -> Option<usize> {
        if !self.ribs.active[corner] {
            return None;
        }
        let prev = self.topology().faces.prev(corner);
        let other = if after { prev } else { corner };
        match self.is_marked(other) {
            true => self.ribs.within(corner),
            false => self.along(other, self.topology().faces.vertex(corner)),
        }
    }

    /// The vertices of a rib from the marked edge outwards. Without a rib, the vertex of the corner is repeated.
    fn column(&self, corner: CornerId, rib: Option<usize>) -> Vec<VertexId> {
        let vertex = self.topology().faces.vertex(corner);
        match rib {
            Some(rib) => std::iter::once(vertex).chain(self.columns[rib].iter().copied()).collect(),
            None => vec![vertex; self.request.shares.len() + 1],
        }
    }

    fn last(&self, rib: usize) -> Option<VertexId> {
        self.columns[rib].last().copied()
    }

    /// Adds the points of the core at a corner.
    fn add_core_corner(&self, corner: CornerId, core: &mut Vec<CorePoint>) {
        let t = self.topology();
        let (vertex, prev) = (t.faces.vertex(corner), t.faces.prev(corner));
        let point = CorePoint::new;
        let active = self.ribs.active[corner];
        match (self.is_marked(prev), self.is_marked(corner)) {
            (false, false) if active => {
                let end = |half_edge| self.along(half_edge, vertex).and_then(|r| self.last(r));
                let within = self.ribs.within(corner).and_then(|r| self.last(r));
                core.extend(end(prev).map(point));
                core.extend(within.map(|vertex| CorePoint { is_reflex: true, ..point(vertex) }));
                core.extend(end(corner).map(point));
            }
            (_, after) if active => {
                let rib = self.strip_rib(corner, after);
                core.push(point(rib.and_then(|r| self.last(r)).unwrap_or(vertex)));
            }
            _ => core.push(point(vertex)),
        }
    }

    /// Adds the points of the core along the edge after a corner: vertices of ribs of neighbouring faces, and the
    /// outermost vertex across the cut of a tapering edge.
    fn add_core_edge(&self, corner: CornerId, core: &mut Vec<CorePoint>) {
        let t = self.topology();
        let next = t.faces.next(corner);
        let cuts = |at: CornerId| {
            let rib = self.along(corner, t.faces.vertex(at)).filter(|_| !self.ribs.active[at]);
            rib.map_or(&[][..], |r| &self.columns[r])
        };
        let point = |&vertex: &VertexId| CorePoint::new(vertex);
        core.extend(cuts(corner).iter().map(point));
        // The outermost vertex of a block is a corner of the core already.
        let ends = [corner, next].map(|c| self.grids.get(&c).and_then(|grid| grid.last().copied()));
        for across in self.across_cuts(corner) {
            let outermost = across.get(self.line_count()).copied().filter(|v| !ends.contains(&Some(*v)));
            core.extend(outermost.map(CorePoint::new));
        }
        core.extend(cuts(next).iter().rev().map(point));
    }

    pub(super) fn strip_face(&mut self, face: FaceId, corners: &[VertexId], line: usize, mark: EdgeId) {
        // Quads become triangles where lines meet at a taper.
        let mut distinct: Vec<VertexId> = Vec::with_capacity(4);
        for &v in corners {
            if !distinct.contains(&v) {
                distinct.push(v);
            }
        }
        if distinct.len() >= 3 {
            let face = self.builder.face(face, &distinct);
            self.strips.push(StripFace { face, line, mark });
        }
    }

    /// Adds the strip beside the edge after a corner if it is marked.
    fn add_strip(&mut self, face: FaceId, corner: CornerId) {
        if !self.is_marked(corner) {
            return;
        }
        let next = self.topology().faces.next(corner);
        let tail = self.column(corner, self.strip_rib(corner, true));
        let head = self.column(next, self.strip_rib(next, false));
        let mark = self.topology().corner_edge[corner];
        // A strip begins and ends at blocks, where they are.
        let mut columns = self.across_cuts(corner);
        if !self.grids.contains_key(&corner) {
            columns.insert(0, tail);
        }
        if !self.grids.contains_key(&next) {
            columns.push(head);
        }
        for line in 0..self.line_count() {
            let mut rest = columns.as_slice();
            while let [tail, others @ ..] = rest
                && let Some(next) = others.iter().position(|column| column.len() > line + 1)
            {
                // Lines that end before this one lead to its face.
                let (ending, head) = (others[..next].iter().filter_map(|column| column.get(line)), &others[next]);
                let inner = std::iter::once(&tail[line]).chain(ending).copied();
                let corners: Vec<VertexId> = inner.chain([head[line], head[line + 1], tail[line + 1]]).collect();
                self.strip_face(face, &corners, line, mark);
                rest = &others[next..];
            }
        }
    }

    /// Adds the block between the two ribs of a corner without marked edges.
    fn add_block(&mut self, face: FaceId, corner: CornerId) {
        let t = self.topology();
        let (vertex, prev) = (t.faces.vertex(corner), t.faces.prev(corner));
        if !self.ribs.active[corner] || self.is_marked(corner) || self.is_marked(prev) {
            return;
        }
        let (Some(after), Some(before)) = (self.along(corner, vertex), self.along(prev, vertex)) else { return };
        let mark = self.ribs.all[after].mark;
        let (after, before) = (self.column(corner, Some(after)), self.column(corner, Some(before)));
        let within = self.ribs.within(corner).map(|rib| self.column(corner, Some(rib)));
        for line in 0..self.request.shares.len() {
            let (low, high) = (line, line + 1);
            match &within {
                None => self.strip_face(face, &[after[low], after[high], before[high], before[low]], line, mark),
                Some(within) if line == 0 => {
                    self.strip_face(face, &[vertex, after[high], within[high], before[high]], line, mark);
                }
                Some(within) => {
                    self.strip_face(face, &[after[low], after[high], within[high], within[low]], line, mark);
                    self.strip_face(face, &[within[low], within[high], before[high], before[low]], line, mark);
                }
            }
        }
    }

    /// Adds the core of a face. A core with an even number of corners is split into quads at its concave corners.
    fn add_core(&mut self, face: FaceId, mut core: Vec<CorePoint>) {
        while core.len() > 4
            && core.len().is_multiple_of(2)
            && let Some(at) = core.iter().position(|p| p.is_reflex)
        {
            core.rotate_left(at);
            let quad: Vec<VertexId> = core[..4].iter().map(|p| p.vertex).collect();
            self.builder.face(face, &quad);
            core.drain(1..3);
            core.iter_mut().take(2).for_each(|p| p.is_reflex = false);
        }
        let corners: Vec<VertexId> = core.iter().map(|p| p.vertex).collect();
        self.builder.face(face, &corners);
    }

    /// Adds the children of an edge.
    fn add_edge(&mut self, edge: EdgeId) {
        let t = self.topology();
        let [a, b] = t.edges[edge];
        let column = |v| self.ribs.along(t, edge, v).map_or(&[][..], |r| &self.columns[r]);
        let mut path = vec![a];
        path.extend(column(a));
        path.extend(self.cut_vertices.get(&edge).into_iter().flatten());
        path.extend(column(b).iter().rev());
        path.push(b);
        path.windows(2).for_each(|step| self.builder.edge(edge, [step[0], step[1]]));
    }
}
