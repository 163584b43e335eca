//! The triangles of one side of a symmetric garment on its other side.

use super::baseline::{Baseline, BaselinePoint};
use super::constraints::chain::{Chain, CurvePoint};
use super::product::ChainEdge;
use super::sim_mesh::{BaselineUvPoint, SimMesh};
use glam::{Vec2, Vec3};
use rustc_hash::FxHashMap;
use std::collections::BTreeSet;
use tailor_mesh::connectivity::{ChainId, CornerId, IdVec, VertexId};

/// UVs of one vertex that differ by no more are rounded values of one. \[ulps of the larger\]
const ROUNDING: f32 = 8.0;

/// A mesh on a baseline, which grows by its other side.
pub struct Sides<'a> {
    pub baseline: &'a Baseline,
    pub points: IdVec<VertexId, Vec3>,
    pub triangles: Vec<[VertexId; 3]>,
    pub places: IdVec<CornerId, BaselineUvPoint>,
    pub edges: IdVec<ChainId, Vec<ChainEdge>>,
    /// The vertex on the other side; at first those on the plane, which are their own.
    pub twin: IdVec<VertexId, Option<VertexId>>,
}

/// Splits the edges between two vertices on the plane that are not on it themselves: their twins would be the same edges. Returns
/// the vertices on the plane.
pub fn part_from_plane(mesh: &mut SimMesh<'_>) -> BTreeSet<VertexId> {
    let baseline = mesh.baseline;
    if baseline.mirror.is_empty() {
        return BTreeSet::new();
    }
    let chain_is_on_plane = |chain: &Chain| baseline.mirror.is_on_plane(chain.vertices.iter().copied());
    let is_on_plane: IdVec<ChainId, bool> = baseline.chains.iter().map(chain_is_on_plane).collect();
    let (along, others): (Vec<CornerId>, Vec<CornerId>) =
        mesh.topology.edges().partition(|&half| mesh.span(half).is_some_and(|span| is_on_plane[span.chain]));
    let shared: BTreeSet<VertexId> = along.into_iter().flat_map(|half| mesh.topology.ends(half)).collect();
    for half in others {
        if mesh.topology.ends(half).iter().all(|v| shared.contains(v)) && mesh.topology.may_split(half) {
            mesh.split(half);
        }
    }
    shared
}

impl Sides<'_> {
    /// Adds the twins of all triangles on faces that are copied. Vertices on the plane belong to both sides.
    pub fn copied(mut self) -> Self {
        if self.baseline.mirror.is_empty() {
            return self;
        }
        let mut known = FxHashMap::<VertexId, Vec<Vec2>>::default();
        let at_plane = |(_, v): &(usize, &VertexId)| self.twin[**v].is_some();
        for (corner, &v) in self.triangles.as_flattened().iter().enumerate().filter(at_plane) {
            known.entry(v).or_default().push(self.places[CornerId::new(corner)].uv);
        }
        for face in 0..self.triangles.len() {
            let corners = [0, 2, 1].map(|k| CornerId::new(3 * face + k));
            let [Some(a), Some(b), Some(c)] = corners.map(|corner| self.place(corner)) else { continue };
            let places = [a, b, c];
            let own = std::array::from_fn(|k| {
                let position = || self.points.push(self.baseline.position(places[k].location));
                *self.twin[self.triangles[face][corners[k].index() % 3]].get_or_insert_with(position)
            });
            self.triangles.push(own);
            for (place, v) in places.into_iter().zip(own) {
                self.places.push(BaselineUvPoint { uv: shared(known.entry(v).or_default(), place.uv), ..place });
            }
        }
        self.copy_edges();
        self
    }

    /// The place of a corner on the other side.
    fn place(&self, corner: CornerId) -> Option<BaselineUvPoint> {
        let BaselinePoint { face, weights } = self.places[corner].location;
        let mut location = BaselinePoint { face, weights };
        for k in 0..3 {
            let twin = self.baseline.mirror.corner(CornerId::new(3 * face.index() + k))?;
            location.face = self.baseline.topology.faces.face_of(twin);
            location.weights[twin.index() % 3] = weights[k];
        }
        Some(BaselineUvPoint { location, uv: self.baseline.uv(location) })
    }

    /// Adds the twins of the edges on chains.
    fn copy_edges(&mut self) {
        let chains = &self.baseline.chains;
        let pairs = chains.enumerated().flat_map(|(id, chain)| {
            chain.vertices.windows(2).enumerate().map(move |(segment, pair)| ([pair[0], pair[1]], (id, segment)))
        });
        let segments: FxHashMap<[VertexId; 2], (ChainId, usize)> = pairs.collect();
        let mut copies = Vec::new();
        for (id, edges) in self.edges.enumerated() {
            for &ChainEdge { start, length, ends } in edges {
                let [Some(a), Some(b)] = ends.map(|v| self.twin[v]) else { continue };
                if [a, b] == ends {
                    continue;
                }
                // The middle is inside a segment; the ends may be between two.
                let at = chains[id].at(start + 0.5 * length);
                let Some((other, middle, is_forward)) = self.twin_on_curve(&segments, id, at) else { continue };
                let chain = &chains[other];
                let start = middle - 0.5 * length;
                let start = if chain.is_loop { start.rem_euclid(chain.length()) } else { start.max(0.0) };
                copies.push((other, ChainEdge { start, length, ends: if is_forward { [a, b] } else { [b, a] } }));
            }
        }
        copies.into_iter().for_each(|(chain, edge)| self.edges[chain].push(edge));
    }

    /// The chain on the other side of a point of a chain, the arc length there, and whether both run the same way.
    fn twin_on_curve(
        &self,
        segments: &FxHashMap<[VertexId; 2], (ChainId, usize)>,
        chain: ChainId,
        at: CurvePoint,
    ) -> Option<(ChainId, f32, bool)> {
        let vertices = &self.baseline.chains[chain].vertices;
        let [a, b] = [at.segment, at.segment + 1].map(|i| self.baseline.mirror.vertex(vertices[i]));
        let (a, b) = (a?, b?);
        let (&(other, segment), t, is_forward) = match segments.get(&[a, b]) {
            Some(found) => (found, at.t, true),
            None => (segments.get(&[b, a])?, 1.0 - at.t, false),
        };
        let along = &self.baseline.chains[other].along;
        Some((other, along[segment] + t * (along[segment + 1] - along[segment]), is_forward))
    }
}

/// The UV among those of a vertex that differs from `uv` by rounding alone, or `uv`, which is added to them.
fn shared(known: &mut Vec<Vec2>, uv: Vec2) -> Vec2 {
    let least = ROUNDING * f32::EPSILON * uv.abs().max_element();
    let same = known.iter().copied().find(|other| other.abs_diff_eq(uv, least));
    same.unwrap_or_else(|| {
        known.push(uv);
        uv
    })
}
