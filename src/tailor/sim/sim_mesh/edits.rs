//! Split, collapse and flip with everything that the mesh carries: spans, wedges, targets.

use super::quality::Defect;
use super::span::DirectedSpan;
use super::{CurveSpan, SimMesh, TriangleCorner, VertexConstraint, Wedge};
use glam::Vec3;
use tailor_mesh::connectivity::edit::{next, prev};
use tailor_mesh::connectivity::{CornerId, VertexId, WedgeId};

/// A midpoint nearer to the surface than this share of the edge's length needs no second search.
const NEAR: f32 = 0.05;

impl SimMesh<'_> {
    /// Splits an edge at its midpoint: on its chain's curve, or on the surface. Returns the new vertex; none where every
    /// point would flip a triangle.
    pub fn split(&mut self, half: CornerId) -> Option<VertexId> {
        match self.span(half) {
            Some(span) => Some(self.split_span(half, span)),
            None => {
                let (position, wedge) = self.middle_wedge(half)?;
                let target = self.baseline.sizing_at(wedge.place.location);
                let ahead = self.split_topology(half);
                let own = self.wedges.push(wedge);
                let (first, second) = (self.topology.twin(half), self.topology.twin(ahead));
                for c in [next(half), ahead].into_iter().chain(first).chain(second.map(next)) {
                    self.corner_wedge[c] = own;
                }
                Some(self.push_vertex(position, VertexConstraint::Free, target))
            }
        }
    }

    /// Splits the topology. Old corners and edges keep what they have; the caller sets the wedges at the new vertex.
    /// Returns the half-edge ahead.
    fn split_topology(&mut self, half: CornerId) -> CornerId {
        let twin = self.topology.twin(half);
        let split = self.topology.split(half);
        self.corner_span.resize(self.topology.corner_slots(), None);
        self.corner_wedge.resize(self.topology.corner_slots(), WedgeId::new(0));
        for (side, ahead) in std::iter::once((half, split.ahead)).chain(twin.zip(split.behind)) {
            // `side` is (a, m) in (a, m, c), `ahead` is (m, b) in (m, b, c).
            let (b, c) = (next(side), prev(side));
            self.corner_wedge[next(ahead)] = self.corner_wedge[b];
            self.corner_wedge[prev(ahead)] = self.corner_wedge[c];
            self.corner_span[next(ahead)] = self.corner_span[b].take();
        }
        split.ahead
    }

    fn push_vertex(&mut self, position: Vec3, constraint: VertexConstraint, target: f32) -> VertexId {
        self.constraint.push(constraint);
        self.target.push(target);
        self.points.push(position)
    }

    fn split_span(&mut self, half: CornerId, span: CurveSpan) -> VertexId {
        let s = self.middle_of_span(span);
        let chain = self.chain(span.chain);
        let (turns, at) = chain.at_with_turns(s);
        let count = chain.count_at(turns, at);
        let ahead = self.split_topology(half);
        self.add_span(half, CurveSpan { to: s, counts: [span.counts[0], count], ..span });
        self.add_span(ahead, CurveSpan { from: s, counts: [count, span.counts[1]], ..span });
        let twins = self.topology.twin(half).zip(self.topology.twin(ahead));
        let other_side = twins.map(|(first, second)| (!span.forward, [first, next(second)]));
        for (forward, corners) in std::iter::once((span.forward, [next(half), ahead])).chain(other_side) {
            let wedge = self.wedge_on_curve(chain, at, forward);
            let own =
                self.wedges.push(wedge.unwrap_or_else(|| unreachable!("a triangle lies on a face of the surface")));
            corners.into_iter().for_each(|c| self.corner_wedge[c] = own);
        }
        self.push_vertex(self.position_on(chain, at), VertexConstraint::OnCurve(span.chain), chain.length_at(at))
    }

    /// The arc length in the middle of a span, as the chain counts edges. \[mesh units\]
    pub fn middle_of_span(&self, span: CurveSpan) -> f32 {
        let s = self.chain(span.chain).at_count(0.5 * (span.counts[0] + span.counts[1]));
        s.clamp(span.from.min(span.to), span.from.max(span.to))
    }

    /// Whether splitting a constrained edge makes no triangle worse than the one it is a half of.
    pub fn span_split_is_safe(&self, half: CornerId, span: CurveSpan) -> bool {
        let chain = self.chain(span.chain);
        let at = chain.at(self.middle_of_span(span));
        let position = self.position_on(chain, at);
        let side = |half: CornerId, forward: bool| {
            self.wedge_on_curve(chain, at, forward).is_some_and(|wedge| {
                let [halves, whole] = self.halves(half, (position, &wedge));
                halves <= whole
            })
        };
        side(half, span.forward) && self.topology.twin(half).is_none_or(|twin| side(twin, !span.forward))
    }

    /// The midpoint of a free edge on the surface: the closest point, or the midpoint of the UVs where the closest would
    /// flip a triangle.
    fn middle_wedge(&self, half: CornerId) -> Option<(Vec3, Wedge)> {
        let (from, to) = (self.place(half), self.place(next(half)));
        let [a, b] = self.end_points(half);
        let middle = a.midpoint(b);
        let mut best = self.baseline.closest(from.location.face, middle);
        if best.distance_squared > NEAR * NEAR * a.distance_squared(b) {
            let other = self.baseline.closest(to.location.face, middle);
            if other.distance_squared < best.distance_squared {
                best = other;
            }
        }
        let by_uv = || {
            let uv = from.uv.midpoint(to.uv);
            let faces = [from.location.face, to.location.face].into_iter();
            let found = faces.filter(|_| self.baseline.has_uvs).find_map(|f| self.baseline.locate_uv(f, uv))?;
            Some((self.baseline.position(found), self.wedge_at(found)))
        };
        let is_safe = |m: &(Vec3, Wedge)| self.split_is_safe(half, m.0, &m.1);
        // Where UVs are stretched their midpoint may be far away. Halves longer than the edge would be split without end.
        let is_near = |m: &(Vec3, Wedge)| [a, b].iter().all(|end| end.distance_squared(m.0) < a.distance_squared(b));
        let closest = Some((best.position, self.wedge_at(best.location))).filter(is_safe);
        closest.or_else(|| by_uv().filter(|m| is_near(m) && is_safe(m)))
    }

    /// Whether splitting a free edge flips no triangle that was not flipped before.
    fn split_is_safe(&self, half: CornerId, position: Vec3, wedge: &Wedge) -> bool {
        let side = |h: CornerId| {
            let [halves, whole] = self.halves(h, (position, wedge));
            // Later passes repair a thin half; a flipped one may stay.
            halves < Defect::Flipped || halves <= whole
        };
        side(half) && self.topology.twin(half).is_none_or(side)
    }

    /// Defects of the worse half of a triangle that is split at `middle` of an edge, and of the whole.
    fn halves(&self, half: CornerId, middle: TriangleCorner<'_>) -> [Defect; 2] {
        let [a, b, c] = self.corners(half);
        [self.defect([a, middle, c]).max(self.defect([middle, b, c])), self.defect([a, b, c])]
    }

    /// The wedges that the corners of `removed` get when it collapses into the other end of `half`: those of that end, on
    /// the left of the half-edge and on its right.
    pub fn merged_wedges(&self, half: CornerId, removed: VertexId) -> [WedgeId; 2] {
        let starts = self.topology.vertex(half) == removed;
        let left = self.corner_wedge[if starts { next(half) } else { half }];
        let right = self.topology.twin(half).map_or(left, |t| self.corner_wedge[if starts { t } else { next(t) }]);
        [left, right]
    }

    /// The corners at one end of a constrained edge in the sector on the edge's left; none for a free edge, all of whose
    /// corners get the same wedge.
    pub fn left_sector(&self, half: CornerId, removed: VertexId) -> Vec<CornerId> {
        let mut sector = Vec::new();
        if self.is_constrained(half) {
            let starts = self.topology.vertex(half) == removed;
            self.sector(if starts { half } else { next(half) }, &mut sector);
        }
        sector
    }

    /// Collapses one end of an edge into the other, which stays in place. The caller has checked that it is allowed.
    pub fn collapse(&mut self, half: CornerId, removed: VertexId) {
        let [left, right] = self.merged_wedges(half, removed);
        let sector = self.left_sector(half, removed);
        let mut at = self.topology.fan(removed).next();
        let first = at;
        while let Some(c) = at {
            self.corner_wedge[c] = if sector.is_empty() || sector.contains(&c) { left } else { right };
            at = self.topology.twin(prev(c)).filter(|&c| Some(c) != first);
        }
        self.join_spans(half, removed);
        // The two outer edges of each removed triangle become one, which keeps the span of either.
        let outer = [Some(half), self.topology.twin(half)].map(|side| {
            let (x, y) = (next(side?), prev(side?));
            Some((self.topology.twin(x), self.topology.twin(y), self.corner_span[x], self.corner_span[y]))
        });
        self.topology.collapse(half, removed);
        for (x, y, x_span, y_span) in outer.into_iter().flatten() {
            if let Some(x) = x {
                self.corner_span[x] = x_span.map(DirectedSpan::reversed).or(y_span);
            }
            if let Some(y) = y {
                self.corner_span[y] = x_span.or(y_span.map(DirectedSpan::reversed));
            }
        }
    }

    /// Before a constrained edge collapses: the chain's next edge, beyond `removed`, takes over its part of the curve.
    fn join_spans(&mut self, half: CornerId, removed: VertexId) {
        let (Some(own), Some(span)) = (self.corner_span[half], self.span(half)) else { return };
        let lost = if self.topology.vertex(half) == removed { span } else { span.reversed() };
        let (step, count) = (lost.to - lost.from, lost.counts[1] - lost.counts[0]);
        let mut around = self.topology.fan(removed).flat_map(|c| [c, prev(c)]);
        let beyond = around.find_map(|c| Some((c, self.corner_span[c].filter(|s| s.span() != own.span())?)));
        let Some((follower, directed)) = beyond else { return };
        let is_start = (self.topology.vertex(follower) == removed) == directed.is_forward();
        let next = &mut self.spans[directed.span()];
        *(if is_start { &mut next.from } else { &mut next.to }) += step;
        next.counts[usize::from(!is_start)] += count;
    }

    /// Undoes [`Self::flip`].
    pub fn unflip(&mut self, half: CornerId) {
        let Some(twin) = self.topology.twin(half) else { return };
        let (hn, hp, on, op) = (next(half), prev(half), next(twin), prev(twin));
        let [(sd, db), (sb, bc), (sc, ca), (sa, ad)] =
            [hn, hp, on, op].map(|c| (self.corner_wedge[c], self.corner_span[c]));
        self.topology.unflip(half);
        self.set_quad([(half, sa, None), (hn, sb, bc), (hp, sc, ca), (twin, sb, None), (on, sa, ad), (op, sd, db)]);
    }

    fn set_quad(&mut self, corners: [(CornerId, WedgeId, Option<DirectedSpan>); 6]) {
        for (corner, wedge, span) in corners {
            self.corner_wedge[corner] = wedge;
            self.corner_span[corner] = span;
        }
    }

    /// Flips an unconstrained edge.
    pub fn flip(&mut self, half: CornerId) {
        let Some(twin) = self.topology.twin(half) else { return };
        let (hn, hp, on, op) = (next(half), prev(half), next(twin), prev(twin));
        let old = [half, hn, hp, twin, on, op].map(|c| (self.corner_wedge[c], self.corner_span[c]));
        let [(sa, _), (sb, bc), (sc, ca), _, (_, ad), (sd, db)] = old;
        if self.topology.flip(half).is_none() {
            return;
        }
        // (a, b, c) and (b, a, d) are now (c, d, b) and (d, c, a) in the same corners.
        self.set_quad([(half, sc, None), (hn, sd, db), (hp, sb, bc), (twin, sd, None), (on, sc, ca), (op, sa, ad)]);
    }
}
