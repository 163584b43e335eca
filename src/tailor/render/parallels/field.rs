//! The distance from chains along the surface, at the vertices, the middles of edges and the centres of faces near them.
//!
//! A front of waves goes over the quarters of faces, the nearest sample first. It starts on the wanted sides of the chains
//! alone, and does not go across a chain.

use super::Chain;
use super::waves::{Foot, Wave, over_edge, over_triangle};
use glam::Vec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use tailor_mesh::connectivity::{CornerId, EdgeId, FaceId, IdVec, Topology, VertexId};

/// What lies on an edge of a chain.
#[derive(Clone, Copy)]
struct Span {
    chain: usize,
    start: VertexId,
    /// Length of the chain before the edge, and up to its end. \[mesh units\]
    along: [f32; 2],
}

/// The surface with chains on it.
pub struct Surface<'a> {
    /// The connectivity.
    pub topology: &'a Topology,
    /// The positions of its vertices.
    pub points: &'a IdVec<VertexId, Vec3>,
    /// True if a face is on the right of its half-edges.
    pub is_left_handed: bool,
}

/// The distances.
pub struct Field<'a> {
    /// The surface.
    pub surface: &'a Surface<'a>,
    spans: IdVec<EdgeId, Option<Span>>,
    /// For each corner at a vertex of a chain, the half-edge of the chain that its sector belongs to, if that side is wanted.
    sectors: IdVec<CornerId, Option<CornerId>>,
    is_source: IdVec<VertexId, bool>,
    sides: [bool; 2],
    feet: Vec<Option<Foot>>,
    lengths: Vec<f32>,
}

/// A sample: a vertex, the middle of an edge or the centre of a face.
type Sample = usize;

impl<'a> Field<'a> {
    /// The distances from chains on the wanted sides, left and right, up to `reach` and one face more. \[mesh units\]
    pub fn new(surface: &'a Surface<'a>, chains: &[Chain], sides: [bool; 2], reach: f32) -> Self {
        let t = surface.topology;
        let mut field = Self {
            surface,
            spans: IdVec::filled(None, t.edges.len()),
            sectors: IdVec::filled(None, t.faces.corners().len()),
            is_source: IdVec::filled(false, t.vertex_count()),
            sides,
            feet: vec![None; t.vertex_count() + t.edges.len() + t.faces.len()],
            lengths: Vec::with_capacity(chains.len()),
        };
        for (chain, Chain { edges, .. }) in chains.iter().enumerate() {
            let mut length = 0.0;
            for &(edge, start) in edges {
                let ends = t.edges[edge];
                let next = length + surface.points[ends[0]].distance(surface.points[ends[1]]);
                field.spans[edge] = Some(Span { chain, start, along: [length, next] });
                ends.iter().for_each(|&v| field.is_source[v] = true);
                length = next;
            }
            field.lengths.push(length);
        }
        field.find_sectors();
        field.spread(reach);
        field
    }

    /// True if an edge of a chain has a face on this side of the chain.
    pub fn has_side(&self, edge: EdgeId, side: usize) -> bool {
        self.surface.topology.edge_corners.row(edge).iter().any(|&half| self.side(half) == Some(side))
    }

    /// The length of each chain. \[mesh units\]
    pub fn lengths(&self) -> &[f32] {
        &self.lengths
    }

    /// The part of its chain that an edge takes, as lengths from the start of the chain. \[mesh units\]
    pub fn span(&self, edge: EdgeId) -> [f32; 2] {
        self.spans[edge].map_or([0.0; 2], |span| span.along)
    }

    /// True for edges of a chain.
    pub fn is_chain(&self, edge: EdgeId) -> bool {
        self.spans[edge].is_some()
    }

    /// The foot of a vertex, as seen along an edge from it.
    pub fn at_vertex(&self, vertex: VertexId, edge: EdgeId) -> Option<Foot> {
        if !self.is_source[vertex] {
            return self.feet[vertex.index()];
        }
        let faces = &self.surface.topology.faces;
        let halves = self.surface.topology.edge_corners.row(edge).iter();
        let mut corners = halves.map(|&c| if faces.vertex(c) == vertex { c } else { faces.next(c) });
        corners.find_map(|c| self.foot_in(vertex.index(), c))
    }

    /// The foot of a vertex off the chains.
    pub fn off_chains(&self, vertex: VertexId) -> Option<Foot> {
        self.feet[vertex.index()]
    }

    /// The foot of the middle of an edge off the chains.
    pub fn at_middle(&self, edge: EdgeId) -> Option<Foot> {
        self.feet[self.middle(edge)]
    }

    /// The foot of a vertex on any side of the chains.
    pub fn around_vertex(&self, vertex: VertexId) -> Option<Foot> {
        self.around(vertex.index())
    }

    /// The foot of the middle of an edge on any side of the chains.
    pub fn around_middle(&self, edge: EdgeId) -> Option<Foot> {
        self.around(self.middle(edge))
    }

    fn around(&self, sample: Sample) -> Option<Foot> {
        let on_chain = || self.quarters_at(sample).into_iter().find_map(|corner| self.foot_in(sample, corner));
        if self.is_on_chain(sample) { on_chain() } else { self.feet[sample] }
    }

    /// The foot of the centre of a face.
    pub fn at_centre(&self, face: FaceId) -> Option<Foot> {
        self.feet[self.centre(face)]
    }

    /// The foot of a point inside a face, from the samples around the face.
    pub fn within(&self, face: FaceId, point: Vec3) -> Option<Foot> {
        let faces = &self.surface.topology.faces;
        let mut best: Option<Foot> = None;
        for corner in faces.corners_of(face) {
            let [vertex, after, _, before] = self.quarter(corner);
            for pair in [[vertex, after], [before, vertex]] {
                let feet = pair.map(|s| self.foot_in(s, corner).map(|foot| (self.place(s), foot)));
                best = feet.iter().flatten().map(|(p, foot)| over_edge(*foot, p.distance(point))).fold(best, nearer);
                if let [Some(a), Some(b)] = feet {
                    best = over_triangle(a, b, point).into_iter().fold(best, nearer);
                }
            }
        }
        best
    }

    fn middle(&self, edge: EdgeId) -> Sample {
        self.surface.topology.vertex_count() + edge.index()
    }

    fn centre(&self, face: FaceId) -> Sample {
        self.surface.topology.vertex_count() + self.surface.topology.edges.len() + face.index()
    }

    /// The samples of the quarter of a face at a corner, in the face's direction.
    fn quarter(&self, corner: CornerId) -> [Sample; 4] {
        let t = self.surface.topology;
        let [after, before] = [corner, t.faces.prev(corner)].map(|c| self.middle(t.corner_edge[c]));
        [t.faces.vertex(corner).index(), after, self.centre(t.faces.face_of(corner)), before]
    }

    /// The corners whose quarters have a sample.
    fn quarters_at(&self, sample: Sample) -> Vec<CornerId> {
        let t = self.surface.topology;
        let (vertices, edges) = (t.vertex_count(), t.edges.len());
        if sample < vertices {
            t.vertex_corners.row(VertexId::new(sample)).to_vec()
        } else if sample < vertices + edges {
            let halves = t.edge_corners.row(EdgeId::new(sample - vertices)).iter();
            halves.flat_map(|&half| [half, t.faces.next(half)]).collect()
        } else {
            t.faces.corners_of(FaceId::new(sample - vertices - edges)).collect()
        }
    }

    fn place(&self, sample: Sample) -> Vec3 {
        let (t, points) = (self.surface.topology, self.surface.points);
        let (vertices, edges) = (t.vertex_count(), t.edges.len());
        if sample < vertices {
            points[VertexId::new(sample)]
        } else if sample < vertices + edges {
            let [a, b] = t.edges[EdgeId::new(sample - vertices)];
            0.5 * (points[a] + points[b])
        } else {
            let around = t.faces.vertices_of(FaceId::new(sample - vertices - edges));
            around.iter().map(|&v| points[v]).sum::<Vec3>() / around.len() as f32
        }
    }

    /// True if a sample is on a chain.
    fn is_on_chain(&self, sample: Sample) -> bool {
        let (vertices, edges) = (self.is_source.len(), self.spans.len());
        if sample < vertices {
            return self.is_source[VertexId::new(sample)];
        }
        sample < vertices + edges && self.spans[EdgeId::new(sample - vertices)].is_some()
    }

    /// The foot of a sample, as seen from the quarter at a corner.
    fn foot_in(&self, sample: Sample, corner: CornerId) -> Option<Foot> {
        if !self.is_on_chain(sample) {
            return self.feet[sample];
        }
        let t = self.surface.topology;
        let is_vertex = sample < t.vertex_count();
        let half = if is_vertex {
            self.sectors[corner]?
        } else {
            [corner, t.faces.prev(corner)].into_iter().find(|&c| self.middle(t.corner_edge[c]) == sample)?
        };
        let span = self.spans[t.corner_edge[half]]?;
        let side = self.side(half).filter(|&side| self.sides[side])?;
        let [from, to] = span.along;
        let vertex = VertexId::new(sample.min(t.vertex_count() - 1));
        let (along, wave) = match is_vertex {
            true => (if vertex == span.start { from } else { to }, Wave::Circle(vertex)),
            false => (0.5 * (from + to), Wave::Plane),
        };
        Some(Foot { distance: 0.0, side, chain: span.chain, along, place: self.place(sample), wave })
    }

    /// The side of a chain on which the face of one of its half-edges is.
    fn side(&self, half: CornerId) -> Option<usize> {
        let t = self.surface.topology;
        let span = self.spans[t.corner_edge[half]]?;
        // A right-handed face is to the left of its half-edges.
        let is_left = (t.faces.vertex(half) == span.start) != self.surface.is_left_handed;
        Some(usize::from(!is_left))
    }

    /// Finds the half-edge of a chain that is nearest to each corner around a vertex of it.
    fn find_sectors(&mut self) {
        let t = self.surface.topology;
        let is_chain = |c: CornerId| self.spans[t.corner_edge[c]].is_some();
        let mut nearest: IdVec<CornerId, Option<CornerId>> = IdVec::filled(None, t.faces.corners().len());
        for vertex in self.is_source.ids().filter(|&v| self.is_source[v]) {
            let mut front: Vec<CornerId> = Vec::new();
            for &corner in t.vertex_corners.row(vertex) {
                let halves = [corner, t.faces.prev(corner)].into_iter().filter(|&c| is_chain(c));
                let is_wanted = |half: &CornerId| self.side(*half).is_some_and(|side| self.sides[side]);
                nearest[corner] = halves.clone().find(is_wanted).or(halves.clone().next());
                front.extend(nearest[corner].map(|_| corner));
            }
            while !front.is_empty() {
                let mut next = Vec::new();
                for corner in front {
                    for half in [corner, t.faces.prev(corner)].into_iter().filter(|&c| !is_chain(c)) {
                        let Some(twin) = t.twin(half) else { continue };
                        let around = [twin, t.faces.next(twin)].into_iter().find(|&c| t.faces.vertex(c) == vertex);
                        let Some(around) = around.filter(|&c| nearest[c].is_none()) else { continue };
                        nearest[around] = nearest[corner];
                        next.push(around);
                    }
                }
                front = next;
            }
        }
        let is_wanted = |half: &CornerId| self.side(*half).is_some_and(|side| self.sides[side]);
        self.sectors = nearest.iter().map(|half| half.filter(is_wanted)).collect();
    }

    fn spread(&mut self, reach: f32) {
        let t = self.surface.topology;
        let mut settled = vec![false; self.feet.len()];
        let mut front: BinaryHeap<Reverse<(u32, Sample)>> = BinaryHeap::new();
        let sources: Vec<VertexId> = self.is_source.ids().filter(|&v| self.is_source[v]).collect();
        // The samples around the last line are needed too, to place it between them.
        let mut most = reach;
        for corner in sources.into_iter().flat_map(|v| t.vertex_corners.row(v)) {
            most = most.max(reach + self.size(*corner));
            for sample in self.quarter(*corner) {
                if self.is_on_chain(sample) {
                    self.relax(*corner, sample, &settled, &mut front);
                }
            }
        }
        while let Some(Reverse((bits, sample))) = front.pop() {
            let distance = f32::from_bits(bits);
            if settled[sample] || self.feet[sample].is_none_or(|foot| foot.distance < distance) {
                continue;
            }
            if distance > most {
                break;
            }
            settled[sample] = true;
            for corner in self.quarters_at(sample) {
                if distance <= reach {
                    most = most.max(reach + self.size(corner));
                }
                self.relax(corner, sample, &settled, &mut front);
            }
        }
        self.feet.iter_mut().zip(settled).filter(|(_, settled)| !settled).for_each(|(foot, _)| *foot = None);
    }

    /// The size of a face, from a quarter of it. \[mesh units\]
    fn size(&self, corner: CornerId) -> f32 {
        let [a, b, c, d] = self.quarter(corner).map(|sample| self.place(sample));
        2.0 * a.distance(c).max(b.distance(d))
    }

    /// Lowers the distances in a quarter by the wave through a sample of it.
    fn relax(
        &mut self,
        corner: CornerId,
        from: Sample,
        settled: &[bool],
        front: &mut BinaryHeap<Reverse<(u32, Sample)>>,
    ) {
        let Some(foot) = self.foot_in(from, corner) else { return };
        let quarter = self.quarter(corner);
        let known = |s: Sample| s != from && (settled[s] || self.is_on_chain(s));
        let others: Vec<(Vec3, Foot)> = quarter
            .into_iter()
            .filter(|&s| known(s))
            .filter_map(|s| Some((self.place(s), self.foot_in(s, corner)?)))
            .collect();
        let place = self.place(from);
        for to in quarter {
            if to == from || settled[to] || self.is_on_chain(to) {
                continue;
            }
            let target = self.place(to);
            let straight = over_edge(foot, place.distance(target));
            let through = others.iter().filter_map(|&other| over_triangle((place, foot), other, target));
            let Some(best) = through.fold(Some(straight), nearer) else { continue };
            if best.distance.is_finite() && self.feet[to].is_none_or(|known| best.distance < known.distance) {
                self.feet[to] = Some(best);
                front.push(Reverse((best.distance.max(0.0).to_bits(), to)));
            }
        }
    }
}

/// The nearer of two feet; the first one of equals.
fn nearer(best: Option<Foot>, other: Foot) -> Option<Foot> {
    if best.is_some_and(|best| best.distance <= other.distance) { best } else { Some(other) }
}
