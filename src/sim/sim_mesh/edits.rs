//! Split, collapse and flip with all that the mesh carries: constraint spans, sites, targets.

use crate::mesh::edit::{next, prev};
use crate::mesh::{CornerId, VertexId, WedgeId};
use crate::sim::sim_mesh::quality::Corner;
use crate::sim::sim_mesh::{CurveSpan, DirectedSpan, SimMesh, VertexConstraint, Wedge};
use glam::Vec3;

/// A middle that lies nearer to the surface than this share of the edge's length needs no second search.
const NEAR: f32 = 0.05;

impl SimMesh<'_> {
    /// Splits an edge in its middle: on its chain's curve, or on the surface. Returns the new vertex; none where every
    /// place would turn a triangle over.
    pub fn split(&mut self, half: CornerId) -> Option<VertexId> {
        match self.span(half) {
            Some(span) => Some(self.split_span(half, span)),
            None => {
                let (position, wedge) = self.middle_wedge(half)?;
                let ahead = self.split_topology(half);
                let wedge = self.wedges.push(wedge);
                let (first, second) = (self.topology.twin(half), self.topology.twin(ahead));
                for c in [next(half), ahead].into_iter().chain(first).chain(second.map(next)) {
                    self.corner_wedge[c] = wedge;
                }
                let target = self.baseline.sizing_at(self.wedges[wedge].place.location);
                Some(self.settle_new(position, VertexConstraint::Free, target))
            }
        }
    }

    /// The topology of a split; what corners and edges had before, they have after. Returns the half-edge ahead.
    fn split_topology(&mut self, half: CornerId) -> CornerId {
        let twin = self.topology.twin(half);
        let split = self.topology.split(half);
        self.mark.resize(self.topology.corner_slots(), None);
        self.corner_wedge.resize(self.topology.corner_slots(), WedgeId::new(0));
        for (side, ahead) in [(Some(half), Some(split.ahead)), (twin, split.behind)] {
            let (Some(side), Some(ahead)) = (side, ahead) else { continue };
            // `side` is (a, m) in (a, m, c), `ahead` is (m, b) in (m, b, c).
            let (b, c) = (next(side), prev(side));
            self.corner_wedge[next(ahead)] = self.corner_wedge[b];
            self.corner_wedge[prev(ahead)] = self.corner_wedge[c];
            self.mark[next(ahead)] = self.mark[b].take();
        }
        split.ahead
    }

    fn settle_new(&mut self, position: Vec3, constraint: VertexConstraint, target: f32) -> VertexId {
        self.constraint.push(constraint);
        self.target.push(target);
        self.points.push(position)
    }

    fn split_span(&mut self, half: CornerId, span: CurveSpan) -> VertexId {
        let s = self.middle_of_span(span);
        let chain = self.chain(span.chain);
        let (turn, at) = chain.wound(s);
        let count = chain.count_of(turn, at);
        let ahead = self.split_topology(half);
        self.add_span(half, CurveSpan { to: s, counts: [span.counts[0], count], ..span });
        self.add_span(ahead, CurveSpan { from: s, counts: [count, span.counts[1]], ..span });
        let own = self.add_wedge(self.wedge_on_curve(chain, at, span.forward), half);
        self.corner_wedge[next(half)] = own;
        self.corner_wedge[ahead] = own;
        if let (Some(first), Some(second)) = (self.topology.twin(half), self.topology.twin(ahead)) {
            let other = self.add_wedge(self.wedge_on_curve(chain, at, !span.forward), second);
            self.corner_wedge[first] = other;
            self.corner_wedge[next(second)] = other;
        }
        self.settle_new(self.point_on(chain, at), VertexConstraint::OnCurve(span.chain), chain.length_of(at))
    }

    /// The arc length in the middle of a span, as the chain counts edges. \[stage units\]
    pub(crate) fn middle_of_span(&self, span: CurveSpan) -> f32 {
        let s = self.chain(span.chain).at_count(0.5 * (span.counts[0] + span.counts[1]));
        s.clamp(span.from.min(span.to), span.from.max(span.to))
    }

    /// Whether no triangle would be worse than what it is a half of, if a constrained edge were split.
    pub(crate) fn span_split_is_safe(&self, half: CornerId, span: CurveSpan) -> bool {
        let chain = self.chain(span.chain);
        let at = chain.at(self.middle_of_span(span));
        let position = self.point_on(chain, at);
        let side = |half: CornerId, forward: bool| {
            let wedge = self.wedge_on_curve(chain, at, forward);
            let [halves, whole] = self.halves(half, (position, &wedge.unwrap_or(*self.wedge(half))));
            halves <= whole
        };
        side(half, span.forward) && self.topology.twin(half).is_none_or(|twin| side(twin, !span.forward))
    }

    fn add_wedge(&mut self, wedge: Option<Wedge>, like: CornerId) -> WedgeId {
        let wedge = wedge.unwrap_or(*self.wedge(like));
        self.wedges.push(wedge)
    }

    /// The middle of a free edge on the surface: the closest point, or that between the UVs where the closest would turn
    /// a triangle over.
    fn middle_wedge(&self, half: CornerId) -> Option<(Vec3, Wedge)> {
        let (from, to) = (self.place(half), self.place(next(half)));
        let ends = [self.points[self.topology.vertex(half)], self.points[self.topology.target(half)]];
        let middle = ends[0].midpoint(ends[1]);
        let mut best = self.baseline.closest(from.location.face, middle);
        if best.distance_squared > NEAR * NEAR * ends[0].distance_squared(ends[1]) {
            let other = self.baseline.closest(to.location.face, middle);
            if other.distance_squared < best.distance_squared {
                best = other;
            }
        }
        let between = || {
            let uv = from.uv.midpoint(to.uv);
            let faces = [from.location.face, to.location.face].into_iter();
            let found = faces.filter(|_| self.baseline.holds_uvs).find_map(|f| self.baseline.locate_uv(f, uv))?;
            Some((self.baseline.position(found), self.wedge_at(found)))
        };
        let fits = |m: &(Vec3, Wedge)| self.split_is_safe(half, m.0, &m.1);
        Some((best.position, self.wedge_at(best.location))).filter(fits).or_else(|| between().filter(fits))
    }

    /// Whether no half of a split triangle is worse than the whole was.
    fn split_is_safe(&self, half: CornerId, position: Vec3, wedge: &Wedge) -> bool {
        let side = |h: CornerId| {
            let [halves, whole] = self.halves(h, (position, wedge));
            // A thin half is put right later; one that lies the wrong way round may stay for good.
            halves < 2 || halves <= whole
        };
        side(half) && self.topology.twin(half).is_none_or(side)
    }

    /// How bad the worse half of a triangle is that is split at `middle` of an edge, and how bad the whole.
    fn halves(&self, half: CornerId, middle: Corner<'_>) -> [u8; 2] {
        let [a, b, c] = self.corners(half);
        [self.defect([a, middle, c]).max(self.defect([middle, b, c])), self.defect([a, b, c])]
    }

    /// The sites that the corners of `removed` get when it merges into the other end of `half`: those of that end, on
    /// the left of the half-edge and on its right.
    pub(crate) fn merged_wedges(&self, half: CornerId, removed: VertexId) -> [WedgeId; 2] {
        let starts = self.topology.vertex(half) == removed;
        let left = self.corner_wedge[if starts { next(half) } else { half }];
        let right = self.topology.twin(half).map_or(left, |t| self.corner_wedge[if starts { t } else { next(t) }]);
        [left, right]
    }

    /// The corners at one end of a constrained edge in the sector on the edge's left; none for a free edge, all of
    /// whose corners get the same.
    pub(crate) fn left_sector(&self, half: CornerId, removed: VertexId, sector: &mut Vec<CornerId>) {
        sector.clear();
        if self.is_constrained(half) {
            let starts = self.topology.vertex(half) == removed;
            self.sector(if starts { half } else { next(half) }, sector);
        }
    }

    /// Merges one end of an edge into the other, which keeps its place. The caller has asked whether that is allowed.
    pub fn collapse(&mut self, half: CornerId, removed: VertexId) {
        let [left, right] = self.merged_wedges(half, removed);
        let mut sector = Vec::new();
        self.left_sector(half, removed, &mut sector);
        let mut at = self.topology.fan(removed).next();
        let first = at;
        while let Some(c) = at {
            self.corner_wedge[c] = if sector.is_empty() || sector.contains(&c) { left } else { right };
            at = self.topology.twin(prev(c)).filter(|&c| Some(c) != first);
        }
        self.join_spans(half, removed);
        let twin = self.topology.twin(half);
        // The two outer edges of each removed triangle become one; a mark of either stays.
        let outer = [Some(half), twin].map(|side| {
            let side = side?;
            let (x, y) = (next(side), prev(side));
            Some((self.topology.twin(x), self.topology.twin(y), self.mark[x], self.mark[y]))
        });
        self.topology.collapse(half, removed);
        for (x, y, x_mark, y_mark) in outer.into_iter().flatten() {
            if let Some(x) = x {
                self.mark[x] = x_mark.map(DirectedSpan::reversed).or(y_mark);
            }
            if let Some(y) = y {
                self.mark[y] = x_mark.or(y_mark.map(DirectedSpan::reversed));
            }
        }
    }

    /// Before a constrained edge goes: the chain's next edge, beyond `removed`, takes its part of the curve.
    fn join_spans(&mut self, half: CornerId, removed: VertexId) {
        let Some(span) = self.span(half) else { return };
        let goes = if self.topology.vertex(half) == removed { span } else { span.reversed() };
        let (step, count) = (goes.to - goes.from, goes.counts[1] - goes.counts[0]);
        let Some(own) = self.mark[half].map(DirectedSpan::span) else { return };
        let follower = self
            .topology
            .fan(removed)
            .flat_map(|c| [c, prev(c)])
            .find(|&c| self.mark[c].is_some_and(|mark| mark.span() != own));
        let Some(follower) = follower else { return };
        let Some(mark) = self.mark[follower] else { return };
        let leaves = self.topology.vertex(follower) == removed;
        let next = &mut self.spans[mark.span()];
        if leaves == mark.is_forward() {
            next.from += step;
            next.counts[0] += count;
        } else {
            next.to += step;
            next.counts[1] += count;
        }
    }

    /// Turns an edge back that was turned.
    pub(crate) fn unflip(&mut self, half: CornerId) {
        let Some(twin) = self.topology.twin(half) else { return };
        let (hn, hp, on, op) = (next(half), prev(half), next(twin), prev(twin));
        let [(sd, db), (sb, bc), (sc, ca), (sa, ad)] = [hn, hp, on, op].map(|c| (self.corner_wedge[c], self.mark[c]));
        self.topology.unflip(half);
        self.set_quad([(half, sa, None), (hn, sb, bc), (hp, sc, ca), (twin, sb, None), (on, sa, ad), (op, sd, db)]);
    }

    fn set_quad(&mut self, corners: [(CornerId, WedgeId, Option<DirectedSpan>); 6]) {
        for (corner, wedge, mark) in corners {
            self.corner_wedge[corner] = wedge;
            self.mark[corner] = mark;
        }
    }

    /// Turns an unconstrained edge.
    pub fn flip(&mut self, half: CornerId) {
        let Some(twin) = self.topology.twin(half) else { return };
        let (hn, hp, on, op) = (next(half), prev(half), next(twin), prev(twin));
        let old = [half, hn, hp, twin, on, op].map(|c| (self.corner_wedge[c], self.mark[c]));
        let [(sa, _), (sb, bc), (sc, ca), _, (_, ad), (sd, db)] = old;
        if self.topology.flip(half).is_none() {
            return;
        }
        // (a, b, c) and (b, a, d) are now (c, d, b) and (d, c, a) in the same corners.
        self.set_quad([(half, sc, None), (hn, sd, db), (hp, sb, bc), (twin, sd, None), (on, sc, ca), (op, sa, ad)]);
    }
}
