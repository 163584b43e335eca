//! The last passes, after the rounds: they move vertices of thin triangles and of chains, and turn triangles in tight turns.

mod follow;
mod polish;
mod turn;

pub use follow::follow_curves;
pub use turn::turn_to_surface;

use crate::sim::sim_mesh::SimMesh;

/// Improves the places that averages leave behind.
pub fn finish(mesh: &mut SimMesh<'_>) {
    polish::open_thin_triangles(mesh);
    follow_curves(mesh);
}
