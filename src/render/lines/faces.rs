//! The faces between ribs: strips beside marked edges, blocks at corners, and the core of each face.

use super::ribs::{Path, Rib, Ribs};
use super::{LineVertex, Lines, Request, StripFace};
use crate::mesh::{CornerId, EdgeId, FaceId, IdVec, Topology, VertexId};
use crate::render::child::ChildBuilder;

/// Position of the cut on the last edge of a tapering path, as a share of its length.
const TAPER_CUT: f32 = 0.5;

/// A corner of the core of a face.
#[derive(Clone, Copy)]
struct CorePoint {
    vertex: VertexId,
    /// True if the core is concave at the vertex: it is split from there.
    is_reflex: bool,
}

/// Builds the child face by face.
struct LineBuilder<'a, 'r> {
    request: &'r Request<'a>,
    ribs: &'r Ribs,
    /// Share of the requested distance at each vertex.
    widths: IdVec<VertexId, f32>,
    builder: ChildBuilder<'a>,
    /// Vertices of each rib, from the first line outwards.
    columns: Vec<Vec<VertexId>>,
    /// The vertex that cuts the last edge of a tapering path.
    halfway: IdVec<EdgeId, Option<VertexId>>,
    /// For each half-edge of a cut edge, the line vertices beside the cut in its face.
    beside_cut: IdVec<CornerId, Vec<VertexId>>,
    vertices: Vec<LineVertex>,
    strips: Vec<StripFace>,
}

/// Builds the child of a request.
pub fn build<'a>(request: &Request<'a>, ribs: &Ribs) -> Lines<'a> {
    let mut widths = IdVec::filled(1.0f32, request.topology.vertex_count());
    ribs.narrowed.iter().for_each(|n| widths[n.vertex] = widths[n.vertex].min(n.share));
    let mut lines = LineBuilder {
        request,
        ribs,
        widths,
        builder: ChildBuilder::new(request.topology),
        columns: Vec::with_capacity(ribs.all.len()),
        halfway: IdVec::filled(None, request.topology.edges.len()),
        beside_cut: IdVec::filled(Vec::new(), request.topology.faces.corners().len()),
        vertices: Vec::new(),
        strips: Vec::new(),
    };
    ribs.all.iter().for_each(|rib| lines.add_column(rib));
    let t = request.topology;
    t.edges.ids().for_each(|edge| lines.cut_halfway(edge));
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
    let LineBuilder { builder, vertices, strips, widths, .. } = lines;
    Lines { builder, vertices, strips, first_child, narrowed: ribs.narrowed.clone(), widths, near }
}

impl LineBuilder<'_, '_> {
    fn topology(&self) -> &Topology {
        self.request.topology
    }

    /// Adds the vertices of the lines on a rib.
    fn add_column(&mut self, rib: &Rib) {
        let mut column = Vec::with_capacity(rib.steps.len());
        for (line, &step) in rib.steps.iter().enumerate() {
            let sources = weights(self.request.topology, rib, step);
            let vertex = self.builder.vertex(&sources);
            self.vertices.push(LineVertex { vertex, line: Some(line), mark: rib.mark, part: self.widths[rib.vertex] });
            column.push(vertex);
        }
        self.columns.push(column);
    }

    /// Cuts the last edge of a tapering path if lines turn a corner at its other end.
    fn cut_halfway(&mut self, edge: EdgeId) {
        let t = self.request.topology;
        let [a, b] = t.edges[edge];
        let (end, other) = if self.request.tapers[a] { (a, b) } else { (b, a) };
        let is_last = self.request.marked[edge] && self.request.tapers[end] && !self.request.tapers[other];
        if !is_last || t.vertex_corners.row(other).iter().all(|&c| self.ribs.within(c).is_none()) {
            return;
        }
        let vertex = self.builder.vertex(&[(other, 1.0 - TAPER_CUT), (end, TAPER_CUT)]);
        let part = (1.0 - TAPER_CUT) * self.widths[other];
        self.vertices.push(LineVertex { vertex, line: None, mark: edge, part });
        self.halfway[edge] = Some(vertex);
        for &corner in t.edge_corners.row(edge) {
            let is_tail = t.faces.vertex(corner) == other;
            let at = if is_tail { corner } else { t.faces.next(corner) };
            let Some(rib) = self.strip_rib(at, is_tail).map(|rib| &self.ribs.all[rib]) else { continue };
            for (line, &step) in rib.steps.iter().enumerate() {
                let vertex = self.builder.vertex(&towards(weights(t, rib, step), end));
                self.vertices.push(LineVertex { vertex, line: Some(line), mark: edge, part });
                self.beside_cut[corner].push(vertex);
            }
        }
    }

    /// The vertices across the strip at the cut of the edge after a corner, if it is cut.
    fn cut(&self, corner: CornerId) -> Option<Vec<VertexId>> {
        let vertex = self.halfway[self.topology().corner_edge[corner]]?;
        Some(std::iter::once(vertex).chain(self.beside_cut[corner].iter().copied()).collect())
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
        let point = |vertex| CorePoint { vertex, is_reflex: false };
        let active = self.ribs.active[corner];
        match (self.is_marked(prev), self.is_marked(corner)) {
            (false, false) if active => {
                let end = |half_edge| self.along(half_edge, vertex).and_then(|r| self.last(r));
                let within = self.ribs.within(corner).and_then(|r| self.last(r));
                core.extend(end(prev).map(point));
                core.extend(within.map(|vertex| CorePoint { vertex, is_reflex: true }));
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
        let point = |&vertex: &VertexId| CorePoint { vertex, is_reflex: false };
        core.extend(cuts(corner).iter().map(point));
        core.extend(self.cut(corner).iter().filter_map(|across| across.last()).map(point));
        core.extend(cuts(next).iter().rev().map(point));
    }

    fn strip_face(&mut self, face: FaceId, corners: &[VertexId], line: usize, mark: EdgeId) {
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
        let columns: Vec<Vec<VertexId>> = [Some(tail), self.cut(corner), Some(head)].into_iter().flatten().collect();
        for line in 0..self.request.shares.len() {
            for pair in columns.windows(2) {
                let [tail, head] = [&pair[0], &pair[1]];
                self.strip_face(face, &[tail[line], head[line], head[line + 1], tail[line + 1]], line, mark);
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
        path.extend(self.halfway[edge]);
        path.extend(column(b).iter().rev());
        path.push(b);
        path.windows(2).for_each(|step| self.builder.edge(edge, [step[0], step[1]]));
    }
}

/// The sources of the midpoint between a point and a vertex.
fn towards(mut sources: Vec<(VertexId, f32)>, end: VertexId) -> Vec<(VertexId, f32)> {
    sources.iter_mut().for_each(|(_, weight)| *weight *= 1.0 - TAPER_CUT);
    match sources.iter_mut().find(|(vertex, _)| *vertex == end) {
        Some((_, weight)) => *weight += TAPER_CUT,
        None => sources.push((end, TAPER_CUT)),
    }
    sources
}

/// The sources of the point at a step of a rib.
fn weights(t: &Topology, rib: &Rib, step: f32) -> Vec<(VertexId, f32)> {
    match rib.path {
        Path::Edge { to, part } => vec![(rib.vertex, 1.0 - part * step), (to, part * step)],
        Path::Across { corner, part } => {
            let part = part * step;
            let face = t.faces.face_of(corner);
            let others = 1.0 / (t.faces.valence(face) - 1) as f32;
            let weight = |c| if c == corner { 1.0 - part } else { part * others };
            t.faces.corners_of(face).map(|c| (t.faces.vertex(c), weight(c))).collect()
        }
        Path::Face { corner, after, before } => {
            let (x, y) = (after * step, before * step);
            let (next, prev) = (t.faces.next(corner), t.faces.prev(corner));
            let at = |c| t.faces.vertex(c);
            if t.faces.valence(t.faces.face_of(corner)) == 4 {
                let opposite = t.faces.next(next);
                let own = (1.0 - x) * (1.0 - y);
                return vec![
                    (at(corner), own),
                    (at(next), x * (1.0 - y)),
                    (at(opposite), x * y),
                    (at(prev), (1.0 - x) * y),
                ];
            }
            vec![(at(corner), 1.0 - x - y), (at(next), x), (at(prev), y)]
        }
    }
}
