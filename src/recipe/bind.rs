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
    let uv_set = garment.primvar(&sim.uv_set).filter(is_uv);
    if uv_set.is_none() && uv_set_was_given && !sim.uv_set.is_empty() {
        return Err(missing(
            garment,
            "uvSet",
            &sim.uv_set,
            "face-varying float2 primvar",
            garment.primvars.iter().filter(is_uv),
        ));
    }
    let is_weight = |p: &&Primvar| {
        matches!(p.interpolation, Interpolation::Vertex | Interpolation::Varying)
            && p.width() == 1
            && matches!(p.values, Values::F32(_))
    };
    let density = garment.primvar(&sim.density).filter(is_weight);
    if density.is_none() && !sim.density.is_empty() {
        return Err(missing(
            garment,
            "density",
            &sim.density,
            "float primvar per vertex",
            garment.primvars.iter().filter(is_weight),
        ));
    }
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

fn missing<'a>(
    garment: &Garment,
    key: &str,
    name: &str,
    kind: &str,
    fitting: impl Iterator<Item = &'a Primvar>,
) -> Error {
    let names: Vec<&str> = fitting.map(|p| p.name.as_str()).collect();
    let hint =
        if names.is_empty() { "the mesh has none".to_owned() } else { format!("the mesh has: {}", names.join(", ")) };
    Error::Recipe(format!(
        "{}: sim.{key} names \"{name}\", which is no {kind} of the mesh\n  hint: {hint}",
        garment.prim
    ))
}
