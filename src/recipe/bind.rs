//! What a recipe names, found on its garment.

use super::Recipe;
use crate::checks::{primvar, subsets_are, weights};
use crate::error::Error;
use crate::garment::{Garment, Interpolation, Primvar, Values};

/// What the recipe names on the garment.
pub struct Bound<'a> {
    /// The primvar with the constraint UVs.
    pub uv_set: Option<&'a Primvar>,
    /// The painted density.
    pub density: Option<&'a Primvar>,
}

/// Finds what a recipe names on its garment. The default UV set may be missing; one that was asked for may not.
///
/// # Errors
/// A primvar or subset that is missing or of another kind.
pub fn bind<'a>(recipe: &Recipe, garment: &'a Garment, uv_set_was_given: bool) -> Result<Bound<'a>, Error> {
    let sim = &recipe.sim;
    let is_uv = |p: &&Primvar| {
        p.interpolation == Interpolation::FaceVarying && p.width() == 2 && matches!(p.values, Values::F32(_))
    };
    let uv_set = match primvar(garment, "sim.uvSet", &sim.uv_set, "face-varying float2 primvar", is_uv) {
        Err(_) if !uv_set_was_given => None,
        found => found?,
    };
    let density = weights(garment, "sim.density", &sim.density)?;
    subsets_are(garment, "sim.constraints", &sim.constraints, "edge")?;
    for (name, options) in recipe.instances() {
        options.bind(&options.key_of(name), garment)?;
    }
    Ok(Bound { uv_set, density })
}
