//! Attributes of the garment on the simulation mesh.

mod edges;
mod places;
mod sets;
mod values;
mod work;

use tailor_mesh::garment::Garment;
use tailor_testing::sheets;

/// A grid without subsets.
fn sheet(nx: usize, ny: usize) -> Garment {
    let mut input = sheets::grid(nx, ny, |_, _| true);
    input.subsets.clear();
    input.families.clear();
    input
}
