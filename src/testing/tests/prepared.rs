//! Garments with resolved recipes, and the surfaces that simulation meshes are made from.

use std::path::Path;
use std::sync::Arc;
use tailor::recipe::ResolvedSim;
use tailor::sim::{Baseline, SimOptions};
use tailor_costume::recipe::Layers;
use tailor_costume::{Builder, Recipe};
use tailor_mesh::garment::Mesh;
use tailor_mesh::{Error, Garment};
use tailor_usd::{ReadOptions, Source};

/// A checked garment, and its recipe with the lengths to use.
pub struct Prepared {
    pub garment: Arc<Mesh>,
    pub recipe: Recipe,
}

impl Prepared {
    pub fn new(input: Garment, layers: &Layers) -> Result<Self, Error> {
        let builder = Builder::new(input)?;
        let recipe = builder.resolve(&layers.recipe()?)?;
        Ok(Self { garment: Arc::clone(builder.garment()), recipe })
    }
}

/// A garment as its file says, and options as on the command line.
pub fn of_file<'a>(file: &Path, options: impl IntoIterator<Item = &'a str>) -> Prepared {
    let source = Source::open(file, &ReadOptions::default()).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let (input, mut warnings) = source.garment().unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let mut layers = Layers::default();
    warnings.extend(layers.add_attributes(source.recipe().unwrap_or_default()));
    options.into_iter().for_each(|o| layers.add_override(o).unwrap_or_else(|e| panic!("{e}")));
    Prepared::new(input, &layers).unwrap_or_else(|e| panic!("{}: {e}", file.display()))
}

/// The baseline after `level` refinements.
pub fn baseline(prepared: &Prepared, level: u32) -> Baseline {
    let options = SimOptions { baseline_level: level, ..prepared.recipe.sim.clone() };
    baseline_of(&prepared.garment, &options).unwrap_or_else(|e| panic!("{e}"))
}

/// The baseline of options whose lengths are resolved.
pub fn baseline_of(garment: &Mesh, options: &SimOptions) -> Result<Baseline, Error> {
    Ok(tailor::pipeline::baseline(garment, &ResolvedSim::new(options, &[], garment)?))
}
