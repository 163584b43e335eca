//! The recipe in the model's own properties, as JSON.

use super::choose::all_meshes;
use super::query::{OrUnreadable, is_product, prim_at, prim_name, property_names, subset_prims, value};
use crate::error::{Code, Error, ErrorCode, Warning};
use crate::usd::names;
use crate::usd::values::{decimal, text};
use openusd::sdf::{self, Value};
use openusd::usd::{Prim, Stage, TimeCode};
use serde_json::{Map, Value as Json, json};
use std::path::Path;

/// The options of a mesh: its own, and weaker ones of the prims that it is in, where it is the only mesh there. Options above
/// several meshes are left out with a warning.
///
/// # Errors
/// As [`options_of`].
pub fn read_recipe(
    stage: &Stage,
    file: &Path,
    mesh: &Prim,
    time: Option<TimeCode>,
    warnings: &mut Vec<Warning>,
) -> Result<Map<String, Json>, Error> {
    let mut recipe = options_of(mesh, mesh, time)?;
    let mut place = mesh.path().parent();
    while let Some(path) = place.filter(|path| !path.is_abs_root()) {
        let above = prim_at(stage, &path)?;
        if property_names(&above)?.iter().any(|name| option_key(name).is_some()) {
            if is_only_mesh(stage, file, mesh, &path)? {
                add_weaker(&mut recipe, options_of(&above, mesh, time)?);
            } else {
                let problem = "its options are not used: it holds several meshes";
                let remedy =
                    format!("Move its tailor: properties to the mesh that they are for, such as {}", mesh.path());
                warnings.push(Warning::new(Code::MisplacedOptions, &path, problem).remedy(remedy));
            }
        }
        place = path.parent();
    }
    Ok(recipe)
}

/// Adds options that are not there.
fn add_weaker(options: &mut Map<String, Json>, weaker: Map<String, Json>) {
    for (key, value) in weaker {
        match (options.get_mut(&key), value) {
            (Some(Json::Object(stronger)), Json::Object(value)) => add_weaker(stronger, value),
            (Some(_), _) => {}
            (None, value) => drop(options.insert(key, value)),
        }
    }
}

/// Whether a mesh is the only one below `path` that is no product.
fn is_only_mesh(stage: &Stage, file: &Path, mesh: &Prim, path: &sdf::Path) -> Result<bool, Error> {
    for other in all_meshes(stage, file)?.into_iter().filter(|other| other.has_prefix(path) && other != mesh.path()) {
        if !is_product(&prim_at(stage, &other)?)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// The key of an option by its property's name, such as `sim:maxEdgeLength`; none for other properties.
fn option_key(name: &str) -> Option<&str> {
    name.strip_prefix(names::RECIPE).filter(|_| !names::is_produced(name))
}

/// Every property of `prim` in the namespace `tailor:`, as nested objects.
///
/// # Errors
/// A value that JSON cannot hold, a name that is both a value and a namespace, a target that is no subset of `mesh`.
fn options_of(prim: &Prim, mesh: &Prim, time: Option<TimeCode>) -> Result<Map<String, Json>, Error> {
    let mut recipe = Map::new();
    for name in property_names(prim)? {
        let Some(key) = option_key(&name) else { continue };
        let kind = prim.prim_index().property_type(name.as_str()).or_unreadable(prim.path())?;
        let value = match kind {
            Some(sdf::SpecType::Relationship) => Some(targets(prim, mesh, &name)?),
            _ => match value(prim, &name, time)? {
                None => None,
                Some(value) => Some(to_json(&value).ok_or_else(|| {
                    Error::usd(format!("{}.{name} has a type that no recipe field has", prim.path()))
                        .code(ErrorCode::RecipeAttribute)
                        .remedy("recipe fields are bool, int, float, double, token or string, or arrays of them")
                })?),
            },
        };
        if let Some(value) = value {
            insert(&mut recipe, key, value).ok_or_else(|| {
                Error::usd(format!("{}.{name} is both a value and a namespace", prim.path()))
                    .code(ErrorCode::RecipeAttribute)
                    .remedy("remove one of the two")
            })?;
        }
    }
    Ok(recipe)
}

/// Inserts `value` at `key` (`a:b:c`); none when the place is taken.
fn insert(into: &mut Map<String, Json>, key: &str, value: Json) -> Option<()> {
    let Some((space, rest)) = key.split_once(':') else {
        return into.insert(key.to_owned(), value).is_none().then_some(());
    };
    let space = into.entry(space).or_insert_with(|| Json::Object(Map::new()));
    insert(space.as_object_mut()?, rest, value)
}

/// Names of the subsets that a relationship targets.
fn targets(prim: &Prim, mesh: &Prim, name: &str) -> Result<Json, Error> {
    let subsets = subset_prims(mesh)?;
    let targets = prim.relationship(name).targets().or_unreadable(prim.path())?;
    let mut found = Vec::with_capacity(targets.len());
    for target in targets {
        let Some(subset) = subsets.iter().find(|s| *s.path() == target) else {
            let known: Vec<_> = subsets.iter().map(prim_name).collect();
            return Err(Error::usd(format!(
                "{}.{name} targets {target}, which is no GeomSubset of the mesh",
                prim.path()
            ))
            .code(ErrorCode::RecipeAttribute)
            .remedy(format!("target one of its subsets: {}", known.join(", "))));
        };
        found.push(Json::String(prim_name(subset)));
    }
    Ok(Json::Array(found))
}

fn to_json(value: &Value) -> Option<Json> {
    Some(match value {
        Value::Bool(v) => json!(v),
        Value::Int(v) => json!(v),
        Value::Uint(v) => json!(v),
        Value::Int64(v) => json!(v),
        Value::Uint64(v) => json!(v),
        Value::Uchar(v) => json!(v),
        Value::Half(v) => json!(decimal(v.to_f32())),
        Value::Float(v) => json!(decimal(*v)),
        Value::Double(v) => json!(v),
        Value::IntVec(v) => json!(v),
        Value::DoubleVec(v) => json!(v),
        Value::FloatVec(v) => v.iter().map(|f| json!(decimal(*f))).collect(),
        Value::StringVec(v) => json!(v),
        Value::TokenVec(v) => v.iter().map(|t| t.as_str()).collect(),
        other => json!(text(other)?),
    })
}
