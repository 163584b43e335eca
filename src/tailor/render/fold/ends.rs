//! The ends of a fold and of its second layer.
//!
//! ```text
//!   border        v is the end of the fold: the border goes on without one. The two layers share it, so that the hem
//!   ==c--v-----   narrows to nothing between c and v, over the taper length. From v on, the layer ends along edges
//!     |  |        inside the surface, and lies on it up to
//!   --o--w         the next corner w of its faces, or over three times the thickness.
//! ```
//!
//! Where a crease or an edge set marks the edges from v on, the end is *square*: the fold keeps its height up to v, and a
//! wall along these edges closes the layer.

use crate::contact::NearestSearch;
use glam::Vec3;
use tailor_mesh::connectivity::{Csr, EdgeId, FaceId, IdVec, Topology, VertexId};
use tailor_mesh::garment::{Elements, Mesh};
use tailor_mesh::subdivide::Level;

/// Where a fold and its second layer end.
pub struct Ends {
    /// True for ends of the fold that both layers share.
    pub joined: IdVec<VertexId, bool>,
    /// True where the second layer ends on the surface.
    pub closed: IdVec<VertexId, bool>,
    /// Corners of the second layer, where it stops lying on the surface.
    pub corners: Vec<VertexId>,
    /// True for square ends of the fold.
    pub square: IdVec<VertexId, bool>,
    /// The edges with a wall, from square ends on.
    pub walls: Vec<EdgeId>,
}

impl Ends {
    fn none(t: &Topology) -> Self {
        let none = IdVec::filled(false, t.vertex_count());
        Self { joined: none.clone(), closed: none.clone(), corners: Vec::new(), square: none, walls: Vec::new() }
    }

    /// The ends of the layer behind the faces `chosen`, with a fold along the edges `marked`. Ends along `square` edges are
    /// square.
    ///
    /// The layer is closed over `length` at least, from each other end of the fold on. \[mesh units\]
    pub fn new(
        t: &Topology,
        points: &IdVec<VertexId, Vec3>,
        chosen: &IdVec<FaceId, bool>,
        [marked, square]: [&IdVec<EdgeId, bool>; 2],
        length: f32,
    ) -> Self {
        let mut ends = Self::none(t);
        let (folds, open) = (touched(t, |e| marked[e]), touched(t, |e| t.is_border(e) && !marked[e]));
        ends.joined = folds.iter().zip(open.iter()).map(|(fold, open)| *fold && *open).collect();
        let layer_ends = edges_at(t, |edge| !t.is_border(edge) && is_layer_end(t, chosen, edge));
        let joined: Vec<VertexId> = ends.joined.ids().filter(|&v| ends.joined[v]).collect();
        for &end in &joined {
            if let &[edge] = layer_ends.row(end)
                && square[edge]
            {
                (ends.joined[end], ends.square[end]) = (false, true);
            }
        }
        for end in joined {
            for &edge in layer_ends.row(end) {
                if ends.square[end] {
                    ends.wall(t, (chosen, &layer_ends), square, (end, edge));
                } else {
                    ends.close(t, points, (chosen, &layer_ends), (end, edge), length);
                }
            }
        }
        ends.separate(t, chosen);
        ends.walls.sort_unstable();
        ends.walls.dedup();
        ends
    }

    /// The share of the thickness at a point that is the average of some vertices: less than 1 within `length` of a joined end.
    ///
    /// A fold whose edges are longer has a line there instead; one that a seam runs into has shorter edges.
    pub fn tapers(&self, points: &IdVec<VertexId, Vec3>, length: f32) -> impl Fn(&[(VertexId, f32)]) -> f32 {
        let at: Vec<Vec3> = self.joined.ids().filter(|&v| self.joined[v]).map(|v| points[v]).collect();
        let search = NearestSearch::of_points(&at);
        move |sources| {
            let point: Vec3 = sources.iter().map(|&(v, w)| w * points[v]).sum();
            let nearest = search.nearest(point, |end, point| at[end].as_dvec3().distance_squared(point));
            nearest.map_or(1.0, |end| (at[end].distance(point) / length).min(1.0))
        }
    }

    /// Adds the wall from a square end of the fold to the next corner of the layer, or as far as the edges are `square`.
    fn wall(
        &mut self,
        t: &Topology,
        (chosen, layer_ends): (&IdVec<FaceId, bool>, &Csr<VertexId, EdgeId>),
        square: &IdVec<EdgeId, bool>,
        (mut at, mut edge): (VertexId, EdgeId),
    ) {
        let start = at;
        loop {
            self.walls.push(edge);
            let [a, b] = t.edges[edge];
            at = if a == at { b } else { a };
            if at == start || self.square[at] {
                return;
            }
            if t.faces_at(at).filter(|&f| chosen[f]).count() == 1 {
                return self.corners.push(at);
            }
            match *layer_ends.row(at) {
                [x, y] if square[if x == edge { y } else { x }] => edge = if x == edge { y } else { x },
                _ => return,
            }
        }
    }

    /// Closes the layer along its end, from the end of a fold to the next corner, or over a length.
    fn close(
        &mut self,
        t: &Topology,
        points: &IdVec<VertexId, Vec3>,
        (chosen, layer_ends): (&IdVec<FaceId, bool>, &Csr<VertexId, EdgeId>),
        (mut at, mut edge): (VertexId, EdgeId),
        mut length: f32,
    ) {
        self.closed[at] = true;
        loop {
            let [a, b] = t.edges[edge];
            length -= points[a].distance(points[b]);
            at = if a == at { b } else { a };
            let is_known = std::mem::replace(&mut self.closed[at], true);
            if self.joined[at] || is_known {
                return;
            }
            if t.faces_at(at).filter(|&f| chosen[f]).count() == 1 {
                return self.corners.push(at);
            }
            match *layer_ends.row(at) {
                [x, y] if length > 0.0 => edge = if x == edge { y } else { x },
                _ => return,
            }
        }
    }

    /// Parts the layers at ends that an edge of the layer joins: it would have the faces of both.
    fn separate(&mut self, t: &Topology, chosen: &IdVec<FaceId, bool>) {
        let both: Vec<[VertexId; 2]> = t
            .edges
            .enumerated()
            .filter(|(edge, ends)| {
                let is_covered = || t.edge_corners.row(*edge).iter().any(|&c| chosen[t.faces.face_of(c)]);
                !t.is_border(*edge) && ends.iter().all(|&v| self.joined[v]) && is_covered()
            })
            .map(|(_, ends)| *ends)
            .collect();
        both.into_iter().flatten().for_each(|v| self.joined[v] = false);
    }
}

/// True for edges along which a hem ends square: creases, and edges of sets that do not lead on beyond the layer. A set that
/// does is a seam that runs into the end.
pub fn square_edges(garment: &Mesh, level: &Level, chosen: &IdVec<FaceId, bool>) -> IdVec<EdgeId, bool> {
    let t = &level.topology;
    let mut square: IdVec<EdgeId, bool> = level.edge_sharpness.iter().map(|&sharpness| sharpness > 0.0).collect();
    let at_layer = touched(t, |edge| t.edge_corners.row(edge).iter().any(|&c| chosen[t.faces.face_of(c)]));
    for set in garment.subsets.iter() {
        let Elements::Edges(edges) = &set.elements else { continue };
        if edges.iter().flatten().all(|&v| at_layer[v]) {
            edges.iter().filter_map(|&[a, b]| t.find_edge(a, b)).for_each(|edge| square[edge] = true);
        }
    }
    square
}

/// True for edges between a face with a second layer and one without.
fn is_layer_end(t: &Topology, chosen: &IdVec<FaceId, bool>, edge: EdgeId) -> bool {
    let faces = t.edge_corners.row(edge).iter().map(|&c| chosen[t.faces.face_of(c)]);
    let (with, without) =
        faces.fold((0, 0), |(with, without), is| if is { (with + 1, without) } else { (with, without + 1) });
    with == 1 && without > 0
}

/// The edges at each vertex that are `wanted`.
fn edges_at(t: &Topology, wanted: impl Fn(EdgeId) -> bool) -> Csr<VertexId, EdgeId> {
    let edges: Vec<EdgeId> = t.edges.ids().filter(|&edge| wanted(edge)).collect();
    let ends = edges.iter().flat_map(|&edge| t.edges[edge].map(|v| (v, edge)));
    Csr::group(t.vertex_count(), ends, EdgeId::new(0))
}

/// True for vertices of edges that are `wanted`.
fn touched(t: &Topology, wanted: impl Fn(EdgeId) -> bool) -> IdVec<VertexId, bool> {
    let mut touched = IdVec::filled(false, t.vertex_count());
    t.edges.ids().filter(|&edge| wanted(edge)).for_each(|edge| t.edges[edge].iter().for_each(|&v| touched[v] = true));
    touched
}
