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
    let uv_set = match named(garment, "sim.uvSet", &sim.uv_set, "face-varying float2 primvar", is_uv) {
        Err(_) if !uv_set_was_given => None,
        found => found?,
    };
    let is_weight = |p: &&Primvar| {
        matches!(p.interpolation, Interpolation::Vertex | Interpolation::Varying)
            && p.width() == 1
            && matches!(p.values, Values::F32(_))
    };
    let density = named(garment, "sim.density", &sim.density, "float primvar per vertex", is_weight)?;
    subsets_are(garment, "sim.constraints", &sim.constraints, "edge")?;
    for (name, seam) in &recipe.seams {
        subsets_are(garment, &format!("seam.{name}.edges"), &seam.edges, "edge")?;
    }
    for (name, thickness) in &recipe.thicknesses {
        subsets_are(garment, &format!("thickness.{name}.faces"), &thickness.faces, "face")?;
        let key = format!("thickness.{name}.weights");
        named(garment, &key, &thickness.weights, "float primvar per vertex", is_weight)?;
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

/// The primvar that `key` names, which has to be a `kind`; none where the name is empty.
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
        "{}: {key} names \"{name}\", which is no {kind} of the mesh\n  hint: {hint}",
        garment.prim
    )))
}
