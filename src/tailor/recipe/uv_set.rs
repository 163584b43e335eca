//! The UV set that a recipe means where it names none.

use crate::codes;
use crate::sim::SimOptions;
use tailor_mesh::error::Warning;
use tailor_mesh::garment::{Interpolation, Meaning, Mesh, Primvar, PrimvarRole, Values};

/// Names that programs give the first UV set of a mesh: Blender, Maya, 3ds Max and Houdini, Cinema 4D.
const USUAL: &[&str] = &["UVMap", "map1", "uv", "UV", "uvs", "UVW"];

/// Puts the UV set that a garment has in place of the default one, where that is missing: the only UV set, or the first with
/// a usual name. Gives the warning if there is none.
pub fn resolve_uv_set(options: &mut SimOptions, garment: &Mesh) -> Option<Warning> {
    if options.uv_set != SimOptions::default().uv_set
        || garment.primvar(&options.uv_set).is_some_and(Primvar::is_uv_set)
    {
        return None;
    }
    let sets: Vec<&Primvar> = garment.primvars.iter().filter(|primvar| primvar.is_uv_set()).collect();
    let usual = || USUAL.iter().find_map(|name| sets.iter().find(|set| set.name == *name));
    let default = garment.primvar(&options.uv_set);
    // A set of another use, such as a light map, does not take the place of UVs that cannot be used.
    let found = match sets[..] {
        [only] if default.is_none() => Some(only),
        _ => usual().copied(),
    };
    options.uv_set = found.map_or_else(String::new, |set| set.name.clone());
    let is_uvs = |p: &&Primvar| p.role == PrimvarRole::Primvar && p.meaning == Meaning::TextureCoordinate;
    let uvs = default.or_else(|| garment.primvars.iter().find(is_uvs).filter(|_| sets.is_empty()));
    match (uvs, found) {
        (None, Some(_)) => None,
        (Some(uvs), found) => Some(unusable(garment, uvs, found, &sets)),
        (None, None) => Some(missing(garment, &sets)),
    }
}

/// The warning of UVs from which the simulation mesh can take no seams.
fn unusable(garment: &Mesh, uvs: &Primvar, found: Option<&Primvar>, sets: &[&Primvar]) -> Warning {
    let number = match &uvs.values {
        Values::F64(_) => "double",
        Values::F32(_) if uvs.half => "half",
        Values::F32(_) => "float",
        _ => "whole",
    };
    let (width, interpolation) = (uvs.width(), uvs.interpolation.word());
    let is_large = width == 2 && number == "float" && uvs.interpolation == Interpolation::FaceVarying;
    let problem = format!(
        "primvars:{} has {}{width} {number} number{} for each element, {interpolation}, so {}",
        uvs.name,
        if is_large { "values beyond 1e15, " } else { "" },
        if width == 1 { "" } else { "s" },
        found.map_or_else(
            || "the simulation mesh follows no UV seams".to_owned(),
            |set| format!("{} gives the UV seams", set.name)
        )
    );
    let names: Vec<&str> = sets.iter().map(|set| set.name.as_str()).collect();
    let others =
        if names.is_empty() { String::new() } else { format!(", or name one of {} in sim.uvSet", names.join(", ")) };
    let remedy = format!(
        "Export it as texCoord2f[] with the interpolation faceVarying{others}, or name edge sets in sim.constraints"
    );
    Warning::new(codes::NO_UV_SET, &garment.prim, problem).remedy(remedy)
}

fn missing(garment: &Mesh, sets: &[&Primvar]) -> Warning {
    let without = "so the simulation mesh follows no UV seams";
    let (problem, remedy) = if !sets.is_empty() {
        let names: Vec<&str> = sets.iter().map(|set| set.name.as_str()).collect();
        (
            format!("none of its UV sets ({}) is named st, {without}", names.join(", ")),
            "Name one in sim.uvSet, or say sim.uvSet= for none".to_owned(),
        )
    } else {
        (
            format!("it has no UVs, {without}"),
            "Unwrap it, or name edge sets in sim.constraints; sim.uvSet= stands for none".to_owned(),
        )
    };
    Warning::new(codes::NO_UV_SET, &garment.prim, problem).remedy(remedy)
}
