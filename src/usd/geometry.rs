//! The mesh itself: points, topology, subdivision, subsets.

use super::names::{self, UsdToken};
use super::values::text;
use super::{UsdError, primvars};
use crate::error::Warning;
use crate::garment::{Family, GarmentInput, SubdivisionRules, SubsetInput};
use glam::Vec3;
use openusd::sdf::Value;
use openusd::usd::{Prim, TimeCode};

/// Element types of subsets that are carried.
const ELEMENT_TYPES: &[&str] = &["face", "edge", "point"];

/// Reads the mesh `prim` at `time`, as authored.
///
/// # Errors
/// A field that is needed and is missing, of another type, or unreadable.
pub fn read_mesh(prim: &Prim, time: Option<TimeCode>, warnings: &mut Vec<Warning>) -> Result<GarmentInput, UsdError> {
    let ints = |name| required_or_empty(prim, name, time, false, int_array);
    let floats = |name| required_or_empty(prim, name, time, false, float_array);
    warn_of_animation(prim, time, warnings);
    Ok(GarmentInput {
        prim: prim.path().as_str().to_owned(),
        points: required_or_empty(prim, names::POINTS, time, true, point_array)?,
        face_vertex_counts: required_or_empty(prim, names::FACE_VERTEX_COUNTS, time, true, int_array)?,
        face_vertex_indices: required_or_empty(prim, names::FACE_VERTEX_INDICES, time, true, int_array)?,
        orientation: token(prim, names::ORIENTATION, time)?,
        rules: SubdivisionRules {
            scheme: token(prim, names::SUBDIVISION_SCHEME, time)?,
            boundary: token(prim, names::INTERPOLATE_BOUNDARY, time)?,
            face_varying: token(prim, names::FACE_VARYING_LINEAR_INTERPOLATION, time)?,
            triangles: token(prim, names::TRIANGLE_SUBDIVISION_RULE, time)?,
        },
        hole_indices: ints(names::HOLE_INDICES)?,
        crease_indices: ints(names::CREASE_INDICES)?,
        crease_lengths: ints(names::CREASE_LENGTHS)?,
        crease_sharpnesses: floats(names::CREASE_SHARPNESSES)?,
        corner_indices: ints(names::CORNER_INDICES)?,
        corner_sharpnesses: floats(names::CORNER_SHARPNESSES)?,
        primvars: primvars::read_primvars(prim, time, warnings)?,
        subsets: subsets(prim, time, warnings)?,
        families: families(prim)?,
    })
}

/// The products are built at one time; points that move with time move on the model only.
fn warn_of_animation(prim: &Prim, time: Option<TimeCode>, warnings: &mut Vec<Warning>) {
    let times = prim.attribute(names::POINTS).time_sample_times().unwrap_or_default();
    if times.len() > 1 {
        let at = time.map_or_else(|| "the default time".to_owned(), |t| format!("time {}", t.value()));
        warnings.push(Warning::NotCarried {
            what: format!("the motion of {}.points over {} times", prim.path(), times.len()),
            why: format!("both meshes are built at {at}; the model keeps it"),
        });
    }
}

/// The value of an attribute at `time`, or its value that does not vary; none where nothing is authored or where it is
/// blocked.
///
/// # Errors
/// A value that cannot be read, and one that is there at other times only.
pub fn value(prim: &Prim, name: &str, time: Option<TimeCode>) -> Result<Option<Value>, UsdError> {
    let attribute = prim.attribute(name);
    match attribute.get_at::<Value>(time) {
        Ok(Some(value)) if !value.is_value_block() => Ok(Some(value)),
        Ok(_) => match attribute.time_sample_times() {
            Ok(times) if time.is_none() && !times.is_empty() => Err(only_samples(prim, name, &times)),
            _ => Ok(None),
        },
        Err(e) => Err(UsdError::new(format!("{}.{name} cannot be read: {e}", prim.path()))),
    }
}

fn only_samples(prim: &Prim, name: &str, times: &[f64]) -> UsdError {
    let first = times.first().copied().unwrap_or_default();
    UsdError::new(format!("{}.{name} has values at {} times and none besides", prim.path(), times.len()))
        .hint(format!("choose a time, for example --time {first}, or the argument time={first} of a .tailor file"))
}

fn required_or_empty<T>(
    prim: &Prim,
    name: &str,
    time: Option<TimeCode>,
    required: bool,
    convert: impl Fn(Value) -> Result<Vec<T>, &'static str>,
) -> Result<Vec<T>, UsdError> {
    match value(prim, name, time)? {
        Some(value) => convert(value).map_err(|expected| {
            UsdError::new(format!("{}.{name} is not of type {expected}", prim.path()))
                .hint(format!("declare it as {expected} name"))
        }),
        None if required => Err(UsdError::new(format!("{} has no {name}", prim.path()))
            .hint("a mesh needs points, faceVertexCounts and faceVertexIndices")),
        None => Ok(Vec::new()),
    }
}

fn int_array(value: Value) -> Result<Vec<i32>, &'static str> {
    match value {
        Value::IntVec(v) => Ok(v),
        _ => Err("int[]"),
    }
}

fn float_array(value: Value) -> Result<Vec<f32>, &'static str> {
    match value {
        Value::FloatVec(v) => Ok(v),
        _ => Err("float[]"),
    }
}

fn point_array(value: Value) -> Result<Vec<Vec3>, &'static str> {
    match value {
        Value::Vec3fVec(v) => Ok(bytemuck::cast_slice(&v).to_vec()),
        _ => Err("point3f[]"),
    }
}

/// A token attribute, with the schema's fallback.
fn token<T: UsdToken + Default>(prim: &Prim, name: &str, time: Option<TimeCode>) -> Result<T, UsdError> {
    match value(prim, name, time)? {
        None => Ok(T::default()),
        Some(value) => known(prim, name, &value),
    }
}

fn known<T: UsdToken>(prim: &Prim, name: &str, value: &Value) -> Result<T, UsdError> {
    let shown = text(value).unwrap_or("not a token");
    T::from_token(shown).ok_or_else(|| {
        UsdError::new(format!("{}.{name} is {shown:?}, which USD does not know", prim.path()))
            .hint(format!("use one of: {}", T::allowed()))
    })
}

/// The subsets directly below a mesh.
pub fn subset_prims(mesh: &Prim) -> Result<Vec<Prim>, UsdError> {
    let fault = |e: openusd::Error| UsdError::new(format!("{} cannot be read: {e}", mesh.path()));
    let mut found = Vec::new();
    for child in mesh.children().map_err(fault)? {
        let is_subset = child.type_name().map_err(fault)?.is_some_and(|t| t.as_str() == names::GEOM_SUBSET);
        if is_subset && child.is_active().map_err(fault)? && child.is_defined().map_err(fault)? {
            found.push(child);
        }
    }
    Ok(found)
}

/// Name of a prim.
pub fn prim_name(prim: &Prim) -> String {
    prim.path().name().unwrap_or_default().to_owned()
}

fn subsets(mesh: &Prim, time: Option<TimeCode>, warnings: &mut Vec<Warning>) -> Result<Vec<SubsetInput>, UsdError> {
    let mut found = Vec::new();
    for subset in subset_prims(mesh)? {
        let text_of = |name, fallback: &str| {
            Ok::<_, UsdError>(value(&subset, name, time)?.as_ref().and_then(text).unwrap_or(fallback).to_owned())
        };
        let element_type = text_of(names::ELEMENT_TYPE, "face")?;
        if !ELEMENT_TYPES.contains(&element_type.as_str()) {
            warnings.push(Warning::NotCarried {
                what: format!("subset {}", subset.path()),
                why: format!("a mesh has no elements of type {element_type:?}; it stays on the model"),
            });
            continue;
        }
        found.push(SubsetInput {
            name: prim_name(&subset),
            element_type,
            family: text_of(names::FAMILY_NAME, "")?,
            indices: required_or_empty(&subset, names::INDICES, time, false, int_array)?,
        });
    }
    Ok(found)
}

fn families(mesh: &Prim) -> Result<Vec<Family>, UsdError> {
    let properties =
        mesh.authored_property_names().map_err(|e| UsdError::new(format!("{} cannot be read: {e}", mesh.path())))?;
    let mut found = Vec::new();
    for property in properties {
        let family =
            property.strip_prefix(names::SUBSET_FAMILY).and_then(|p| p.strip_suffix(names::FAMILY_TYPE_SUFFIX));
        if let Some(family) = family
            && let Some(value) = value(mesh, &property, None)?
        {
            found.push(Family { name: family.to_owned(), kind: known(mesh, &property, &value)? });
        }
    }
    Ok(found)
}
