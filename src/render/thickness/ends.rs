//! The ends of a fold and of its second layer.
//!
//! ```text
//!   border        v is the end of the fold: the border goes on without one. The two layers share it, so that the hem
//!   ==c--v-----   narrows to nothing between c and v, over the taper length. From v on, the layer ends along edges
//!     |  |        inside the surface, and lies on it up to
//!   --o--w         the next corner w of its faces, or over three times the amount.
//! ```

use crate::mesh::{Csr, EdgeId, FaceId, IdVec, Topology, VertexId};
use glam::Vec3;

/// Where a fold and its second layer end.
pub struct Ends {
    /// True for ends of the fold that both layers share.
    pub joined: IdVec<VertexId, bool>,
    /// True where the second layer ends on the surface.
    pub closed: IdVec<VertexId, bool>,
    /// Corners of the second layer, where it stops lying on the surface.
    pub corners: Vec<VertexId>,
}

impl Ends {
    fn none(t: &Topology) -> Self {
        let none = IdVec::filled(false, t.vertex_count());
        Self { joined: none.clone(), closed: none, corners: Vec::new() }
    }

    /// The ends of the layer behind the faces `chosen` of those `asked` for, with a fold along the edges `marked`.
    ///
    /// The layer is closed over `length` at least, from each end of the fold on. \[mesh units\]
    pub fn new(
        t: &Topology,
        points: &IdVec<VertexId, Vec3>,
        [asked, chosen]: [&IdVec<FaceId, bool>; 2],
        marked: &IdVec<EdgeId, bool>,
        length: f32,
    ) -> Self {
        let mut ends = Self::none(t);
        // A layer that other cloth cuts short stays open there: it has no room to turn.
        let is_asked = |e: EdgeId| t.edge_corners.row(e).iter().any(|&c| asked[t.faces.face_of(c)]);
        let (folds, open) = (touched(t, |e| marked[e]), touched(t, |e| t.is_border(e) && !is_asked(e)));
        ends.joined = folds.iter().zip(open.iter()).map(|(fold, open)| *fold && *open).collect();
        let layer_ends = edges_at(t, |edge| !t.is_border(edge) && is_layer_end(t, chosen, edge));
        let joined: Vec<VertexId> = ends.joined.ids().filter(|&v| ends.joined[v]).collect();
        for end in joined {
            for &edge in layer_ends.row(end) {
                ends.close(t, points, (chosen, &layer_ends), (end, edge), length);
            }
        }
        ends.separate(t, chosen);
        ends
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
