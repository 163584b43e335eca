//! UV shells too small for triangles of the target length: their borders constrain nothing.

use super::lengths::Lengths;
use super::manifold::Manifold;
use glam::Vec3;
use std::collections::BTreeSet;
use tailor_mesh::connectivity::{EdgeId, FaceId, Groups, IdVec};
use tailor_mesh::garment::Mesh;
use tailor_mesh::subdivide::Channel;

/// The area of the equilateral triangle with sides of length 1.
const EQUILATERAL: f32 = 0.433_012_7;

/// The small UV shells of a cage.
#[derive(Default)]
pub struct SmallShells {
    /// The shell of each face, by its first face; empty if no shell is small.
    pub shell_of: IdVec<FaceId, FaceId>,
    /// Whether each shell is small, by its first face.
    is_small: IdVec<FaceId, bool>,
    /// Seams that constrain nothing for themselves.
    released: BTreeSet<EdgeId>,
}

impl SmallShells {
    /// The shells of `channel` that are smaller than `smallest` equilateral triangles of target length, and have a seam.
    pub fn new(garment: &Mesh, manifold: &Manifold, channel: &Channel, lengths: Lengths<'_>, smallest: f32) -> Self {
        let t = &manifold.level.topology;
        let mut shells = Groups::<FaceId>::new(t.faces.len());
        for edge in t.edges.ids().filter(|&e| !channel.is_cut(e)) {
            let faces = t.edge_corners.row(edge).iter().map(|&c| t.faces.face_of(c));
            faces.reduce(|a, b| {
                shells.join(a, b);
                b
            });
        }
        let shell_of: IdVec<FaceId, FaceId> = t.faces.ids().map(|f| shells.first(f)).collect();
        let mut size = IdVec::<FaceId, f32>::filled(0.0, t.faces.len());
        shell_of
            .enumerated()
            .for_each(|(face, &shell)| size[shell] += triangles_wanted(garment, manifold, lengths, face));
        let shells_at = |edge: EdgeId| t.edge_corners.row(edge).iter().map(|&c| shell_of[t.faces.face_of(c)]);
        let is_released = |&edge: &EdgeId| channel.is_cut(edge) && shells_at(edge).any(|s| size[s] < smallest);
        let released: BTreeSet<EdgeId> = t.edges.ids().filter(is_released).collect();
        if released.is_empty() {
            return Self::default();
        }
        let mut is_small = IdVec::filled(false, t.faces.len());
        released.iter().flat_map(|&e| shells_at(e)).for_each(|s| is_small[s] = size[s] < smallest);
        Self { shell_of, is_small, released }
    }

    /// Number of small shells with a seam.
    pub fn count(&self) -> usize {
        self.is_small.iter().filter(|&&is_small| is_small).count()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.shell_of.is_empty()
    }

    /// Whether a face is on a small shell.
    pub fn holds(&self, face: FaceId) -> bool {
        !self.is_empty() && self.is_small[self.shell_of[face]]
    }

    /// Whether an edge is a seam that constrains nothing for itself.
    pub fn is_released(&self, edge: EdgeId) -> bool {
        self.released.contains(&edge)
    }
}

/// The equilateral triangles of target length that cover a face, as a real number.
fn triangles_wanted(garment: &Mesh, manifold: &Manifold, lengths: Lengths<'_>, face: FaceId) -> f32 {
    let vertices = manifold.level.topology.faces.vertices_of(face);
    let at = |k: usize| garment.points[manifold.vertex_source[vertices[k]]];
    let area = (2..vertices.len()).map(|k| (at(k - 1) - at(0)).cross(at(k) - at(0))).sum::<Vec3>().length() * 0.5;
    let target = vertices.iter().map(|&v| lengths.at(manifold.vertex_source[v])).sum::<f32>() / vertices.len() as f32;
    area / (EQUILATERAL * target * target)
}
