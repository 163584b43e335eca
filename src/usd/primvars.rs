//! Primvars of the mesh that vary over it.

use super::UsdError;
use super::geometry::value;
use super::names::{self, UsdToken};
use super::values::{flat, mixing, text};
use crate::error::Warning;
use crate::garment::{Interpolation, PrimvarInput, PrimvarRole};
use openusd::sdf::Value;
use openusd::usd::{Prim, TimeCode};

/// Names of the primvars of a prim, without `primvars:` and without those that are indices of another.
pub fn primvar_names(prim: &Prim) -> Result<Vec<String>, UsdError> {
    let properties =
        prim.authored_property_names().map_err(|e| UsdError::new(format!("{} cannot be read: {e}", prim.path())))?;
    Ok(properties
        .iter()
        .filter_map(|p| p.strip_prefix(names::PRIMVARS))
        .filter(|p| !p.is_empty() && !p.ends_with(names::INDICES_SUFFIX))
        .map(str::to_owned)
        .collect())
}

/// The elements that the primvar `name` lives on, with USD's fallback.
///
/// # Errors
/// A token that USD does not know.
pub fn interpolation(prim: &Prim, name: &str) -> Result<Interpolation, UsdError> {
    let property = format!("{}{name}", names::PRIMVARS);
    let field = prim
        .attribute(property.as_str())
        .get_metadata::<Value>(names::INTERPOLATION)
        .map_err(|e| UsdError::new(format!("{}.{property} cannot be read: {e}", prim.path())))?;
    let Some(field) = field else { return Ok(Interpolation::Constant) };
    let shown = text(&field).unwrap_or("not a token");
    Interpolation::from_token(shown).ok_or_else(|| {
        UsdError::new(format!("{}.{property} has interpolation {shown:?}, which USD does not know", prim.path()))
            .hint(format!("use one of: {}", Interpolation::allowed()))
    })
}

/// Reads the primvars that vary over the mesh; what cannot be carried becomes a warning.
///
/// # Errors
/// Metadata or indices that make no sense.
pub fn read_primvars(
    prim: &Prim,
    time: Option<TimeCode>,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<PrimvarInput>, UsdError> {
    let mut found = Vec::new();
    for name in primvar_names(prim)? {
        let interpolation = interpolation(prim, &name)?;
        if interpolation == Interpolation::Constant {
            continue;
        }
        match read_primvar(prim, &name, interpolation, time) {
            Ok(Some(primvar)) => found.push(primvar),
            Ok(None) => {}
            Err(why) => warnings.push(Warning::NotCarried { what: format!("primvars:{name}"), why }),
        }
    }
    Ok(found)
}

/// The attribute `normals` of a polygonal mesh, as a primvar; none where a primvar of that name replaces it, or where it
/// has not one normal for each element.
///
/// `elements` are the numbers of faces, points and corners.
pub fn read_normals(prim: &Prim, time: Option<TimeCode>, elements: [usize; 3]) -> Option<PrimvarInput> {
    let attribute = prim.attribute(names::NORMALS);
    let replaced = prim.attribute(format!("{}{}", names::PRIMVARS, names::NORMALS));
    if replaced.has_authored_value().unwrap_or(false) {
        return None;
    }
    let value = value(prim, names::NORMALS, time).ok()??;
    let field = attribute.get_metadata::<Value>(names::INTERPOLATION).ok()?;
    let interpolation = field.as_ref().and_then(text).map_or(Some(Interpolation::Vertex), Interpolation::from_token)?;
    let [faces, points, corners] = elements;
    let count = match interpolation {
        Interpolation::Constant => return None,
        Interpolation::Uniform => faces,
        Interpolation::Vertex | Interpolation::Varying => points,
        Interpolation::FaceVarying => corners,
    };
    let type_name = attribute.type_name().ok()??;
    let (components, values) = flat(value)?;
    (components == 3 && values.len() == 3 * count).then(|| PrimvarInput {
        name: names::NORMALS.to_owned(),
        role: PrimvarRole::Normals,
        type_name: type_name.as_str().to_owned(),
        interpolation,
        components,
        element_size: 1,
        mixing: mixing(&type_name),
        values,
        indices: None,
    })
}

/// One primvar; none when it has no value, and the reason when it has one that cannot be carried.
fn read_primvar(
    prim: &Prim,
    name: &str,
    interpolation: Interpolation,
    time: Option<TimeCode>,
) -> Result<Option<PrimvarInput>, String> {
    let property = format!("{}{name}", names::PRIMVARS);
    let attribute = prim.attribute(property.as_str());
    let Some(value) = value(prim, &property, time).map_err(|e| in_a_line(&e))? else { return Ok(None) };
    let Some(type_name) = attribute.type_name().map_err(|e| e.to_string())? else { return Ok(None) };
    let Some((components, values)) = flat(value) else {
        return Err(format!("values of type {type_name} cannot vary over a mesh"));
    };
    Ok(Some(PrimvarInput {
        name: name.to_owned(),
        role: PrimvarRole::Primvar,
        type_name: type_name.as_str().to_owned(),
        interpolation,
        components,
        element_size: element_size(prim, &property)?,
        mixing: mixing(&type_name),
        values,
        indices: indices(prim, &property, time)?,
    }))
}

fn element_size(prim: &Prim, property: &str) -> Result<i32, String> {
    match prim.attribute(property).get_metadata::<Value>(names::ELEMENT_SIZE) {
        Ok(None) => Ok(1),
        Ok(Some(Value::Int(n))) => Ok(n),
        Ok(Some(_)) => Err("its elementSize is not an int".into()),
        Err(e) => Err(e.to_string()),
    }
}

fn indices(prim: &Prim, property: &str, time: Option<TimeCode>) -> Result<Option<Vec<i32>>, String> {
    match value(prim, &format!("{property}{}", names::INDICES_SUFFIX), time).map_err(|e| in_a_line(&e))? {
        None => Ok(None),
        Some(Value::IntVec(v)) => Ok(Some(v)),
        Some(_) => Err("its indices are not of type int[]".into()),
    }
}

/// A fault with its advice, for a warning.
fn in_a_line(e: &UsdError) -> String {
    match &e.hint {
        Some(hint) => format!("{}; {hint}", e.message),
        None => e.message.clone(),
    }
}
