//! A garment built as the command builds it, with what tests of transfer look into.

use super::prepared::{Prepared, baseline};
use tailor::sim::{SimOptions, SimProduct, simulate};
use tailor::transfer::{Locator, LocatorTables, TransferResult, transfer};
use tailor_costume::recipe::Layers;
use tailor_costume::{Builder, Products};
use tailor_mesh::Garment;
use tailor_mesh::error::Warnings;
use tailor_mesh::garment::Mesh;

/// A garment and its products.
pub struct Built {
    pub garment: Mesh,
    pub products: Products,
    pub warnings: Warnings,
}

/// Builds with options as on the command line.
pub fn build(input: Garment, options: &[&str]) -> Built {
    let mut layers = Layers::default();
    options.iter().for_each(|o| layers.add_override(o).unwrap_or_else(|e| panic!("{e}")));
    build_with(input, &layers)
}

/// Builds with a recipe.
pub fn build_with(input: Garment, layers: &Layers) -> Built {
    let mut builder = Builder::new(input).unwrap_or_else(|e| panic!("{e}")).with_max_faces(1_000_000);
    let recipe = layers.recipe().unwrap_or_else(|e| panic!("{e}"));
    let products = builder.update(&recipe).unwrap_or_else(|e| panic!("{e}"));
    Built { garment: (**builder.garment()).clone(), warnings: products.warnings.clone(), products }
}

impl Built {
    /// The simulation mesh before transfer, made again.
    pub fn product(&self) -> SimProduct {
        let prepared = Prepared { garment: self.garment.clone().into(), recipe: self.products.recipe.clone() };
        simulate(baseline(&prepared, self.options().baseline_level), self.options(), 4_000_000)
    }

    /// Transfer alone, made again with other options.
    pub fn transferred(&self, product: &SimProduct, options: &SimOptions) -> TransferResult {
        let tables = LocatorTables::new(product, self.garment.faces.len());
        transfer(&self.garment, &Locator::new(product, &tables), options).0
    }

    /// The options of the simulation mesh that were used.
    pub fn options(&self) -> &SimOptions {
        &self.products.recipe.sim
    }
}
