//! Our simulation meshes beside those of other remeshers, as tables: `cargo xtask peers`.

#![allow(clippy::print_stdout)]

mod lattice;
mod objects;
mod quality;

use crate::prepared::{Prepared, baseline};
use std::path::PathBuf;
use tailor::sim::{SimProduct, simulate};

/// A bound that nothing here reaches.
const MAX_FACES: usize = 20_000_000;

/// A folder that the environment names.
fn folder(variable: &str) -> Option<PathBuf> {
    std::env::var_os(variable).map(PathBuf::from)
}

/// The simulation mesh of a garment.
fn remeshed(prepared: &Prepared) -> SimProduct {
    simulate(baseline(prepared, prepared.recipe.sim.baseline_level), &prepared.recipe.sim, MAX_FACES)
}
