//! Corridors: the vertices and edges of the simulation mesh beside a curve, on the same part of the surface.

use super::guide::Guide;
use super::polyline::PolylinePoint;
use super::vertex_locator::VertexLocator;
use crate::sim::half_edge;
use glam::Vec3;
use std::collections::VecDeque;
use tailor_mesh::connectivity::{CornerId, FaceId, Id, IdVec, VertexId};

/// Triangles of the baseline that the search for a corridor visits at most, and those besides for each segment of the curve.
/// Targets much longer than the edges of the baseline would have each corridor hold all of it.
const MAX_VISITED: usize = 4096;
const MAX_VISITED_PER_SEGMENT: usize = 64;

/// The part of the simulation mesh beside a curve; vertices go by their index in it.
pub(super) struct Corridor {
    /// Length of the curve. \[mesh units\]
    pub length: f32,
    /// Whether the curve is closed.
    pub is_closed: bool,
    /// Ascending by vertex.
    pub vertices: Vec<CorridorVertex>,
    /// Offset of each vertex's edges, and one past the last.
    offsets: Vec<usize>,
    edges: Vec<CorridorEdge>,
}

/// A vertex beside a curve.
pub(super) struct CorridorVertex {
    pub vertex: VertexId,
    /// The nearest point of the curve.
    pub nearest: PolylinePoint,
    /// Distance from the curve, in target lengths.
    pub off: f32,
}

/// An edge that leaves a vertex beside a curve.
pub(super) struct CorridorEdge {
    /// The other end.
    pub to: u32,
    /// Squared mean distance of its ends from the curve, in target lengths.
    pub off: f32,
    /// \[mesh units\]
    pub length: f64,
}

impl Corridor {
    /// The corridor of at most `reach` target lengths on either side of a guide.
    pub fn new(locator: &VertexLocator<'_>, guide: &Guide, reach: f32, scratch: &mut CorridorScratch) -> Self {
        let (product, t) = (locator.product, locator.topology);
        let vertex = |(vertex, nearest): (VertexId, PolylinePoint)| CorridorVertex {
            vertex,
            nearest,
            off: nearest.distance / product.target[vertex],
        };
        let near = scratch.vertices_beside(locator, guide, reach);
        let mut vertices: Vec<CorridorVertex> = near.into_iter().map(vertex).collect();
        vertices.sort_unstable_by_key(|v| v.vertex);
        vertices.iter().enumerate().for_each(|(i, v)| scratch.vertices.set(v.vertex, i as u32));
        let is_inside = |c: &CornerId| scratch.faces.get(product.places[*c].location.face) == Some(true);
        let edge = |a: &CorridorVertex, to: u32| {
            let b = &vertices[to as usize];
            let off = 0.5 * (a.off + b.off);
            let length = f64::from(product.points[a.vertex].distance(product.points[b.vertex]));
            CorridorEdge { to, off: off * off, length }
        };
        let (mut offsets, mut edges) = (vec![0], Vec::<CorridorEdge>::with_capacity(6 * vertices.len()));
        for from in &vertices {
            let own = edges.len();
            for &corner in t.vertex_corners.row(from.vertex).iter().filter(|c| is_inside(c)) {
                let around = [t.faces.next(corner), t.faces.prev(corner)].into_iter().filter(is_inside);
                for to in around.filter_map(|c| scratch.vertices.get(t.faces.vertex(c))) {
                    if edges[own..].iter().all(|e| e.to != to) {
                        edges.push(edge(from, to));
                    }
                }
            }
            offsets.push(edges.len());
        }
        Self { length: guide.curve.length, is_closed: guide.curve.is_closed, vertices, offsets, edges }
    }

    /// The index of a vertex.
    pub fn index(&self, vertex: VertexId) -> Option<usize> {
        self.vertices.binary_search_by_key(&vertex, |v| v.vertex).ok()
    }

    /// The edges that leave a vertex.
    pub fn edges_of(&self, vertex: usize) -> &[CorridorEdge] {
        &self.edges[self.offsets[vertex]..self.offsets[vertex + 1]]
    }
}

/// A map by ids that is cleared in constant time.
struct EpochMap<I, T> {
    values: IdVec<I, (u32, T)>,
    epoch: u32,
}

impl<I: Id, T: Copy> EpochMap<I, T> {
    fn new(count: usize, filler: T) -> Self {
        Self { values: IdVec::filled((0, filler), count), epoch: 0 }
    }

    fn get(&self, id: I) -> Option<T> {
        let (epoch, value) = self.values[id];
        (epoch == self.epoch).then_some(value)
    }

    fn set(&mut self, id: I, value: T) {
        self.values[id] = (self.epoch, value);
    }
}

/// Buffers that corridors reuse: hash maps in their place take a fifth of all transfer.
pub(super) struct CorridorScratch {
    /// Triangles of the baseline that the search reached, and whether they are in the corridor.
    faces: EpochMap<FaceId, bool>,
    /// The index of each vertex of the simulation mesh.
    vertices: EpochMap<VertexId, u32>,
    /// Each triangle with the segment where the search for its nearest point starts.
    queue: VecDeque<(FaceId, usize)>,
    /// Number of triangles and vertices that all searches visited.
    pub visited: usize,
}

impl CorridorScratch {
    pub fn new(locator: &VertexLocator<'_>) -> Self {
        let faces = EpochMap::new(locator.product.baseline.topology.faces.len(), false);
        Self { faces, vertices: EpochMap::new(locator.product.points.len(), 0), queue: VecDeque::new(), visited: 0 }
    }

    fn enqueue(&mut self, face: FaceId, segment: usize) {
        if self.faces.get(face).is_none() {
            self.faces.set(face, false);
            self.queue.push_back((face, segment));
        }
    }

    /// Marks the triangles of the baseline within `reach` target lengths of a curve, by a search from its edges.
    /// Returns the vertices of the simulation mesh in these triangles within that distance. Those that are farther from the
    /// curve by edges come later, and are left out beyond the bound.
    fn vertices_beside(
        &mut self,
        locator: &VertexLocator<'_>,
        guide: &Guide,
        reach: f32,
    ) -> Vec<(VertexId, PolylinePoint)> {
        let product = locator.product;
        let base = &product.baseline;
        let t = &base.topology;
        self.faces.epoch += 1;
        self.vertices.epoch += 1;
        for (segment, pair) in guide.vertices.windows(2).enumerate() {
            let halves = [half_edge(t, pair[0], pair[1]), half_edge(t, pair[1], pair[0])].into_iter().flatten();
            halves.for_each(|c| self.enqueue(t.faces.face_of(c), segment));
        }
        let mut found: Vec<(VertexId, PolylinePoint)> = Vec::new();
        let most = self.visited + MAX_VISITED + MAX_VISITED_PER_SEGMENT * guide.vertices.len();
        while let Some((face, start)) = self.queue.pop_front() {
            self.visited += 1;
            if self.visited > most {
                self.queue.clear();
                break;
            }
            let corners = base.triangle(face);
            let centroid = corners.iter().sum::<Vec3>() / 3.0;
            let radius = corners.iter().map(|p| p.distance(centroid)).fold(0.0, f32::max);
            let target = t.faces.vertices_of(face).iter().map(|&v| base.target[v]).fold(0.0, f32::max);
            let of_face = guide.curve.nearest(centroid, start);
            if of_face.distance > reach * target + radius {
                continue;
            }
            self.faces.set(face, true);
            for &vertex in locator.in_face.row(face) {
                let nearest = guide.curve.nearest(product.points[vertex], of_face.segment);
                if nearest.distance > reach * product.target[vertex] {
                    continue;
                }
                let index = self.vertices.get(vertex).unwrap_or(found.len() as u32);
                self.vertices.set(vertex, index);
                match found.get_mut(index as usize) {
                    Some(best) if nearest.distance < best.1.distance => best.1 = nearest,
                    Some(_) => {}
                    None => found.push((vertex, nearest)),
                }
            }
            let twins = t.faces.corners_of(face).filter_map(|c| base.open_twin(c));
            twins.for_each(|twin| self.enqueue(t.faces.face_of(twin), of_face.segment));
        }
        self.visited += found.len();
        found
    }
}
