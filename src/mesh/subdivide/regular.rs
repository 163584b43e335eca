//! The smooth Catmull-Clark masks of an all-quad level, read directly from the values of each quad.
//!
//! The weights equal those of `masks`. Most rows of a refined mesh are of this kind, and this path skips
//! the walk around each face.

use super::level::Level;
use crate::connectivity::{CornerId, EdgeId, FaceId, Id, IdVec, VertexId};
use crate::garment::Scheme;

/// The values of each quad's corners: vertices or face-varying values.
#[derive(Clone, Copy)]
pub struct Quads<'a, T> {
    level: &'a Level,
    quads: &'a [[T; 4]],
}

impl<'a, T: Id> Quads<'a, T> {
    /// The quads of a level; `None` unless it is an all-quad Catmull-Clark level.
    pub fn new(level: &'a Level, corners: &'a IdVec<CornerId, T>) -> Option<Self> {
        let is_regular = level.scheme == Scheme::CatmullClark && level.topology.faces.regular_valence() == Some(4);
        is_regular.then(|| Self { level, quads: corners.as_slice().as_chunks().0 })
    }

    /// The values of a corner's quad, starting at that corner.
    #[inline(always)]
    fn from(&self, corner: CornerId) -> [T; 4] {
        let (quad, k) = (&self.quads[corner.index() / 4], corner.index());
        [quad[k & 3], quad[(k + 1) & 3], quad[(k + 2) & 3], quad[(k + 3) & 3]]
    }

    /// Emits the mask of a face's centre.
    #[inline(always)]
    pub fn face(&self, face: FaceId, sink: &mut impl FnMut(T, f32)) {
        self.quads[face.index()].iter().for_each(|&value| sink(value, 0.25));
    }

    /// Emits the mask of an edge's child; `false` without output if the edge is sharp or lacks two faces.
    #[inline(always)]
    pub fn edge(&self, edge: EdgeId, sink: &mut impl FnMut(T, f32)) -> bool {
        let &[a, b] = self.level.topology.edge_corners.row(edge) else { return false };
        if self.level.edge_sharpness[edge] > 0.0 {
            return false;
        }
        let ([start, end, c, d], [_, _, e, f]) = (self.from(a), self.from(b));
        sink(start, 0.375);
        sink(end, 0.375);
        [c, d, e, f].into_iter().for_each(|value| sink(value, 0.0625));
        true
    }

    /// Emits the mask of a vertex's child; `false` without output if the vertex is sharp or has no face.
    #[inline(always)]
    pub fn vertex(&self, vertex: VertexId, sink: &mut impl FnMut(T, f32)) -> bool {
        let corners = self.level.topology.vertex_corners.row(vertex);
        let (Some(&first), true) = (corners.first(), self.level.rules[vertex].is_smooth()) else { return false };
        let valence = corners.len() as f32;
        let ring = 1.0 / (valence * valence);
        sink(self.from(first)[0], (valence - 1.75) / valence);
        for &corner in corners {
            let [_, next, opposite, _] = self.from(corner);
            sink(next, 1.5 * ring);
            sink(opposite, 0.25 * ring);
        }
        true
    }
}
