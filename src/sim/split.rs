//! Split every edge that is too long, the longest first.

use super::mesh::SimMesh;
use super::queue::edit_in_order;
use crate::mesh::CornerId;

/// An edge longer than this times its target is split (Botsch and Kobbelt 2004, section 4): its halves are then nearer
/// to the target than it was. Smaller values make more, shorter edges.
pub const SPLIT_RATIO: f32 = 4.0 / 3.0;

/// Splits until no edge is too long or the mesh has `max_faces` triangles. Returns the number of splits.
pub fn split_long_edges(mesh: &mut SimMesh<'_>, max_faces: usize, ratio: f32) -> usize {
    let mut faces = mesh.topology.face_count();
    edit_in_order(
        mesh,
        |mesh, half| excess(mesh, half, ratio),
        |mesh, half| {
            if faces >= max_faces || !mesh.topology.may_split(half) {
                return None;
            }
            let vertex = mesh.split(half)?;
            faces += 1 + usize::from(mesh.topology.twin(half).is_some());
            Some(vertex)
        },
    )
}

/// The excess over the target, as in Waggoner and de Goes 2022, of an edge that is to be split.
fn excess(mesh: &SimMesh<'_>, half: CornerId, ratio: f32) -> Option<f32> {
    let share = if mesh.is_constrained(half) { super::exp::exp(14, 1.25) } else { ratio };
    if !mesh.is_outside(half, share, true) {
        return None;
    }
    let (a, b) = (mesh.topology.vertex(half), mesh.topology.target(half));
    Some((mesh.relative_length(half) - 1.0) * mesh.target_between(a, b))
}
