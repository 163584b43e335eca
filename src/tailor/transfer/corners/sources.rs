//! The location on its shell from which each corner takes its value.

use super::cuts::{ChannelCuts, ShellSeeds, components};
use crate::sim::BaselinePoint;
use glam::Vec3;
use rayon::prelude::*;
use tailor_mesh::connectivity::{CornerId, FaceId, IdVec, VertexId};

/// Distance from its shell above which a corner counts as moved, in target lengths.
const MOVED: f32 = 1e-3;
/// Largest weight of an extrapolation: slivers would throw values far away.
const MAX_WEIGHT: f32 = 16.0;

/// The source of a corner's value.
#[derive(Clone, Copy, Debug)]
pub(super) struct CornerSource {
    /// A location on the corner's shell; its weights may extrapolate beyond the triangle.
    pub location: BaselinePoint,
    /// Whether the vertex itself is off the shell.
    pub moved: bool,
}

impl ChannelCuts<'_> {
    /// Updates the sources of all corners around some triangles. Returns these corners.
    pub fn update_sources(
        &self,
        faces: impl Iterator<Item = FaceId>,
        seeds: &ShellSeeds,
        sources: &mut IdVec<CornerId, CornerSource>,
    ) -> Vec<CornerId> {
        let t = &self.map.mesh.topology;
        let mut vertices: Vec<VertexId> = faces.flat_map(|f| t.faces.vertices_of(f)).copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        let found: Vec<_> = vertices.par_iter().flat_map_iter(|&v| self.sources_at(v, seeds)).collect();
        found.iter().for_each(|&(corner, source)| sources[corner] = source);
        found.into_iter().map(|(corner, _)| corner).collect()
    }

    /// The sources of a vertex's corners. The moved corners on one shell have the source closest to the vertex.
    fn sources_at(&self, vertex: VertexId, seeds: &ShellSeeds) -> Vec<(CornerId, CornerSource)> {
        let (product, t) = (self.map.product, &self.map.mesh.topology);
        let corners = t.vertex_corners.row(vertex).iter();
        let mut sources: Vec<_> = corners.map(|&c| (c, self.source(c, seeds))).collect();
        if !sources.iter().any(|s| s.1.moved) {
            return sources;
        }
        let own = sources.clone();
        let face = |i: usize| t.faces.face_of(own[i].0);
        let shell = components(own.len(), |i, j| self.are_joined(face(i), face(j), seeds));
        let point = product.points[vertex];
        let distance = |i: usize| product.baseline.position(own[i].1.location).distance_squared(point);
        for (i, (_, source)) in sources.iter_mut().enumerate().filter(|(_, s)| s.1.moved) {
            let members = (0..own.len()).filter(|&k| shell[k] == shell[i]);
            let closest = members.min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
            *source = own[closest.expect("a corner is on its own shell")].1;
        }
        sources
    }

    /// The source of a corner by its own triangle: in place, or the closest location on the triangle's shell.
    fn source(&self, corner: CornerId, seeds: &ShellSeeds) -> CornerSource {
        let product = self.map.product;
        let (base, location) = (&product.baseline, product.places[corner].location);
        let source = |face: FaceId| base.source_face[face];
        let seed = seeds[FaceId::new(corner.index() / 3)];
        let Some(seed) = seed.filter(|&seed| !self.are_neighbours(source(location.face), source(seed))) else {
            return CornerSource { location, moved: false };
        };
        let vertex = self.map.mesh.topology.faces.vertex(corner);
        let there = base.closest_within(seed, product.points[vertex], &self.barrier);
        let moved = there.distance_squared.sqrt() > MOVED * product.target[vertex];
        CornerSource { location: there.location, moved }
    }

    /// The location of a corner's vertex in the plane of the triangle of `from`, outside of the triangle; `from` where
    /// the triangle is a sliver.
    pub fn extrapolated(&self, corner: CornerId, from: BaselinePoint) -> BaselinePoint {
        let [a, b, c] = self.map.product.baseline.triangle(from.face);
        let (u, v, p) = (b - a, c - a, self.map.position(corner) - a);
        let normal = u.cross(v);
        let n = normal.length_squared();
        let (s, t) = (p.cross(v).dot(normal) / n, u.cross(p).dot(normal) / n);
        let weights = Vec3::new(1.0 - s - t, s, t);
        if !weights.is_finite() || weights.abs().max_element() > MAX_WEIGHT {
            return from;
        }
        BaselinePoint { face: from.face, weights }
    }
}
