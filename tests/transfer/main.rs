//! What the simulation mesh takes over from the garment.

#[path = "../common/built.rs"]
mod built;
mod edges;
#[path = "../common/garments.rs"]
mod garments;
#[path = "../common/nearest.rs"]
mod nearest;
#[path = "../common/prepared.rs"]
mod prepared;
mod sets;
#[path = "../common/sheets.rs"]
mod sheets;
mod values;
mod work;

use tailor::internals::garment::GarmentInput;

/// A grid without subsets.
fn sheet(nx: usize, ny: usize) -> GarmentInput {
    let mut input = sheets::grid(nx, ny, |_, _| true);
    input.subsets.clear();
    input.families.clear();
    input
}
