//! What the simulation mesh takes over from the garment.

mod edges;
mod sets;
mod values;
mod work;

use crate::garment::GarmentInput;
use crate::testing::sheets;

/// A grid without subsets.
fn sheet(nx: usize, ny: usize) -> GarmentInput {
    let mut input = sheets::grid(nx, ny, |_, _| true);
    input.subsets.clear();
    input.families.clear();
    input
}
