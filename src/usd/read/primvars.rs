//! Reading primvars and normals: values that vary over the mesh, and how their properties are declared.

use super::mesh::motion;
use super::query::{OrUnreadable, interpolation, primvar_names, value};
use super::shapes::BlendShape;
use crate::assets::{file_path, resolved};
use crate::codes;
use crate::names::{self, UsdToken};
use crate::record::{Depth, Record};
use crate::values::{Flat, flat, text};
use openusd::sdf::Value;
use openusd::usd::{Prim, TimeCode};
use std::collections::BTreeMap;
use tailor_mesh::error::{Error, Warning, Warnings};
use tailor_mesh::garment::{Interpolation, PrimvarInput, PrimvarRole};

/// How the properties that vary over the model are declared, so that products can author them with new values.
#[derive(Clone, Debug, Default)]
pub struct Declarations {
    /// Primvars and their indices, by name without `primvars:`.
    pub primvars: BTreeMap<String, Record>,
    /// Files of the asset paths in primvars, by the path as authored.
    pub assets: BTreeMap<String, String>,
    /// Blend shapes; their numbers are those of [`PrimvarRole::BlendShape`].
    pub shapes: Vec<BlendShape>,
}

/// Reads the primvars that vary over the mesh. Those that cannot be carried become warnings. `elements` are the numbers of
/// faces, points and corners.
///
/// # Errors
/// An interpolation that USD does not have.
pub fn read_primvars(
    prim: &Prim,
    time: Option<TimeCode>,
    elements: [usize; 3],
    declarations: &mut Declarations,
) -> Result<(Vec<PrimvarInput>, Warnings), Error> {
    let (mut found, mut warnings) = (Vec::new(), Warnings::default());
    for name in primvar_names(prim)? {
        let property = format!("{}{name}", names::PRIMVARS);
        let interpolation = interpolation(prim, &property)?;
        if interpolation == Interpolation::Constant || names::is_produced(&property) {
            continue;
        }
        match read_primvar(prim, &name, interpolation, time, declarations) {
            Ok(Some(primvar)) if primvar.values.is_empty() => {
                let place = format!("{}.{property}", prim.path());
                warnings.push(Warning::not_carried(place, "it has no values; it stays on the model"));
            }
            Ok(mut primvar) => {
                if let Some(primvar) = &mut primvar {
                    warnings.extend(without_element_size(prim, primvar, elements, declarations));
                }
                found.extend(primvar);
                warnings.extend(motion(prim, &property, time)?);
            }
            Err(e) => warnings.push(Warning::unread(format!("{}.{property}", prim.path()), &e)),
        }
    }
    Ok((found, warnings))
}

/// Reads the attribute `normals` of a polygonal mesh. None where a primvar replaces it, or where it does not have one
/// readable normal for each element: it is then reported as dropped.
///
/// `elements` are the numbers of faces, points and corners.
pub fn read_normals(prim: &Prim, time: Option<TimeCode>, elements: [usize; 3]) -> Option<PrimvarInput> {
    let attribute = prim.attribute(names::NORMALS);
    let primvar = prim.attribute(format!("{}{}", names::PRIMVARS, names::NORMALS));
    if primvar.has_authored_value().unwrap_or(false) {
        return None;
    }
    let value = value(prim, names::NORMALS, time).ok()??;
    let field = attribute.get_metadata::<Value>(names::INTERPOLATION).ok()?;
    let interpolation = field.as_ref().and_then(text).map_or(Some(Interpolation::Vertex), Interpolation::from_token)?;
    let count = count_of(interpolation, elements)?;
    let Flat { meaning, half, components, values } = flat(&attribute.type_name().ok()??, value).ok()?;
    (components == 3 && values.len() == 3 * count).then(|| PrimvarInput {
        name: names::NORMALS.to_owned(),
        role: PrimvarRole::Normals,
        meaning,
        half,
        interpolation,
        components,
        element_size: 1,
        values,
        indices: None,
    })
}

/// The number of elements with a value, of those of faces, points and corners.
fn count_of(interpolation: Interpolation, [faces, points, corners]: [usize; 3]) -> Option<usize> {
    match interpolation {
        Interpolation::Constant => None,
        Interpolation::Uniform => Some(faces),
        Interpolation::Vertex | Interpolation::Varying => Some(points),
        Interpolation::FaceVarying => Some(corners),
    }
}

/// Takes a primvar as if it had no `elementSize`, where its values fit the mesh so, and not otherwise. Exports of Arnold have
/// the number of values there. Warns of it.
fn without_element_size(
    prim: &Prim,
    primvar: &mut PrimvarInput,
    elements: [usize; 3],
    declarations: &mut Declarations,
) -> Option<Warning> {
    let count = count_of(primvar.interpolation, elements)?;
    let rows = primvar.values.len() / primvar.components.max(1);
    let fits = |rows: usize| match &primvar.indices {
        Some(indices) => {
            let is_row = |&row: &i32| usize::try_from(row).is_ok_and(|row| row < rows);
            indices.len() == count && indices.iter().all(is_row)
        }
        None => rows == count,
    };
    let size = usize::try_from(primvar.element_size).unwrap_or(0);
    if size == 1 || fits(rows.checked_div(size).unwrap_or(0)) || !fits(rows) {
        return None;
    }
    let problem =
        format!("its elementSize is {}, and its values fit the mesh without; it is left out", primvar.element_size);
    primvar.element_size = 1;
    if let Some(declaration) = declarations.primvars.get_mut(&primvar.name) {
        declaration.metadata.retain(|(key, _)| key != names::ELEMENT_SIZE);
    }
    let place = format!("{}.{}{}", prim.path(), names::PRIMVARS, primvar.name);
    Some(Warning::not_carried(place, problem).remedy("Remove elementSize from the primvar"))
}

/// Reads one primvar, and adds its declaration. None when it has no value.
pub fn read_primvar(
    prim: &Prim,
    name: &str,
    interpolation: Interpolation,
    time: Option<TimeCode>,
    declarations: &mut Declarations,
) -> Result<Option<PrimvarInput>, Error> {
    let property = format!("{}{name}", names::PRIMVARS);
    let Some(value) = value(prim, &property, time)? else { return Ok(None) };
    let attribute = prim.attribute(property.as_str());
    if let Value::AssetPathVec(_) = value {
        let sites = attribute.property_stack().or_unreadable(attribute.path())?;
        let assets = resolved(value.clone(), prim.stage(), &sites).try_as_asset_path_vec();
        let files =
            assets.iter().flatten().filter_map(|a| Some((a.as_str().to_owned(), file_path(a.resolved_path()?))));
        declarations.assets.extend(files);
    }
    let declared = |property: &str| Record::take(prim, property, Depth::Declaration).or_unreadable(attribute.path());
    let Some(declaration) = declared(&property)? else { return Ok(None) };
    let Some(type_name) = declaration.type_name() else { return Ok(None) };
    let flat = flat(type_name, value).map_err(|why| Error::usd(why).code(codes::ATTRIBUTE_TYPE))?;
    let Flat { meaning, half, components, values } = flat;
    let primvar = PrimvarInput {
        name: name.to_owned(),
        role: PrimvarRole::Primvar,
        meaning,
        half,
        interpolation,
        components,
        element_size: element_size(&declaration)?,
        values,
        indices: indices(prim, &property, time)?,
    };
    let of_indices = declared(&format!("{property}{}", names::INDICES_SUFFIX))?;
    let of_indices = of_indices.map(|record| (format!("{name}{}", names::INDICES_SUFFIX), record));
    declarations.primvars.extend(of_indices);
    declarations.primvars.insert(name.to_owned(), declaration);
    Ok(Some(primvar))
}

fn element_size(declaration: &Record) -> Result<i32, Error> {
    match declaration.metadata(names::ELEMENT_SIZE) {
        None => Ok(1),
        Some(Value::Int(n)) => Ok(*n),
        Some(_) => Err(Error::usd("its elementSize is not an int").code(codes::ATTRIBUTE_TYPE)),
    }
}

fn indices(prim: &Prim, property: &str, time: Option<TimeCode>) -> Result<Option<Vec<i32>>, Error> {
    match value(prim, &format!("{property}{}", names::INDICES_SUFFIX), time)? {
        None => Ok(None),
        Some(Value::IntVec(v)) => Ok(Some(v)),
        Some(_) => Err(Error::usd("its indices are not of type int[]")
            .code(codes::ATTRIBUTE_TYPE)
            .remedy(format!("Declare {property}{} as int[]", names::INDICES_SUFFIX))),
    }
}
