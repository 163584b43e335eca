//! The mesh under remeshing: topology, positions, and what each vertex and edge may do.

mod check;
mod edits;
pub mod patches;
pub mod quality;
mod reorder;

use crate::mesh::edit::{EditMesh, next, prev};
use crate::mesh::{ChainId, CornerId, FaceId, IdVec, SpanId, VertexId, WedgeId};
use crate::sim::baseline::{Baseline, Location};
use crate::sim::constraints::chain::{Chain, CurvePoint};
use crate::sim::gaps::distance_to_segment;
use crate::sim::sim_mesh::patches::PatchVertex;
use glam::{Vec2, Vec3};
use std::num::NonZeroU32;

/// What a vertex may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VertexConstraint {
    /// Anything on the surface.
    Free,
    /// Slide, split and merge along one chain.
    OnCurve(ChainId),
    /// Nothing: an anchor.
    Fixed,
}

/// A constrained half-edge: its part of a chain's curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveSpan {
    /// The chain.
    pub chain: ChainId,
    /// Arc length at the half-edge's start and end. Loops may count beyond their length. \[stage units\]
    pub from: f32,
    /// See `from`.
    pub to: f32,
    /// Number of edges that the chain asks for up to `from` and up to `to`.
    pub counts: [f32; 2],
    /// Whether the half-edge runs along the chain; lengths do not say that of an edge without length.
    pub forward: bool,
}

impl CurveSpan {
    /// As the twin has it.
    pub fn reversed(self) -> Self {
        let [from, to] = self.counts;
        Self { from: self.to, to: self.from, counts: [to, from], forward: !self.forward, ..self }
    }

    /// Whether a span in its chain's direction has no length left.
    pub fn is_reversed(self) -> bool {
        self.from >= self.to
    }

    /// Number of edges that it should be.
    pub fn count(self) -> f32 {
        (self.counts[1] - self.counts[0]).abs()
    }

    /// In the chain's own direction.
    pub fn along(self) -> Self {
        if self.forward { self } else { self.reversed() }
    }
}

/// Where a corner's vertex is, as the corner's triangle sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvLocation {
    /// The baseline's triangle.
    pub location: Location,
    /// Constraint UVs.
    pub uv: Vec2,
}

/// What the triangles of one sector of a vertex know of its place. Constrained edges divide sectors; a free vertex has
/// one.
#[derive(Clone, Copy, Debug)]
pub struct Wedge {
    /// The place.
    pub place: UvLocation,
    /// Unit normal of the surface.
    pub normal: Vec3,
    /// The sense in which the shell lies in UV space.
    pub sense: f32,
}

/// Which span a half-edge has, and whether it runs along it: in four bytes, none included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct DirectedSpan(NonZeroU32);

impl DirectedSpan {
    pub(crate) fn new(span: SpanId, forward: bool) -> Self {
        Self(NonZeroU32::MIN.saturating_add(2 * span.index() as u32 + u32::from(forward)))
    }

    pub(crate) fn span(self) -> SpanId {
        SpanId::new((self.0.get() - 1) as usize / 2)
    }

    /// The mark where spans have numbers larger by `by`.
    pub(crate) fn shifted(self, by: usize) -> Self {
        Self::new(SpanId::new(self.span().index() + by), self.is_forward())
    }

    pub(crate) fn is_forward(self) -> bool {
        (self.0.get() - 1) % 2 == 1
    }

    pub(crate) fn reversed(self) -> Self {
        Self::new(self.span(), !self.is_forward())
    }
}

/// The simulation mesh while it is made.
#[derive(Clone)]
pub struct SimMesh<'a> {
    /// The surface that it lies on.
    pub baseline: &'a Baseline,
    /// Connectivity.
    pub topology: EditMesh,
    /// Positions.
    pub points: IdVec<VertexId, Vec3>,
    /// Target edge length at each vertex: that of the baseline, or less on a chain that bends.
    pub target: IdVec<VertexId, f32>,
    /// What each vertex may do.
    pub constraint: IdVec<VertexId, VertexConstraint>,
    /// The constrained half-edges.
    pub(crate) mark: IdVec<CornerId, Option<DirectedSpan>>,
    /// Parts of curves, in their chains' directions.
    pub(crate) spans: IdVec<SpanId, CurveSpan>,
    /// The site that each corner's vertex has there.
    pub(crate) corner_wedge: IdVec<CornerId, WedgeId>,
    /// The sites. Those of vertices that went stay as gaps.
    pub(crate) wedges: IdVec<WedgeId, Wedge>,
    /// Which vertices a patch shares with others; empty for a whole mesh.
    pub(crate) patch_vertices: IdVec<VertexId, PatchVertex>,
}

impl<'a> SimMesh<'a> {
    /// The start mesh of a baseline.
    pub fn new(baseline: &'a Baseline) -> Self {
        let vertex = |c: CornerId| baseline.topology.faces.vertex(c);
        let triangles: Vec<[VertexId; 3]> = baseline.start.iter().map(|t| t.map(vertex)).collect();
        let topology = EditMesh::new(&triangles, baseline.points.len());
        let corners = topology.corner_slots();
        let mut mesh = Self {
            baseline,
            points: baseline.points.clone(),
            target: baseline.sizing.clone(),
            constraint: IdVec::filled(VertexConstraint::Free, baseline.points.len()),
            mark: IdVec::filled(None, corners),
            spans: IdVec::new(),
            corner_wedge: IdVec::filled(WedgeId::new(0), corners),
            wedges: IdVec::with_capacity(triangles.len()),
            patch_vertices: IdVec::new(),
            topology,
        };
        mesh.set_constraints();
        mesh.set_wedges();
        mesh
    }

    fn set_constraints(&mut self) {
        let mut on_chain = IdVec::<VertexId, bool>::filled(false, self.points.len());
        self.baseline.chains.iter().flat_map(|c| &c.vertices).for_each(|&v| on_chain[v] = true);
        let ends = |half: CornerId| [self.topology.vertex(half), self.topology.target(half)];
        let known = |half: &CornerId| ends(*half).iter().all(|&v| on_chain[self.baseline.level_vertex[v]]);
        let halves: Vec<CornerId> = self.topology.edges().filter(known).collect();
        for half in halves {
            let (a, b) = (self.topology.vertex(half), self.topology.target(half));
            let [x, y] = [a, b].map(|v| self.baseline.level_vertex[v]);
            let Some(start) = self.baseline.start_spans.get(&[x.min(y), x.max(y)]) else { continue };
            let counts = [start.from, start.to].map(|s| self.chain(start.chain).count_to(s));
            let span = CurveSpan { chain: start.chain, from: start.from, to: start.to, counts, forward: true };
            let span = self.spans.push(span);
            self.set_mark(half, DirectedSpan::new(span, start.first == x));
            for (v, s) in [(a, self.spans[span].from), (b, self.spans[span].to)] {
                let v = if start.first == x { v } else { if v == a { b } else { a } };
                self.constraint[v] = VertexConstraint::OnCurve(start.chain);
                self.target[v] = self.target[v].min(self.chain(start.chain).length_at(s));
            }
        }
        let mut is_anchor = IdVec::<VertexId, bool>::filled(false, self.points.len());
        for chain in self.baseline.chains.iter() {
            chain.pins.iter().for_each(|&i| is_anchor[chain.vertices[i]] = true);
            if !chain.is_loop {
                chain.vertices.first().into_iter().chain(chain.vertices.last()).for_each(|&v| is_anchor[v] = true);
            }
        }
        for (vertex, &level_vertex) in self.baseline.level_vertex.enumerated() {
            if is_anchor[level_vertex] {
                self.constraint[vertex] = VertexConstraint::Fixed;
            }
        }
    }

    /// A site for each sector of each vertex.
    fn set_wedges(&mut self) {
        let baseline = self.baseline;
        self.make_wedges(|corner| {
            let own = baseline.start[corner.index() / 3][corner.index() % 3];
            wedge_on(baseline, UvLocation { location: baseline.corner_location(own), uv: baseline.uvs[own] })
        });
        for half in self.topology.corners() {
            let Some(span) = self.span(half) else { continue };
            for (corner, s) in [(half, span.from), (next(half), span.to)] {
                let chain = self.chain(span.chain);
                self.wedges[self.corner_wedge[corner]].normal = chain.normal_at(chain.at(s), span.forward);
            }
        }
    }

    /// Makes a site for each sector of each vertex, as `site` tells it for one of its corners.
    pub(crate) fn make_wedges(&mut self, wedge: impl Fn(CornerId) -> Wedge) {
        let mut done = IdVec::<CornerId, bool>::filled(false, self.topology.corner_slots());
        for corner in (0..done.len()).map(CornerId::new) {
            if std::mem::replace(&mut done[corner], true) {
                continue;
            }
            let own = self.wedges.push(wedge(corner));
            self.corner_wedge[corner] = own;
            let mut give = |c: CornerId| {
                self.corner_wedge[c] = own;
                !std::mem::replace(&mut done[c], true)
            };
            // Both ways round, as `sector` goes.
            let mut at = corner;
            while self.mark[prev(at)].is_none()
                && let Some(c) = self.topology.twin(prev(at)).filter(|&c| give(c))
            {
                at = c;
            }
            at = corner;
            while self.mark[at].is_none()
                && let Some(c) = self.topology.twin(at).map(next).filter(|&c| give(c))
            {
                at = c;
            }
        }
    }

    /// The site of a location.
    pub(crate) fn wedge_at(&self, location: Location) -> Wedge {
        wedge_on(self.baseline, UvLocation { location, uv: self.baseline.uv(location) })
    }

    /// The chain of an id.
    pub fn chain(&self, id: ChainId) -> &'a Chain {
        &self.baseline.chains[id]
    }

    /// Length of a half-edge.
    #[inline]
    pub fn length(&self, half: CornerId) -> f32 {
        self.points[self.topology.vertex(half)].distance(self.points[self.topology.target(half)])
    }

    /// Target length of the edge between two vertices.
    #[inline]
    pub fn target_between(&self, a: VertexId, b: VertexId) -> f32 {
        0.5 * (self.target[a] + self.target[b])
    }

    /// Length of a half-edge over the length that it should have: the target, or less on a chain that bends.
    #[inline]
    pub fn relative_length(&self, half: CornerId) -> f32 {
        match self.span(half) {
            Some(span) => span.count(),
            None => self.length(half) / self.target_between(self.topology.vertex(half), self.topology.target(half)),
        }
    }

    /// Whether a half-edge is longer, or shorter, than a share of the length that it should have.
    #[inline]
    pub(crate) fn is_outside(&self, half: CornerId, share: f32, longer: bool) -> bool {
        if self.mark[half].is_some() {
            return self.chain_edge_is_outside(half, share, longer);
        }
        let (a, b) = (self.topology.vertex(half), self.topology.target(half));
        let bound = share * self.target_between(a, b);
        (self.points[a].distance_squared(self.points[b]) > bound * bound) == longer
    }

    /// The same for a constrained edge. Apart, so that the many free ones are asked quickly.
    #[cold]
    fn chain_edge_is_outside(&self, half: CornerId, share: f32, longer: bool) -> bool {
        (self.relative_length(half) > share) == longer
    }

    /// Whether an edge is constrained.
    #[inline]
    pub fn is_constrained(&self, half: CornerId) -> bool {
        self.mark[half].is_some()
    }

    /// The part of a chain that a half-edge follows.
    #[inline]
    pub fn span(&self, half: CornerId) -> Option<CurveSpan> {
        self.mark[half].map(|mark| {
            let span = self.spans[mark.span()];
            if mark.is_forward() { span } else { span.reversed() }
        })
    }

    /// The site of a corner's vertex there.
    #[inline]
    pub(crate) fn wedge(&self, corner: CornerId) -> &Wedge {
        &self.wedges[self.corner_wedge[corner]]
    }

    /// The place of a corner.
    pub fn place(&self, corner: CornerId) -> UvLocation {
        self.wedge(corner).place
    }

    /// Marks a half-edge and its twin.
    pub(crate) fn set_mark(&mut self, half: CornerId, mark: DirectedSpan) {
        self.mark[half] = Some(mark);
        if let Some(t) = self.topology.twin(half) {
            self.mark[t] = Some(mark.reversed());
        }
    }

    /// Adds a part of a curve and marks a half-edge and its twin with it.
    pub(crate) fn add_span(&mut self, half: CornerId, span: CurveSpan) {
        let id = self.spans.push(span.along());
        self.set_mark(half, DirectedSpan::new(id, span.forward));
    }

    /// Position of a place on a chain's curve.
    #[inline]
    pub(crate) fn point_on(&self, curve: &Chain, at: CurvePoint) -> Vec3 {
        let (a, b) = (curve.vertices[at.segment], curve.vertices[at.segment + 1]);
        self.baseline.points[a].lerp(self.baseline.points[b], at.t)
    }

    /// Position of the place on a chain's curve at arc length `s`.
    pub fn on_curve(&self, chain: ChainId, s: f32) -> Vec3 {
        let curve = self.chain(chain);
        self.point_on(curve, curve.at(s))
    }

    /// How far a curve is from a chord at some arc lengths, one after the other from about `from` on.
    pub(crate) fn off_chord(
        &self,
        curve: &Chain,
        from: f32,
        places: impl Iterator<Item = f32>,
        [a, b]: [Vec3; 2],
    ) -> impl Iterator<Item = f32> {
        let mut near = curve.at(from).segment;
        places.map(move |s| distance_to_segment(self.point_on(curve, curve.at_after(s, &mut near)), a, b))
    }

    /// The site of a place on a chain's curve, on the side of a half-edge that runs `forward` along it.
    pub(crate) fn wedge_on_curve(&self, curve: &Chain, at: CurvePoint, forward: bool) -> Option<Wedge> {
        let half = if forward { curve.left[at.segment] } else { curve.right[at.segment] }?;
        let t = if forward { at.t } else { 1.0 - at.t };
        let mut weights = [0.0; 3];
        weights[half.index() % 3] = 1.0 - t;
        weights[next(half).index() % 3] = t;
        let location = Location { face: FaceId::new(half.index() / 3), weights: weights.into() };
        // In the chain's direction on both sides, so that UVs which are the same there stay so bit for bit.
        let [from, to] = if forward { [half, next(half)] } else { [next(half), half] };
        let place = UvLocation { location, uv: self.baseline.uvs[from].lerp(self.baseline.uvs[to], at.t) };
        Some(Wedge { normal: curve.normal_at(at, forward), ..wedge_on(self.baseline, place) })
    }

    /// The corners at the vertex of `corner` that are reached from it without crossing a constrained edge.
    pub(crate) fn sector(&self, corner: CornerId, sector: &mut Vec<CornerId>) {
        sector.clear();
        sector.push(corner);
        let mut at = corner;
        while self.mark[prev(at)].is_none()
            && let Some(c) = self.topology.twin(prev(at))
        {
            if c == corner {
                return;
            }
            sector.push(c);
            at = c;
        }
        at = corner;
        while self.mark[at].is_none()
            && let Some(t) = self.topology.twin(at)
        {
            at = next(t);
            sector.push(at);
        }
    }

    /// The two constrained half-edges that leave a vertex of one chain: along the chain, and against it. At a border
    /// one of them is the twin that is not there; its other half, which arrives, stands for it.
    pub(crate) fn chain_neighbours(&self, vertex: VertexId) -> Option<[CornerId; 2]> {
        let mut found = [None; 2];
        for c in self.topology.fan(vertex) {
            for half in [c, prev(c)] {
                let Some(mark) = self.mark[half] else { continue };
                let leaves = half == c;
                let slot = &mut found[usize::from(mark.is_forward() != leaves)];
                // The half that leaves is better.
                if slot.is_none() || leaves {
                    *slot = Some(half);
                }
            }
        }
        Some([found[0]?, found[1]?])
    }
}

/// The site of a place on a baseline.
fn wedge_on(baseline: &Baseline, place: UvLocation) -> Wedge {
    let facet = &baseline.facets[place.location.face];
    Wedge { place, normal: facet.normal, sense: facet.sense }
}
