//! Split every edge that is too long, the longest first.

use super::mesh::SimMesh;
use super::queue::EdgeQueue;
use crate::mesh::CornerId;

/// An edge longer than this times its target is split (Botsch and Kobbelt 2004, section 4): its halves are then nearer
/// to the target than it was. Smaller values make more, shorter edges.
pub const SPLIT_RATIO: f32 = 4.0 / 3.0;

/// Splits until no edge is too long or the mesh has `max_faces` triangles. Returns the number of splits.
pub fn split_long_edges(mesh: &mut SimMesh<'_>, max_faces: usize, ratio: f32) -> usize {
    let excess = |mesh: &SimMesh<'_>, half: CornerId| excess(mesh, half, ratio);
    let mut queue = EdgeQueue::of(mesh, excess);
    let mut count = 0;
    let mut faces = mesh.topology.face_count();
    while let Some(half) = queue.pop(mesh) {
        if excess(mesh, half).is_none() || !mesh.topology.may_split(half) {
            continue;
        }
        if faces >= max_faces {
            break;
        }
        let Some(vertex) = mesh.split(half) else { continue };
        faces += 1 + usize::from(mesh.topology.twin(half).is_some());
        count += 1;
        for half in mesh.topology.spokes(vertex) {
            queue.push(mesh, half, excess(mesh, half));
        }
    }
    count
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
