//! The simulation mesh: its passes and its options, on small sheets.

#[path = "../common/cases.rs"]
mod cases;
mod options;
mod passes;
#[path = "../common/sheets.rs"]
mod sheets;

use tailor::error::Warnings;
use tailor::garment::GarmentInput;
use tailor::pipeline::Prepared;
use tailor::recipe::{Layers, bind};
use tailor::sim::{Baseline, Lengths};

/// A bound that no mesh here reaches.
const MAX_FACES: usize = 200_000;

/// A garment with options as on the command line.
fn prepare(input: GarmentInput, options: &[&str]) -> Prepared {
    let mut layers = Layers::default();
    options.iter().for_each(|o| layers.add_override(o).unwrap_or_else(|e| panic!("{e}")));
    Prepared::new(input, &layers, &mut Warnings::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn baseline(prepared: &Prepared) -> Baseline {
    let bound = bind(&prepared.recipe, &prepared.garment, false).unwrap_or_else(|e| panic!("{e}"));
    let sim = &prepared.recipe.sim;
    let lengths = Lengths { min: sim.min_edge_length, max: sim.max_edge_length, density: bound.density };
    Baseline::new(&prepared.garment, sim, lengths, bound.uv_set)
}
