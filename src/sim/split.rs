//! Split every edge that is too long, the longest first.

use super::mesh::SimMesh;
use super::queue::Queue;
use crate::mesh::edit::prev;
use crate::mesh::{CornerId, VertexId};

/// An edge longer than this times its target is split (Botsch and Kobbelt 2004, section 4): its halves are then nearer
/// to the target than it was. Smaller values make more, shorter edges.
pub const SPLIT_RATIO: f32 = 4.0 / 3.0;

/// Splits until no edge is too long or the mesh has `max_faces` triangles. Returns the number of splits.
pub fn split_long_edges(mesh: &mut SimMesh<'_>, max_faces: usize) -> usize {
    let wants =
        |mesh: &SimMesh<'_>, half: CornerId| mesh.relative_length(half) > SPLIT_RATIO && mesh.topology.may_split(half);
    let mut queue = Queue::new();
    let halves: Vec<CornerId> = mesh.topology.edges().filter(|&h| wants(mesh, h)).collect();
    halves.into_iter().for_each(|h| push(&mut queue, mesh, h));
    let mut count = 0;
    let mut faces = mesh.topology.face_count();
    while let Some((a, b)) = queue.pop() {
        let Some(half) = mesh.topology.find(a, b).filter(|&h| wants(mesh, h)) else { continue };
        if faces >= max_faces {
            break;
        }
        let Some(vertex) = mesh.split(half) else { continue };
        faces += 1 + usize::from(mesh.topology.twin(half).is_some());
        count += 1;
        let around: Vec<CornerId> = mesh.topology.fan(vertex).flat_map(|c| [c, prev(c)]).collect();
        for half in around.into_iter().filter(|&h| wants(mesh, h)) {
            push(&mut queue, mesh, half);
        }
    }
    count
}

fn push(queue: &mut Queue<(VertexId, VertexId)>, mesh: &SimMesh<'_>, half: CornerId) {
    let (a, b) = (mesh.topology.vertex(half), mesh.topology.target(half));
    // The excess over the target, as in Waggoner and de Goes 2022.
    queue.push(mesh.length(half) - mesh.target_between(a, b), (a.min(b), a.max(b)));
}
