//! Reading the mesh: points, topology, subdivision, subsets, and what varies over it.

use super::primvars::{Declarations, read_normals, read_primvars};
use super::query::{
    OrUnreadable, interpolation, known, prim_name, primvar_names, property_names, subset_prims, text_value, value,
};
use super::shapes::read_shapes;
use super::skin::check_joints;
use super::space::{space, transforms, units, uv_scales};
use crate::codes;
use crate::names::{self, UsdToken};
use glam::Vec3;
use openusd::sdf::Value;
use openusd::usd::{Prim, TimeCode};
use std::collections::BTreeMap;
use tailor_mesh::error::{Error, Warning, Warnings};
use tailor_mesh::garment::{
    FaceNumbers, Family, Garment, Interpolation, Scheme, SubdivisionRules, SubsetInput, split_repeats,
};

/// Element types of subsets that products have.
const ELEMENT_TYPES: &[&str] = &["face", "edge", "point"];

/// Reads the mesh `prim` at `time`, as authored, and how the properties that vary over it are declared. Warns of what cannot be
/// carried.
///
/// # Errors
/// A field that is needed and is missing, of another type, or unreadable.
pub fn read_mesh(prim: &Prim, time: Option<TimeCode>) -> Result<((Garment, Declarations), Warnings), Error> {
    let ints = |name| required_or_empty(prim, name, time, false, int_array);
    let floats = |name| required_or_empty(prim, name, time, false, float_array);
    let mut warnings = Warnings::from_iter(motion(prim, names::POINTS, time)?);
    let mut declarations = Declarations::default();
    let scheme: Scheme = token(prim, names::SUBDIVISION_SCHEME, time)?;
    let mut mesh = Garment {
        prim: prim.path().as_str().to_owned(),
        units: units(prim, time)?,
        uv_scales: uv_scales(prim, time)?,
        space: space(prim.stage(), &transforms(prim, time)?.to_world)?,
        materials: BTreeMap::new(),
        points: required_or_empty(prim, names::POINTS, time, true, point_array)?,
        face_vertex_counts: required_or_empty(prim, names::FACE_VERTEX_COUNTS, time, true, int_array)?,
        face_vertex_indices: required_or_empty(prim, names::FACE_VERTEX_INDICES, time, true, int_array)?,
        face_numbers: FaceNumbers::default(),
        orientation: token(prim, names::ORIENTATION, time)?,
        rules: SubdivisionRules {
            scheme,
            boundary: token(prim, names::INTERPOLATE_BOUNDARY, time)?,
            face_varying: token(prim, names::FACE_VARYING_LINEAR_INTERPOLATION, time)?,
            // The rule is for Catmull-Clark alone.
            triangles: token(prim, names::TRIANGLE_SUBDIVISION_RULE, time)
                .or_else(|e| if scheme == Scheme::CatmullClark { Err(e) } else { Ok(Default::default()) })?,
        },
        hole_indices: ints(names::HOLE_INDICES)?,
        crease_indices: ints(names::CREASE_INDICES)?,
        crease_lengths: ints(names::CREASE_LENGTHS)?,
        crease_sharpnesses: floats(names::CREASE_SHARPNESSES)?,
        corner_indices: ints(names::CORNER_INDICES)?,
        corner_sharpnesses: floats(names::CORNER_SHARPNESSES)?,
        primvars: Vec::new(),
        left_out: Vec::new(),
        subsets: warnings.absorb(subsets(prim, time)?),
        families: families(prim)?,
    };
    let elements = [mesh.face_vertex_counts.len(), mesh.points.len(), mesh.face_vertex_indices.len()];
    mesh.primvars = warnings.absorb(read_primvars(prim, time, elements, &mut declarations)?);
    warnings.extend(check_joints(prim, &mut mesh.primvars, time)?);
    warnings.extend(constant_uvs(prim, &mesh, time)?);
    let (shapes, offsets) = warnings.absorb(read_shapes(prim, time, mesh.points.len())?);
    declarations.shapes = shapes;
    mesh.primvars.extend(offsets);
    // A subdivision surface ignores authored normals.
    if mesh.rules.scheme == Scheme::None {
        mesh.primvars.extend(read_normals(prim, time, elements));
    }
    warnings.extend(split_repeats(&mut mesh));
    Ok(((mesh, declarations), warnings))
}

/// Warnings of arrays of UVs that their interpolation gives to the mesh as a whole.
fn constant_uvs(prim: &Prim, mesh: &Garment, time: Option<TimeCode>) -> Result<Warnings, Error> {
    let elements = [(mesh.face_vertex_indices.len(), "faceVarying"), (mesh.points.len(), "vertex")];
    let mut warnings = Warnings::default();
    for name in primvar_names(prim)? {
        let property = format!("{}{name}", names::PRIMVARS);
        if interpolation(prim, &property)? != Interpolation::Constant {
            continue;
        }
        let indices = value(prim, &format!("{property}{}", names::INDICES_SUFFIX), time).ok().flatten();
        let count = match (indices, value(prim, &property, time).ok().flatten()) {
            (Some(Value::IntVec(indices)), Some(Value::Vec2fVec(_))) => indices.len(),
            (None, Some(Value::Vec2fVec(values))) => values.len(),
            _ => continue,
        };
        if let Some((_, kind)) = elements.iter().find(|(elements, _)| *elements == count) {
            let problem = format!("its interpolation is constant, so its {count} values are not read as UVs");
            let place = format!("{}.{property}", prim.path());
            warnings.push(
                Warning::new(tailor::codes::NO_UV_SET, place, problem).remedy(format!("Set interpolation to {kind}")),
            );
        }
    }
    Ok(warnings)
}

/// The warning of an animated attribute, as products are built at one time.
pub fn motion(prim: &Prim, name: &str, time: Option<TimeCode>) -> Result<Option<Warning>, Error> {
    let times = prim.attribute(name).time_sample_times().or_unreadable(prim.path())?;
    let at = time.map_or_else(|| "the default time".to_owned(), |t| format!("time {}", t.value()));
    let place = format!("the motion of {}.{name} over {} times", prim.path(), times.len());
    let why = format!("both meshes are built at {at}; the model keeps it");
    Ok((times.len() > 1).then(|| Warning::not_carried(place, why)))
}

fn required_or_empty<T>(
    prim: &Prim,
    name: &str,
    time: Option<TimeCode>,
    required: bool,
    convert: impl Fn(Value) -> Result<Vec<T>, &'static str>,
) -> Result<Vec<T>, Error> {
    match value(prim, name, time)? {
        Some(value) => convert(value).map_err(|expected| {
            Error::usd(format!("{}.{name} is not of type {expected}", prim.path()))
                .code(codes::ATTRIBUTE_TYPE)
                .remedy(format!("declare it as {expected} {name}"))
        }),
        None if required => Err(Error::usd(format!("{} has no {name}", prim.path()))
            .code(codes::ATTRIBUTE_TYPE)
            .remedy("a mesh needs points, faceVertexCounts and faceVertexIndices")),
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
fn token<T: UsdToken + Default>(prim: &Prim, name: &str, time: Option<TimeCode>) -> Result<T, Error> {
    match value(prim, name, time)? {
        None => Ok(T::default()),
        Some(value) => known(&value, &format!("{}.{name}", prim.path())),
    }
}

/// The subsets of the mesh. Warns of those with elements that a mesh does not have.
fn subsets(mesh: &Prim, time: Option<TimeCode>) -> Result<(Vec<SubsetInput>, Warnings), Error> {
    let (mut found, mut warnings) = (Vec::new(), Warnings::default());
    for subset in subset_prims(mesh)? {
        let element_type = text_value(&subset, names::ELEMENT_TYPE, time)?.unwrap_or_else(|| "face".to_owned());
        if !ELEMENT_TYPES.contains(&element_type.as_str()) {
            warnings.push(Warning::not_carried(
                format!("subset {}", subset.path()),
                format!("a mesh has no elements of type {element_type:?}; it stays on the model"),
            ));
            continue;
        }
        found.push(SubsetInput {
            name: prim_name(&subset),
            element_type,
            family: text_value(&subset, names::FAMILY_NAME, time)?.unwrap_or_default(),
            indices: required_or_empty(&subset, names::INDICES, time, false, int_array)?,
        });
    }
    Ok((found, warnings))
}

fn families(mesh: &Prim) -> Result<Vec<Family>, Error> {
    let mut found = Vec::new();
    for property in property_names(mesh)? {
        let family =
            property.strip_prefix(names::SUBSET_FAMILY).and_then(|p| p.strip_suffix(names::FAMILY_TYPE_SUFFIX));
        if let Some(family) = family
            && let Some(value) = value(mesh, &property, None)?
        {
            let kind = known(&value, &format!("{}.{property}", mesh.path()))?;
            found.push(Family { name: family.to_owned(), kind });
        }
    }
    Ok(found)
}
