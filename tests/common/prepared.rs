//! Garments from files with their own recipes, and the surfaces that simulation meshes are made from.

use std::path::Path;
use tailor::error::Warnings;
use tailor::pipeline::Prepared;
use tailor::recipe::{Layers, bind};
use tailor::sim::{Baseline, Lengths};
use tailor::usd::{ReadOptions, Source};

/// A garment as its file says, and options as on the command line.
pub fn of_file<'a>(file: &Path, options: impl IntoIterator<Item = &'a str>) -> Prepared {
    let mut warnings = Warnings::default();
    let source = Source::open(file, &ReadOptions::default()).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let input = source.garment(&mut warnings).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let mut layers = Layers::default();
    layers.add_attributes(source.recipe().unwrap_or_default(), &mut warnings);
    options.into_iter().for_each(|o| layers.add_override(o).unwrap_or_else(|e| panic!("{e}")));
    Prepared::new(input, &layers, &mut warnings).unwrap_or_else(|e| panic!("{}: {e}", file.display()))
}

/// The baseline after `level` refinements.
pub fn baseline(prepared: &Prepared, level: u32) -> Baseline {
    let bound = bind(&prepared.recipe, &prepared.garment, false).unwrap_or_else(|e| panic!("{e}"));
    let mut sim = prepared.recipe.sim.clone();
    sim.baseline_level = level;
    let lengths = Lengths { min: sim.min_edge_length, max: sim.max_edge_length, density: bound.density };
    Baseline::new(&prepared.garment, &sim, lengths, bound.uv_set)
}
