//! The vertices of the simulation mesh that sets of the garment hold.
//!
//! Points of the cage stand for the curves and areas that they span: an edge with both ends, a face with all corners. The
//! curves and areas are found on the baseline, and a vertex is held where it lies near one of them along the surface, so
//! that holds have no gaps at any target length, and do not reach another layer.

use super::ClothOptions;
use glam::Vec3;
use tailor::sim::{Baseline, SimProduct, distance_to_segment};
use tailor_mesh::connectivity::{CornerId, FaceId, IdVec, VertexId};
use tailor_mesh::garment::{Elements, Mesh};

/// Distance from a curve or an area up to which a vertex is held. \[target lengths\]
const REACH: f32 = 0.5;

/// The vertices of the simulation mesh `mesh` that are held, ascending.
pub fn pins(options: &ClothOptions, garment: &Mesh, product: &SimProduct, mesh: &Mesh) -> Vec<VertexId> {
    let mut held = Vec::new();
    for name in &options.pins {
        match mesh.subset(name).map(|set| &set.elements) {
            // Points that span nothing hold the vertices nearest to them.
            Some(Elements::Points(points)) => held.extend(points),
            Some(Elements::Edges(edges)) => held.extend(edges.as_flattened()),
            _ => {}
        }
        if let Some(Elements::Points(points)) = garment.subset(name).map(|set| &set.elements) {
            held.extend(Span::of(&product.baseline, points).near(product));
        }
    }
    held.sort_unstable();
    held.dedup();
    held
}

/// The pinned part of a triangle of the baseline.
#[derive(Clone, Copy, Default)]
struct Part {
    is_whole: bool,
    /// Each edge, from its corner to the next.
    edges: [bool; 3],
    corners: [bool; 3],
}

/// The curves and areas that points of the garment span on the baseline.
struct Span<'a> {
    baseline: &'a Baseline,
    parts: IdVec<FaceId, Part>,
}

impl<'a> Span<'a> {
    fn of(baseline: &'a Baseline, points: &[VertexId]) -> Self {
        let marked = baseline.spanned(points);
        let finest = baseline.levels.last().unwrap_or(&baseline.manifold.level);
        let part = |face: FaceId| {
            let corners = [0, 1, 2].map(|k| baseline.level_corner[CornerId::new(3 * face.index() + k)]);
            let faces = &finest.topology.faces;
            let is_marked = corners.map(|corner| marked[faces.vertex(corner)]);
            // A diagonal of a face is not a curve of the garment.
            let is_edge = |k: usize| faces.next(corners[k]) == corners[(k + 1) % 3];
            Part {
                is_whole: faces.vertices_of(baseline.level_face[face]).iter().all(|&v| marked[v]),
                edges: [0, 1, 2].map(|k| is_edge(k) && is_marked[k] && is_marked[(k + 1) % 3]),
                corners: is_marked,
            }
        };
        Self { baseline, parts: baseline.level_face.ids().map(part).collect() }
    }

    /// The vertices of the simulation mesh that are near.
    fn near(&self, product: &SimProduct) -> Vec<VertexId> {
        let mut search = Search { span: self, seen: IdVec::filled(0, self.parts.len()), round: 0, found: Vec::new() };
        let mut held = IdVec::<VertexId, bool>::filled(false, product.points.len());
        let mut last = IdVec::<VertexId, Option<FaceId>>::filled(None, product.points.len());
        for (corner, &vertex) in product.triangles.as_flattened().iter().enumerate() {
            let start = product.places[CornerId::new(corner)].location.face;
            if !held[vertex] && last[vertex].replace(start) != Some(start) {
                held[vertex] = search.finds(start, product.points[vertex], REACH * product.target[vertex]);
            }
        }
        held.enumerated().filter(|(_, held)| **held).map(|(vertex, _)| vertex).collect()
    }

    /// Whether the pinned part of a triangle is within `reach` of a point.
    fn is_pinned_within(&self, face: FaceId, point: Vec3, reach: f32) -> bool {
        let Part { is_whole, edges, corners } = self.parts[face];
        let triangle = self.baseline.triangle(face);
        let is_edge_near = |k: usize| distance_to_segment(point, triangle[k], triangle[(k + 1) % 3]) <= reach;
        is_whole && self.is_triangle_within(face, point, reach)
            || (0..3).any(|k| edges[k] && is_edge_near(k))
            || (0..3).any(|k| corners[k] && triangle[k].distance(point) <= reach)
    }

    /// Whether a triangle is within `reach` of a point.
    fn is_triangle_within(&self, face: FaceId, point: Vec3, reach: f32) -> bool {
        self.baseline.on_triangle(face, point).distance_squared <= reach * reach
    }
}

/// Walks over the triangles around a point.
struct Search<'a> {
    span: &'a Span<'a>,
    /// The round in which each triangle was found last.
    seen: IdVec<FaceId, u32>,
    round: u32,
    found: Vec<FaceId>,
}

impl Search<'_> {
    /// Whether anything pinned is within `reach` of a point, over triangles that are connected there to `start`.
    fn finds(&mut self, start: FaceId, point: Vec3, reach: f32) -> bool {
        let Span { baseline, .. } = *self.span;
        self.round += 1;
        self.found.clear();
        self.add(start);
        let mut at = 0;
        while let Some(&face) = self.found.get(at) {
            at += 1;
            if self.span.is_pinned_within(face, point, reach) {
                return true;
            }
            for corner in baseline.topology.faces.corners_of(face) {
                let Some(twin) = baseline.topology.twin(corner) else { continue };
                let next = baseline.topology.faces.face_of(twin);
                if self.seen[next] != self.round && self.span.is_triangle_within(next, point, reach) {
                    self.add(next);
                }
            }
        }
        false
    }

    fn add(&mut self, face: FaceId) {
        self.seen[face] = self.round;
        self.found.push(face);
    }
}
