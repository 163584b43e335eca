//! What a recipe names, found on its garment.

use super::Recipe;
use crate::error::Error;
use crate::garment::{Elements, Garment, Interpolation, Primvar, Values};

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
    let uv_set = match named(garment, "uvSet", &sim.uv_set, "face-varying float2 primvar", is_uv) {
        Err(_) if !uv_set_was_given => None,
        found => found?,
    };
    let is_weight = |p: &&Primvar| {
        matches!(p.interpolation, Interpolation::Vertex | Interpolation::Varying)
            && p.width() == 1
            && matches!(p.values, Values::F32(_))
    };
    let density = named(garment, "density", &sim.density, "float primvar per vertex", is_weight)?;
    for name in &sim.constraints {
        if !garment.subset(name).is_some_and(|s| matches!(s.elements, Elements::Edges(_))) {
            let names: Vec<&str> = garment
                .subsets
                .iter()
                .filter(|s| matches!(s.elements, Elements::Edges(_)))
                .map(|s| s.name.as_str())
                .collect();
            return Err(Error::Recipe(format!(
                "{}: sim.constraints names \"{name}\", which is no edge subset of the mesh\n  hint: its edge subsets are: {}",
                garment.prim,
                names.join(", ")
            )));
        }
    }
    Ok(Bound { uv_set, density })
}

/// The primvar that `sim.key` names, which has to be a `kind`; none where the name is empty.
fn named<'a>(
    garment: &'a Garment,
    key: &str,
    name: &str,
    kind: &str,
    fits: impl Fn(&&Primvar) -> bool,
) -> Result<Option<&'a Primvar>, Error> {
    let found = garment.primvar(name).filter(&fits);
    if found.is_some() || name.is_empty() {
        return Ok(found);
    }
    let names: Vec<&str> = garment.primvars.iter().filter(&fits).map(|p| p.name.as_str()).collect();
    let hint =
        if names.is_empty() { "the mesh has none".to_owned() } else { format!("the mesh has: {}", names.join(", ")) };
    Err(Error::Recipe(format!(
        "{}: sim.{key} names \"{name}\", which is no {kind} of the mesh\n  hint: {hint}",
        garment.prim
    )))
}
