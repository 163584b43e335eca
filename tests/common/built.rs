//! A garment built as the command builds it, with what tests of transfer look into.

use tailor::error::Warnings;
use tailor::garment::{Garment, GarmentInput};
use tailor::pipeline::{Limits, Prepared, Products};
use tailor::recipe::{Layers, bind};
use tailor::sim::{Baseline, Lengths, SimOptions, SimProduct, simulate};
use tailor::transfer::{Transferred, transfer};

/// A garment and its products.
pub struct Built {
    pub garment: Garment,
    pub products: Products,
    pub warnings: Warnings,
    prepared: Prepared,
}

/// Builds with options as on the command line.
pub fn build(input: GarmentInput, options: &[&str]) -> Built {
    let mut layers = Layers::default();
    options.iter().for_each(|o| layers.add_override(o).unwrap_or_else(|e| panic!("{e}")));
    build_with(input, &layers)
}

/// Builds with a recipe.
pub fn build_with(input: GarmentInput, layers: &Layers) -> Built {
    let mut warnings = Warnings::default();
    let prepared = Prepared::new(input, layers, &mut warnings).unwrap_or_else(|e| panic!("{e}"));
    let limits = Limits { max_faces: 1_000_000, progress: &|_| () };
    let products = prepared.build(&limits, &mut warnings).unwrap_or_else(|e| panic!("{e}"));
    Built { garment: (*prepared.garment).clone(), products, warnings, prepared }
}

impl Built {
    /// The simulation mesh before transfer, made again.
    pub fn product(&self) -> SimProduct {
        let sim = &self.prepared.recipe.sim;
        let bound = bind(&self.prepared.recipe, &self.garment, false).unwrap_or_else(|e| panic!("{e}"));
        let lengths = Lengths { min: sim.min_edge_length, max: sim.max_edge_length, density: bound.density };
        let baseline = Baseline::new(&self.garment, sim, lengths, bound.uv_set);
        simulate(baseline, sim.iterations, 4_000_000)
    }

    /// Transfer alone, made again with other options.
    pub fn transferred(&self, product: &SimProduct, options: &SimOptions) -> Transferred {
        let bound = bind(&self.prepared.recipe, &self.garment, false).unwrap_or_else(|e| panic!("{e}"));
        transfer(&self.garment, product, options, bound.uv_set, &mut Warnings::default())
    }

    /// The options of the simulation mesh that were used.
    pub fn options(&self) -> &SimOptions {
        &self.prepared.recipe.sim
    }
}
