//! The mesh under remeshing: topology, positions, and what each vertex and edge may do.
//!
//! All edits pass through here: they ask for permission and carry the constraint spans, places and UVs along.

use super::baseline::{Baseline, Location};
use super::chains::Chain;
use crate::mesh::edit::{EditMesh, next, prev};
use crate::mesh::{ChainId, CornerId, FaceId, IdVec, VertexId};
use glam::{Vec2, Vec3};
use std::collections::BTreeSet;

/// What a vertex may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grade {
    /// Anything on the surface.
    Free,
    /// Slide, split and merge along one chain.
    OnCurve(ChainId),
    /// Nothing: an anchor.
    Frozen,
}

/// A constrained half-edge: its part of a chain's curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// The chain.
    pub chain: ChainId,
    /// Arc length at the half-edge's start and end. Loops may count beyond their length. \[stage units\]
    pub from: f32,
    /// See `from`.
    pub to: f32,
    /// Whether the half-edge runs along the chain; lengths do not say that of an edge without length.
    pub forward: bool,
}

impl Span {
    /// As the twin has it.
    pub fn reversed(self) -> Self {
        Self { chain: self.chain, from: self.to, to: self.from, forward: !self.forward }
    }
}

/// Where a corner's vertex is, as the corner's triangle sees it.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// The baseline's triangle.
    pub location: Location,
    /// Constraint UVs.
    pub uv: Vec2,
}

/// A triangle with less than this share of the area of the equilateral triangle on its longest edge is degenerate.
const MIN_SHAPE: f32 = 0.02;

/// A collapse may not make a triangle whose normal turns further than this from the surface's at a corner: it would
/// bridge a fold and erase it. Larger values keep more of a fold, but leave short edges along it.
const MIN_COSINE: f32 = 0.2;

/// The simulation mesh while it is made.
pub struct SimMesh<'a> {
    /// The surface that it lies on.
    pub baseline: &'a Baseline,
    /// Connectivity.
    pub topology: EditMesh,
    /// Positions.
    pub points: IdVec<VertexId, Vec3>,
    /// Target edge length at each vertex.
    pub target: IdVec<VertexId, f32>,
    /// What each vertex may do.
    pub grade: IdVec<VertexId, Grade>,
    /// The constrained half-edges.
    pub span: IdVec<CornerId, Option<Span>>,
    /// The place of each corner.
    pub place: IdVec<CornerId, Place>,
}

impl<'a> SimMesh<'a> {
    /// The start mesh of a baseline.
    pub fn new(baseline: &'a Baseline) -> Self {
        let vertex = |c: CornerId| baseline.topology.faces.vertex(c);
        let triangles: Vec<[VertexId; 3]> = baseline.start.iter().map(|t| t.map(vertex)).collect();
        let topology = EditMesh::new(&triangles, baseline.points.len());
        let place = |&c: &CornerId| Place { location: baseline.corner_location(c), uv: baseline.uvs[c] };
        let mut mesh = Self {
            baseline,
            points: baseline.points.clone(),
            target: baseline.target.clone(),
            grade: IdVec::filled(Grade::Free, baseline.points.len()),
            span: IdVec::filled(None, topology.corner_slots()),
            place: baseline.start.iter().flatten().map(place).collect(),
            topology,
        };
        mesh.set_constraints();
        mesh
    }

    fn set_constraints(&mut self) {
        for corner in self.topology.corners() {
            let (a, b) = (self.topology.vertex(corner), self.topology.target(corner));
            let [x, y] = [a, b].map(|v| self.baseline.level_vertex[v]);
            let Some(start) = self.baseline.start_spans.get(&[x.min(y), x.max(y)]) else { continue };
            let span = Span { chain: start.chain, from: start.from, to: start.to, forward: true };
            self.span[corner] = Some(if start.first == x { span } else { span.reversed() });
            self.grade[a] = Grade::OnCurve(start.chain);
            self.grade[b] = Grade::OnCurve(start.chain);
        }
        let paths = self.baseline.chains.iter().filter(|c| !c.is_loop);
        let ends: BTreeSet<VertexId> =
            paths.flat_map(|c| c.vertices.first().into_iter().chain(c.vertices.last())).copied().collect();
        for (vertex, level_vertex) in self.baseline.level_vertex.enumerated() {
            if ends.contains(level_vertex) {
                self.grade[vertex] = Grade::Frozen;
            }
        }
    }

    /// The chain of an id.
    pub fn chain(&self, id: ChainId) -> &Chain {
        &self.baseline.chains[id]
    }

    /// Length of a half-edge.
    pub fn length(&self, half: CornerId) -> f32 {
        self.points[self.topology.vertex(half)].distance(self.points[self.topology.target(half)])
    }

    /// Target length of the edge between two vertices.
    pub fn target_between(&self, a: VertexId, b: VertexId) -> f32 {
        0.5 * (self.target[a] + self.target[b])
    }

    /// Length of a half-edge over its target.
    pub fn relative_length(&self, half: CornerId) -> f32 {
        self.length(half) / self.target_between(self.topology.vertex(half), self.topology.target(half))
    }

    /// Whether an edge is constrained.
    pub fn is_constrained(&self, half: CornerId) -> bool {
        self.span[half].is_some()
    }

    /// The place on a chain's curve at `s`, on the side of a half-edge that runs `forward` along it.
    pub fn on_curve(&self, chain: ChainId, s: f32, forward: bool) -> (Vec3, Option<Place>) {
        let curve = self.chain(chain);
        let at = curve.at(s);
        let (a, b) = (curve.vertices[at.segment], curve.vertices[at.segment + 1]);
        let position = self.baseline.points[a].lerp(self.baseline.points[b], at.t);
        let half = if forward { curve.left[at.segment] } else { curve.right[at.segment] };
        let place = half.map(|half| {
            let t = if forward { at.t } else { 1.0 - at.t };
            let mut weights = [0.0; 3];
            weights[half.index() % 3] = 1.0 - t;
            weights[next(half).index() % 3] = t;
            let location = Location { face: FaceId::new(half.index() / 3), weights: weights.into() };
            // In the chain's direction on both sides, so that UVs which are the same there stay so bit for bit.
            let [from, to] = if forward { [half, next(half)] } else { [next(half), half] };
            Place { location, uv: self.baseline.uvs[from].lerp(self.baseline.uvs[to], at.t) }
        });
        (position, place)
    }

    /// How bad a triangle with these corners is: 0 good, 1 degenerate or folded over in space, 2 the wrong way round in
    /// UV. No edit may make a triangle worse than what it replaces.
    pub fn badness(&self, corners: [(Vec3, Place); 3]) -> u8 {
        let [(a, pa), (b, pb), (c, pc)] = corners;
        let area = (pb.uv - pa.uv).perp_dot(pc.uv - pa.uv);
        if self.baseline.has_uvs && area * self.baseline.shell_sign[pa.location.face] <= 0.0 {
            return 2;
        }
        let normal = (b - a).cross(c - a);
        let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
        let surface: Vec3 =
            [pa, pb, pc].iter().map(|p| self.baseline.normal(p.location.face).normalize_or_zero()).sum();
        u8::from(normal.length() <= MIN_SHAPE * 0.866 * longest || normal.dot(surface) <= 0.0)
    }

    /// Whether a triangle with these corners turns away from the surface at one of them: it bridges a fold.
    pub fn bridges_fold(&self, corners: [(Vec3, Place); 3]) -> bool {
        let [(a, _), (b, _), (c, _)] = corners;
        let normal = (b - a).cross(c - a);
        corners.iter().any(|(_, place)| {
            let surface = self.baseline.normal(place.location.face);
            normal.dot(surface) <= MIN_COSINE * normal.length() * surface.length()
        })
    }

    /// Position and place of a corner.
    pub fn corner(&self, corner: CornerId) -> (Vec3, Place) {
        (self.points[self.topology.vertex(corner)], self.place[corner])
    }

    /// How bad the triangle of a corner is.
    pub fn face_badness(&self, corner: CornerId) -> u8 {
        self.badness([corner, next(corner), prev(corner)].map(|c| self.corner(c)))
    }

    /// Whether a vertex may take another place: no triangle around it becomes worse.
    pub fn may_move(&self, vertex: VertexId, position: Vec3, place: impl Fn(CornerId) -> Place) -> bool {
        self.topology.fan(vertex).all(|c| {
            let moved = [(position, place(c)), self.corner(next(c)), self.corner(prev(c))];
            self.badness(moved) <= self.face_badness(c)
        })
    }

    /// Splits an edge in its middle: on its chain's curve, or on the surface. Returns the new vertex; none where every
    /// place would turn a triangle over.
    pub fn split(&mut self, half: CornerId) -> Option<VertexId> {
        let span = self.span[half];
        let free_place = if span.is_none() { Some(self.middle_place(half)?) } else { None };
        let twin = self.topology.twin(half);
        let split = self.topology.split(half);
        let filler = self.place[half];
        self.span.resize(self.topology.corner_slots(), None);
        self.place.resize(self.topology.corner_slots(), filler);
        for (side, ahead) in [(Some(half), Some(split.ahead)), (twin, split.behind)] {
            if let (Some(side), Some(ahead)) = (side, ahead) {
                self.carry_split(side, ahead);
            }
        }
        let (position, grade) = match (span, free_place) {
            (Some(span), _) => {
                (self.place_on_curve(half, split.ahead, twin, split.behind, span), Grade::OnCurve(span.chain))
            }
            (None, place) => {
                let place = place.unwrap_or(filler);
                let corners: Vec<CornerId> = self.topology.fan(split.vertex).collect();
                corners.into_iter().for_each(|c| self.place[c] = place);
                (self.baseline.position(place.location), Grade::Free)
            }
        };
        self.points.push(position);
        self.grade.push(grade);
        self.target.push(self.baseline.target_at(self.place[split.ahead].location));
        Some(split.vertex)
    }

    /// The middle of a free edge on the surface: the closest point, or that between the UVs where the closest would turn
    /// a triangle over.
    fn middle_place(&self, half: CornerId) -> Option<Place> {
        let (from, to) = (self.place[half], self.place[next(half)]);
        let middle = self.points[self.topology.vertex(half)].midpoint(self.points[self.topology.target(half)]);
        let own = self.baseline.closest(from.location.face, middle);
        let other = self.baseline.closest(to.location.face, middle);
        let best = if other.distance_squared < own.distance_squared { other } else { own };
        let between = || {
            let uv = from.uv.midpoint(to.uv);
            let faces = [from.location.face, to.location.face].into_iter();
            faces.filter(|_| self.baseline.has_uvs).find_map(|f| self.baseline.locate_uv(f, uv))
        };
        let place = |location| Place { location, uv: self.baseline.uv(location) };
        let fits = |p: &Place| self.split_is_safe(half, *p);
        Some(place(best.location)).filter(fits).or_else(|| between().map(place).filter(fits))
    }

    /// Whether no half of a split triangle is worse than the whole was.
    fn split_is_safe(&self, half: CornerId, place: Place) -> bool {
        let m = (self.baseline.position(place.location), place);
        let side = |h: CornerId| {
            let [a, b, c] = [h, next(h), prev(h)].map(|c| self.corner(c));
            let worst = self.badness([a, m, c]).max(self.badness([m, b, c]));
            // A thin half is put right later; one that lies the wrong way round may stay for good.
            worst < 2 || worst <= self.badness([a, b, c])
        };
        side(half) && self.topology.twin(half).is_none_or(side)
    }

    /// One side of a split: `half` is `(a, m)` in `(a, m, c)`, `ahead` is `(m, b)` in `(m, b, c)`.
    fn carry_split(&mut self, half: CornerId, ahead: CornerId) {
        let (b, c) = (next(half), prev(half));
        self.place[next(ahead)] = self.place[b];
        self.place[prev(ahead)] = self.place[c];
        self.span[next(ahead)] = self.span[b];
        self.span[b] = None;
        self.span[prev(ahead)] = None;
    }

    fn place_on_curve(
        &mut self,
        half: CornerId,
        ahead: CornerId,
        twin: Option<CornerId>,
        behind: Option<CornerId>,
        span: Span,
    ) -> Vec3 {
        let s = 0.5 * (span.from + span.to);
        let (position, place) = self.on_curve(span.chain, s, span.forward);
        self.set_span(half, Span { to: s, ..span });
        self.set_span(ahead, Span { from: s, ..span });
        for (corner, place) in [(next(half), place), (ahead, place)] {
            self.place[corner] = place.unwrap_or(self.place[corner]);
        }
        if let (Some(twin), Some(behind)) = (twin, behind) {
            let (_, place) = self.on_curve(span.chain, s, !span.forward);
            for corner in [next(twin), behind] {
                self.place[corner] = place.unwrap_or(self.place[corner]);
            }
        }
        position
    }

    /// Sets the span of a half-edge and of its twin.
    pub fn set_span(&mut self, half: CornerId, span: Span) {
        self.span[half] = Some(span);
        if let Some(t) = self.topology.twin(half) {
            self.span[t] = Some(span.reversed());
        }
    }

    /// The corners at one end of an edge, and for each the place that the other end has in its sector: sectors are
    /// divided by constrained edges.
    pub fn merged_places(&self, half: CornerId, removed: VertexId) -> Vec<(CornerId, Place)> {
        let starts = self.topology.vertex(half) == removed;
        let twin = self.topology.twin(half);
        let left = self.place[if starts { next(half) } else { half }];
        let right = twin.map_or(left, |t| self.place[if starts { t } else { next(t) }]);
        let own = self.sector(if starts { half } else { next(half) });
        self.topology.fan(removed).map(|c| (c, if own.contains(&c) { left } else { right })).collect()
    }

    /// The corners at the vertex of `corner` that are reached from it without crossing a constrained edge.
    pub fn sector(&self, corner: CornerId) -> Vec<CornerId> {
        let mut sector = vec![corner];
        let mut at = corner;
        while self.span[prev(at)].is_none()
            && let Some(c) = self.topology.twin(prev(at))
            && c != corner
        {
            sector.push(c);
            at = c;
        }
        at = corner;
        while self.span[at].is_none()
            && let Some(t) = self.topology.twin(at)
            && !sector.contains(&next(t))
        {
            at = next(t);
            sector.push(at);
        }
        sector
    }

    /// The corners at a vertex of one chain, and whether each lies on the left of it. `half` is one of its edges there.
    pub fn sides(&self, vertex: VertexId, half: CornerId) -> Vec<(CornerId, bool)> {
        let starts = self.topology.vertex(half) == vertex;
        let own = self.sector(if starts { half } else { next(half) });
        // The triangle of a half-edge lies on its left.
        let is_left = self.span[half].is_some_and(|s| s.forward);
        self.topology.fan(vertex).map(|c| (c, own.contains(&c) == is_left)).collect()
    }

    /// Merges one end of an edge into the other, which keeps its place. The caller has asked whether that is allowed.
    pub fn collapse(&mut self, half: CornerId, removed: VertexId) {
        let places = self.merged_places(half, removed);
        self.join_spans(half, removed);
        let twin = self.topology.twin(half);
        // The two outer edges of each removed triangle become one; a span of either stays.
        let outer: Vec<_> = std::iter::once(half)
            .chain(twin)
            .map(|c| (self.topology.twin(next(c)), self.topology.twin(prev(c)), self.span[next(c)], self.span[prev(c)]))
            .collect();
        self.topology.collapse(half, removed);
        for (x, y, x_span, y_span) in outer {
            if let Some(x) = x {
                self.span[x] = x_span.map(Span::reversed).or(y_span);
            }
            if let Some(y) = y {
                self.span[y] = x_span.or(y_span.map(Span::reversed));
            }
        }
        for (corner, place) in places {
            self.place[corner] = place;
        }
    }

    /// Before a constrained edge goes: the chain's next edge, beyond `removed`, takes its part of the curve.
    fn join_spans(&mut self, half: CornerId, removed: VertexId) {
        let Some(span) = self.span[half] else { return };
        let step = if self.topology.vertex(half) == removed { span.to - span.from } else { span.from - span.to };
        let twin = self.topology.twin(half);
        let follower = self
            .topology
            .fan(removed)
            .flat_map(|c| [c, prev(c)])
            .find(|&c| self.span[c].is_some() && c != half && Some(c) != twin);
        let Some(follower) = follower else { return };
        let Some(next) = self.span[follower] else { return };
        let joined = if self.topology.vertex(follower) == removed {
            Span { from: next.from + step, ..next }
        } else {
            Span { to: next.to + step, ..next }
        };
        self.set_span(follower, joined);
    }

    /// Turns an unconstrained edge.
    pub fn flip(&mut self, half: CornerId) {
        let Some(twin) = self.topology.twin(half) else { return };
        let (hn, hp, on, op) = (next(half), prev(half), next(twin), prev(twin));
        let old = [half, hn, hp, twin, on, op].map(|c| (self.place[c], self.span[c]));
        let [(pa, _), (pb, bc), (pc, ca), _, (_, ad), (pd, db)] = old;
        if self.topology.flip(half).is_none() {
            return;
        }
        // (a, b, c) and (b, a, d) are now (c, d, b) and (d, c, a) in the same corners.
        for (corner, place, span) in
            [(half, pc, None), (hn, pd, db), (hp, pb, bc), (twin, pd, None), (on, pc, ca), (op, pa, ad)]
        {
            self.place[corner] = place;
            self.span[corner] = span;
        }
    }

    /// Panics where an invariant of the mesh is broken.
    pub fn assert_consistent(&self) {
        self.topology.assert_consistent();
        for half in self.topology.corners() {
            let (a, b) = (self.topology.vertex(half), self.topology.target(half));
            match self.span[half] {
                Some(span) => {
                    assert!(self.grade[a] != Grade::Free && self.grade[b] != Grade::Free, "chain ends are constrained");
                    let (p, _) = self.on_curve(span.chain, span.from, span.forward);
                    let (q, _) = self.on_curve(span.chain, span.to, span.forward);
                    let slack = 1e-3 * self.target[a];
                    assert!(
                        p.distance(self.points[a]) <= slack,
                        "{a:?} is on its curve: off by {}",
                        p.distance(self.points[a])
                    );
                    assert!(
                        q.distance(self.points[b]) <= slack,
                        "{b:?} is on its curve: off by {}",
                        q.distance(self.points[b])
                    );
                    if let Some(t) = self.topology.twin(half) {
                        assert_eq!(self.span[t], Some(span.reversed()), "the twin of {half:?} has the same span");
                    }
                }
                None => {
                    assert!(self.topology.twin(half).is_some(), "borders are chains");
                    assert!(self.topology.twin(half).is_none_or(|t| self.span[t].is_none()), "both halves are free");
                }
            }
            let place = self.place[half];
            let off = self.baseline.position(place.location).distance(self.points[a]);
            assert!(off <= 1e-3 * self.target[a], "{a:?} is where its corner says: off by {off}");
        }
    }
}
