//! The faces between ribs: strips beside marked edges, blocks at corners, and the core that is left of each face.

use super::ribs::{Path, Rib, Ribs};
use super::{LineVertex, Lines, Request, StripFace};
use crate::mesh::{CornerId, EdgeId, FaceId, IdVec, Topology, VertexId};
use crate::render::derivation::Builder;

/// Where the last edge of a path that tapers is cut, as a part of its length.
const HALFWAY: f32 = 0.5;

/// A corner of the core of a face.
#[derive(Clone, Copy)]
struct CorePoint {
    vertex: VertexId,
    /// The core is concave there: it is split from here.
    is_reflex: bool,
}

struct Weaver<'a, 'r> {
    request: &'r Request<'a>,
    ribs: &'r Ribs,
    /// How wide the lines are at each vertex, as a share of what was asked.
    widths: IdVec<VertexId, f32>,
    builder: Builder<'a>,
    /// The vertices of each rib, from the first line on.
    columns: Vec<Vec<VertexId>>,
    /// The vertex that cuts a marked edge, where its path tapers.
    halfway: IdVec<EdgeId, Option<VertexId>>,
    /// The vertices of the lines beside it in the face of each half-edge.
    beside: IdVec<CornerId, Vec<VertexId>>,
    vertices: Vec<LineVertex>,
    strips: Vec<StripFace>,
}

/// The child of a request.
pub fn build<'a>(request: &Request<'a>, ribs: &Ribs) -> Lines<'a> {
    let mut widths = IdVec::filled(1.0f32, request.topology.vertex_count());
    ribs.narrowed.iter().for_each(|n| widths[n.vertex] = widths[n.vertex].min(n.share));
    let mut weaver = Weaver {
        request,
        ribs,
        widths,
        builder: Builder::new(request.topology),
        columns: Vec::with_capacity(ribs.all.len()),
        halfway: IdVec::filled(None, request.topology.edges.len()),
        beside: IdVec::filled(Vec::new(), request.topology.faces.corners().len()),
        vertices: Vec::new(),
        strips: Vec::new(),
    };
    ribs.all.iter().for_each(|rib| weaver.add_column(rib));
    let t = request.topology;
    t.edges.ids().for_each(|edge| weaver.cut_halfway(edge));
    let mut near = IdVec::filled(false, t.vertex_count());
    let mut first_child = Vec::with_capacity(t.faces.len() + 1);
    for face in t.faces.ids() {
        first_child.push(weaver.builder.face_count());
        if weaver.add_face(face) {
            t.faces.vertices_of(face).iter().for_each(|&v| near[v] = true);
        }
    }
    first_child.push(weaver.builder.face_count());
    t.edges.ids().for_each(|edge| weaver.add_edge(edge));
    let Weaver { builder, vertices, strips, widths, .. } = weaver;
    Lines { builder, vertices, strips, first_child, narrowed: ribs.narrowed.clone(), widths, near }
}

impl Weaver<'_, '_> {
    fn topology(&self) -> &Topology {
        self.request.topology
    }

    /// The vertices of the lines on a rib.
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

    /// Cuts a marked edge at one of whose ends lines taper, where they turn a corner at the other.
    fn cut_halfway(&mut self, edge: EdgeId) {
        let t = self.request.topology;
        let [a, b] = t.edges[edge];
        let (end, other) = if self.request.tapers[a] { (a, b) } else { (b, a) };
        let is_last = self.request.marked[edge] && self.request.tapers[end] && !self.request.tapers[other];
        if !is_last || t.vertex_corners.row(other).iter().all(|&c| self.ribs.within(c).is_none()) {
            return;
        }
        let vertex = self.builder.vertex(&[(other, 1.0 - HALFWAY), (end, HALFWAY)]);
        let part = (1.0 - HALFWAY) * self.widths[other];
        self.vertices.push(LineVertex { vertex, line: None, mark: edge, part });
        self.halfway[edge] = Some(vertex);
        for &corner in t.edge_corners.row(edge) {
            let is_tail = t.faces.vertex(corner) == other;
            let at = if is_tail { corner } else { t.faces.next(corner) };
            let Some(rib) = self.strip_rib(at, is_tail).map(|rib| &self.ribs.all[rib]) else { continue };
            for (line, &step) in rib.steps.iter().enumerate() {
                let vertex = self.builder.vertex(&towards(weights(t, rib, step), end));
                self.vertices.push(LineVertex { vertex, line: Some(line), mark: edge, part });
                self.beside[corner].push(vertex);
            }
        }
    }

    /// The vertices across the strip where the edge after a corner is cut.
    fn cut(&self, corner: CornerId) -> Option<Vec<VertexId>> {
        let vertex = self.halfway[self.topology().corner_edge[corner]]?;
        Some(std::iter::once(vertex).chain(self.beside[corner].iter().copied()).collect())
    }

    /// The children of a face; whether there are new ones.
    fn add_face(&mut self, face: FaceId) -> bool {
        let t = self.request.topology;
        let mut core: Vec<CorePoint> = Vec::with_capacity(2 * t.faces.valence(face));
        let before = self.builder.face_count();
        for corner in t.faces.corners_of(face) {
            self.core_at(corner, &mut core);
            self.cuts_after(corner, &mut core);
        }
        let cut = core.len() != t.faces.valence(face)
            || core.iter().zip(t.faces.vertices_of(face)).any(|(p, &v)| p.vertex != v);
        if cut {
            for corner in t.faces.corners_of(face) {
                self.add_strip(face, corner);
                self.add_block(face, corner);
            }
        }
        self.add_core(face, core);
        cut || self.builder.face_count() > before + 1
    }

    fn is_marked(&self, corner: CornerId) -> bool {
        self.request.marked[self.topology().corner_edge[corner]]
    }

    fn along(&self, edge_of: CornerId, vertex: VertexId) -> Option<usize> {
        let t = self.topology();
        self.ribs.along(t, t.corner_edge[edge_of], vertex)
    }

    /// The rib that bounds the strip beside a marked edge of a corner: the edge after it, or the one before.
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

    /// The vertices of a rib from the marked edge on; the same vertex everywhere where there is none.
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

    /// What a corner gives to the core of its face.
    fn core_at(&self, corner: CornerId, core: &mut Vec<CorePoint>) {
        let t = self.topology();
        let (vertex, prev) = (t.faces.vertex(corner), t.faces.prev(corner));
        let point = |vertex| CorePoint { vertex, is_reflex: false };
        let active = self.ribs.active[corner];
        match (self.is_marked(prev), self.is_marked(corner)) {
            (false, false) if active => {
                let end = |edge_of| self.along(edge_of, vertex).and_then(|r| self.last(r));
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

    /// Cuts of the edge after a corner by lines that do not enter this face, and of its line that is next to the core.
    fn cuts_after(&self, corner: CornerId, core: &mut Vec<CorePoint>) {
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
        // Where the lines come together, quads become triangles.
        let mut kept: Vec<VertexId> = Vec::with_capacity(4);
        for &v in corners {
            if !kept.contains(&v) {
                kept.push(v);
            }
        }
        if kept.len() >= 3 {
            let face = self.builder.face(face, &kept);
            self.strips.push(StripFace { face, line, mark });
        }
    }

    /// The strip beside the edge after a corner, if it is marked.
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

    /// The block between two ribs of one corner.
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

    /// What is left of a face, in quads where it can be: a quad is cut off at each concave corner.
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

    /// The children of an edge.
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

/// The sources of the place halfway from a place to a vertex.
fn towards(mut place: Vec<(VertexId, f32)>, end: VertexId) -> Vec<(VertexId, f32)> {
    place.iter_mut().for_each(|(_, weight)| *weight *= 1.0 - HALFWAY);
    match place.iter_mut().find(|(vertex, _)| *vertex == end) {
        Some((_, weight)) => *weight += HALFWAY,
        None => place.push((end, HALFWAY)),
    }
    place
}

/// The sources of a place on a rib.
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
