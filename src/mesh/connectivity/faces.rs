//! The faces of a mesh as loops of vertices.
//!
//! Corners of all faces form one array. Pure triangle and quad meshes store nothing else; their index arithmetic keeps
//! the subdivision loops fast.

use super::{CornerId, FaceId, IdVec, VertexId};
use std::ops::Range;
use std::sync::Arc;

/// The faces of a mesh, each a loop of corners. Corners are numbered face by face.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Faces {
    /// Shared between clones.
    corners: Arc<IdVec<CornerId, VertexId>>,
    layout: Layout,
}

/// The grouping of corners into faces.
#[derive(Clone, Debug, Default, PartialEq)]
enum Layout {
    /// Every face has three corners; nothing is stored.
    Triangles,
    /// Every face has four corners; nothing is stored.
    #[default]
    Quads,
    /// Faces of any valence: the first corner of each face (and the end), and the face of each corner.
    Mixed { offsets: Vec<u32>, corner_face: IdVec<CornerId, FaceId> },
}

impl Faces {
    /// Triangles from three corners each.
    pub fn triangles(corners: impl Into<IdVec<CornerId, VertexId>>) -> Self {
        let corners = corners.into();
        assert!(corners.len().is_multiple_of(3), "whole triangles");
        Self { corners: Arc::new(corners), layout: Layout::Triangles }
    }

    /// Quads from four corners each.
    pub fn quads(corners: impl Into<IdVec<CornerId, VertexId>>) -> Self {
        let corners = corners.into();
        assert!(corners.len().is_multiple_of(4), "whole quads");
        Self { corners: Arc::new(corners), layout: Layout::Quads }
    }

    /// Faces of `counts` corners each. The counts must sum to the number of corners.
    pub fn mixed(counts: impl IntoIterator<Item = usize>, corners: impl Into<IdVec<CornerId, VertexId>>) -> Self {
        let corners = corners.into();
        let mut offsets = vec![0u32];
        let mut corner_face = IdVec::new();
        for (face, count) in counts.into_iter().enumerate() {
            corner_face.extend(std::iter::repeat_n(FaceId::new(face), count));
            offsets.push(corner_face.len() as u32);
        }
        assert_eq!(corner_face.len(), corners.len(), "face counts sum to the number of corners");
        let all = |n: u32| offsets.windows(2).all(|w| w[1] - w[0] == n);
        match offsets.get(1) {
            Some(3) if all(3) => Self::triangles(corners),
            Some(4) if all(4) => Self::quads(corners),
            _ => Self { corners: Arc::new(corners), layout: Layout::Mixed { offsets, corner_face } },
        }
    }

    /// Number of faces.
    pub fn len(&self) -> usize {
        match &self.layout {
            Layout::Triangles => self.corners.len() / 3,
            Layout::Quads => self.corners.len() / 4,
            Layout::Mixed { offsets, .. } => offsets.len() - 1,
        }
    }

    /// `true` if there is no face.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All faces.
    pub fn ids(&self) -> impl DoubleEndedIterator<Item = FaceId> + ExactSizeIterator + use<> {
        (0..self.len()).map(FaceId::new)
    }

    /// 3 for a triangle mesh, 4 for a quad mesh, `None` otherwise.
    pub fn regular_valence(&self) -> Option<usize> {
        match self.layout {
            Layout::Triangles => Some(3),
            Layout::Quads => Some(4),
            Layout::Mixed { .. } => None,
        }
    }

    /// The vertex of each corner.
    pub fn corners(&self) -> &IdVec<CornerId, VertexId> {
        &self.corners
    }

    /// The corner indices of a face.
    #[inline(always)]
    pub fn range(&self, face: FaceId) -> Range<usize> {
        match &self.layout {
            Layout::Triangles => face.index() * 3..face.index() * 3 + 3,
            Layout::Quads => face.index() * 4..face.index() * 4 + 4,
            Layout::Mixed { offsets, .. } => offsets[face.index()] as usize..offsets[face.index() + 1] as usize,
        }
    }

    /// The corners of a face, in order.
    #[inline(always)]
    pub fn corners_of(&self, face: FaceId) -> impl ExactSizeIterator<Item = CornerId> + Clone + use<> {
        self.range(face).map(CornerId::new)
    }

    /// The faces as fans of triangles, face by face.
    pub fn fans(&self) -> impl Iterator<Item = [VertexId; 3]> + '_ {
        let fan = |face| {
            let vertices = self.vertices_of(face);
            vertices[1..].windows(2).map(move |pair| [vertices[0], pair[0], pair[1]])
        };
        self.ids().flat_map(fan)
    }

    /// The vertices of a face, in order.
    #[inline(always)]
    pub fn vertices_of(&self, face: FaceId) -> &[VertexId] {
        &self.corners.as_slice()[self.range(face)]
    }

    /// Number of corners of a face.
    #[inline(always)]
    pub fn valence(&self, face: FaceId) -> usize {
        self.range(face).len()
    }

    /// The face that a corner belongs to.
    #[inline(always)]
    pub fn face_of(&self, corner: CornerId) -> FaceId {
        match &self.layout {
            Layout::Triangles => FaceId::new(corner.index() / 3),
            Layout::Quads => FaceId::new(corner.index() / 4),
            Layout::Mixed { corner_face, .. } => corner_face[corner],
        }
    }

    /// The vertex of a corner.
    #[inline(always)]
    pub fn vertex(&self, corner: CornerId) -> VertexId {
        self.corners[corner]
    }

    /// The corner `steps` further around the face; `steps` is at most the valence.
    #[inline(always)]
    pub fn ahead(&self, corner: CornerId, steps: usize) -> CornerId {
        let at = corner.index();
        match &self.layout {
            Layout::Quads => CornerId::new(at & !3 | (at + steps) & 3),
            _ => {
                let range = self.range(self.face_of(corner));
                let to = at + steps;
                CornerId::new(if to >= range.end { to - range.len() } else { to })
            }
        }
    }

    /// The next corner around the face.
    #[inline(always)]
    pub fn next(&self, corner: CornerId) -> CornerId {
        self.ahead(corner, 1)
    }

    /// The previous corner around the face.
    #[inline(always)]
    pub fn prev(&self, corner: CornerId) -> CornerId {
        match &self.layout {
            Layout::Quads => self.ahead(corner, 3),
            Layout::Triangles => self.ahead(corner, 2),
            Layout::Mixed { .. } => self.ahead(corner, self.valence(self.face_of(corner)) - 1),
        }
    }

    /// The vertices at the start and end of the half-edge that leaves `corner`.
    #[inline(always)]
    pub fn half_edge(&self, corner: CornerId) -> [VertexId; 2] {
        [self.vertex(corner), self.vertex(self.next(corner))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mixed_faces_walk_around() {
        let corners: Vec<_> = [0, 1, 2, 3, 2, 1, 4].map(VertexId::new).to_vec();
        let faces = Faces::mixed([4, 3], corners);
        assert_eq!(faces.len(), 2);
        assert_eq!(faces.regular_valence(), None);
        for corner in faces.corners().ids() {
            assert_eq!(faces.prev(faces.next(corner)), corner);
            assert_eq!(faces.face_of(faces.next(corner)), faces.face_of(corner));
        }
        assert_eq!(faces.next(CornerId::new(3)), CornerId::new(0));
        assert_eq!(faces.vertices_of(FaceId::new(1)).len(), 3);
    }
}
