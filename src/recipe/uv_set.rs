//! The UV set that a recipe means where it names none.

use crate::error::{Code, Warning};
use crate::garment::{Interpolation, Meaning, Mesh, Primvar, PrimvarRole};
use crate::sim::SimOptions;

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
    let found = if let [only] = sets[..] { Some(only) } else { usual().copied() };
    options.uv_set = found.map_or_else(String::new, |set| set.name.clone());
    if found.is_some() { None } else { Some(missing(garment, &sets)) }
}

fn missing(garment: &Mesh, sets: &[&Primvar]) -> Warning {
    let without = "so the simulation mesh follows no UV seams";
    let is_per_vertex = |p: &&Primvar| {
        p.role == PrimvarRole::Primvar
            && p.meaning == Meaning::TextureCoordinate
            && p.components == 2
            && p.interpolation != Interpolation::FaceVarying
    };
    let (problem, remedy) = if !sets.is_empty() {
        let names: Vec<&str> = sets.iter().map(|set| set.name.as_str()).collect();
        (
            format!("none of its UV sets ({}) is named st, {without}", names.join(", ")),
            "Name one in sim.uvSet, or say sim.uvSet= for none".to_owned(),
        )
    } else if let Some(uv) = garment.primvars.iter().find(is_per_vertex) {
        (
            format!("its UVs {} have one value a point, {without}", uv.name),
            "Export them as faceVarying, or name edge sets in sim.constraints".to_owned(),
        )
    } else {
        (
            format!("it has no UVs, {without}"),
            "Unwrap it, or name edge sets in sim.constraints; sim.uvSet= stands for none".to_owned(),
        )
    };
    Warning::new(Code::NoUvSet, &garment.prim, problem).remedy(remedy)
}
