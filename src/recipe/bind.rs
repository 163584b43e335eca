//! What a recipe names, found on its garment.

use super::Recipe;
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
    let uv_set = garment.primvar(&sim.uv_set).filter(is_uv);
    if uv_set.is_none() && uv_set_was_given && !sim.uv_set.is_empty() {
        return Err(missing(
            garment,
            "sim.uvSet",
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
            "sim.density",
            &sim.density,
            "float primvar per vertex",
            garment.primvars.iter().filter(is_weight),
        ));
    }
    subsets_are(garment, "sim.constraints", &sim.constraints, "edge")?;
    for (name, seam) in &recipe.seams {
        subsets_are(garment, &format!("seam.{name}.edges"), &seam.edges, "edge")?;
    }
    for (name, thickness) in &recipe.thicknesses {
        subsets_are(garment, &format!("thickness.{name}.faces"), &thickness.faces, "face")?;
        let weights = &thickness.weights;
        if !weights.is_empty() && garment.primvar(weights).filter(is_weight).is_none() {
            let fitting = garment.primvars.iter().filter(is_weight);
            let key = format!("thickness.{name}.weights");
            return Err(missing(garment, &key, weights, "float primvar per vertex", fitting));
        }
    }
    Ok(Bound { uv_set, density })
}

/// Whether all of `names` are subsets of the garment whose elements are of a kind.
fn subsets_are(garment: &Garment, key: &str, names: &[String], kind: &str) -> Result<(), Error> {
    for name in names {
        if garment.subset(name).is_none_or(|s| s.elements.kind() != kind) {
            let fitting = garment.subsets.iter().filter(|s| s.elements.kind() == kind);
            let fitting: Vec<&str> = fitting.map(|s| s.name.as_str()).collect();
            return Err(Error::Recipe(format!(
                "{}: {key} names \"{name}\", which is no {kind} subset of the mesh\n  hint: its {kind} subsets are: {}",
                garment.prim,
                fitting.join(", ")
            )));
        }
    }
    Ok(())
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
    Error::Recipe(format!("{}: {key} names \"{name}\", which is no {kind} of the mesh\n  hint: {hint}", garment.prim))
}
