//! The last passes, after the rounds: they move vertices and flip edges at thin triangles, beside chains and in tight turns.

mod follow;
mod polish;
mod turn;

pub use follow::follow_curves;

use crate::sim::sim_mesh::SimMesh;

/// Improves the places that averages leave behind.
pub fn finish(mesh: &mut SimMesh<'_>) {
    polish::open_thin_triangles(mesh);
    follow_curves(mesh);
    turn::turn_to_surface(mesh);
}
