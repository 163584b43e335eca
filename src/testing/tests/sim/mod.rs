//! The simulation mesh: its options, on small sheets and on garments.

mod bounds;
mod details;
mod on_garments;
mod options;
mod rims;
mod shells;
mod symmetry;
mod work;

use crate::prepared::{self, Prepared};
use tailor::sim::Baseline;
use tailor_costume::recipe::Layers;
use tailor_mesh::garment::Garment;

/// A bound that no mesh here reaches.
const MAX_FACES: usize = 200_000;

/// A garment with options as on the command line.
fn prepare(input: Garment, options: &[&str]) -> Prepared {
    let mut layers = Layers::default();
    options.iter().for_each(|o| layers.add_override(o).unwrap_or_else(|e| panic!("{e}")));
    Prepared::new(input, &layers).unwrap_or_else(|e| panic!("{e}"))
}

fn baseline(prepared: &Prepared) -> Baseline {
    prepared::baseline(prepared, prepared.recipe.sim.baseline_level)
}
