//! What the simulation mesh takes over from the garment.

mod edges;
mod sets;
mod values;
mod work;

use crate::common::sheets;
use tailor::internals::garment::GarmentInput;

/// A grid without subsets.
fn sheet(nx: usize, ny: usize) -> GarmentInput {
    let mut input = sheets::grid(nx, ny, |_, _| true);
    input.subsets.clear();
    input.families.clear();
    input
}
