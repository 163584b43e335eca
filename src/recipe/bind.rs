//! Resolves the names in a recipe (primvars and subsets) against a garment.

use super::Recipe;
use crate::checks::{primvar, subsets_are, target_fits, weights, within_size_in_meters};
use crate::error::Error;
use crate::garment::{Garment, Interpolation, Primvar, Values};
use crate::sim::SimOptions;

/// The primvars that the options of the simulation mesh name.
pub struct SimPrimvars<'a> {
    /// The UV set whose shell borders are seams.
    pub uv_set: Option<&'a Primvar>,
    /// The painted density.
    pub density: Option<&'a Primvar>,
}

/// Checks that a garment has all primvars and subsets that a recipe names.
///
/// # Errors
/// A primvar or subset that is missing or has another type.
pub fn bind(recipe: &Recipe, garment: &Garment) -> Result<(), Error> {
    bind_sim(&recipe.sim, garment)?;
    target_fits("sim.maxEdgeLength", recipe.sim.max_edge_length, garment)?;
    target_fits("sim.minEdgeLength", recipe.sim.min_edge_length, garment)?;
    subsets_are(garment, "sim.constraints", &recipe.sim.constraints, "edge")?;
    recipe.cloth.bind(garment)?;
    for (name, fabric) in &recipe.fabrics {
        subsets_are(garment, &format!("fabric.{name}.faces"), &fabric.faces, "face")?;
        within_size_in_meters(&format!("fabric.{name}.thickness"), fabric.thickness, garment)?;
    }
    recipe.enabled().try_for_each(|(name, options)| options.bind(&options.key_of(name), garment))
}

/// Finds the primvars that the options of the simulation mesh name. The default UV set may be absent.
///
/// # Errors
/// A primvar that is missing or has another type.
pub fn bind_sim<'a>(options: &SimOptions, garment: &'a Garment) -> Result<SimPrimvars<'a>, Error> {
    let uv_set = match bind_uv_set(options, garment) {
        Err(_) if options.uv_set == SimOptions::default().uv_set => None,
        found => found?,
    };
    Ok(SimPrimvars { uv_set, density: weights(garment, "sim.density", &options.density)? })
}

/// Finds the UV set; `None` if the name is empty.
///
/// # Errors
/// A primvar that is missing or has another type.
pub fn bind_uv_set<'a>(options: &SimOptions, garment: &'a Garment) -> Result<Option<&'a Primvar>, Error> {
    primvar(garment, "sim.uvSet", &options.uv_set, "face-varying float2 primvar", is_uv_set)
}

/// Whether a primvar can be a UV set with seams.
pub fn is_uv_set(primvar: &&Primvar) -> bool {
    primvar.interpolation == Interpolation::FaceVarying
        && primvar.width() == 2
        && matches!(primvar.values, Values::F32(_))
}
