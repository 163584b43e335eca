//! The recipe in the model's own properties, as JSON.

use super::query::{OrUnreadable, is_a, prim_at, prim_name, property_names, subset_prims, value};
use crate::assets::file_path;
use crate::names;
use crate::values::{decimal, text};
use openusd::sdf::{self, FieldKey, Value};
use openusd::usd::{Prim, TimeCode};
use serde_json::{Map, Value as Json, json};
use std::path::Path as FilePath;
use tailor_mesh::error::Error;
use tailor_mesh::files::folder_of;

/// Parts of the name of an option. Nested options are handled level by level.
const MOST_PARTS: usize = 100;

/// The options of a mesh: its own, and weaker ones of the prims that it is in, the nearest first.
///
/// # Errors
/// As [`options_of`].
pub fn read_recipe(mesh: &Prim, time: Option<TimeCode>) -> Result<Map<String, Json>, Error> {
    let mut recipe = options_of(mesh, mesh, time)?;
    let mut place = mesh.path().parent();
    while let Some(path) = place.filter(|path| !path.is_abs_root()) {
        add_weaker(&mut recipe, options_of(&prim_at(mesh.stage(), &path)?, mesh, time)?);
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

/// Every property of `prim` in the namespace `tailor:`, as nested objects.
///
/// # Errors
/// A value that JSON cannot hold, a name that is both a value and a namespace, a target that is not a subset of `mesh`.
fn options_of(prim: &Prim, mesh: &Prim, time: Option<TimeCode>) -> Result<Map<String, Json>, Error> {
    let mut recipe = Map::new();
    for name in property_names(prim)? {
        let Some(key) = name.strip_prefix(names::RECIPE).filter(|_| !names::is_produced(&name)) else { continue };
        if key.matches(':').count() > MOST_PARTS {
            let start: String = name.chars().take(60).collect();
            let problem = format!("{}.{start}...: the name has more than {MOST_PARTS} parts", prim.path());
            return Err(Error::usd(problem)
                .code(tailor_costume::codes::RECIPE_ATTRIBUTE)
                .remedy("give it a shorter name"));
        }
        let kind = prim.prim_index().property_type(name.as_str()).or_unreadable(prim.path())?;
        let value = match kind {
            _ if names::is_trim_prims(&name) => trim_prims(prim, &name, time)?,
            _ if names::is_body(&name) => body_file(prim, &name, time)?,
            Some(sdf::SpecType::Relationship) => targets(prim, mesh, &name)?,
            _ => option_value(prim, &name, time)?,
        };
        if let Some(value) = value {
            insert(&mut recipe, key, value).ok_or_else(|| {
                Error::usd(format!("{}.{name} is both a value and a namespace", prim.path()))
                    .code(tailor_costume::codes::RECIPE_ATTRIBUTE)
                    .remedy("remove one of the two")
            })?;
        }
    }
    Ok(recipe)
}

/// The prims of a trim: the targets of a relationship, or the value of an attribute.
///
/// # Errors
/// A value of another type.
pub fn trim_prims(prim: &Prim, name: &str, time: Option<TimeCode>) -> Result<Option<Json>, Error> {
    let kind = prim.prim_index().property_type(name).or_unreadable(prim.path())?;
    if kind == Some(sdf::SpecType::Relationship) {
        let paths = prim.relationship(name).targets().or_unreadable(prim.path())?;
        return Ok(Some(paths.iter().map(|path| Json::String(path.to_string())).collect()));
    }
    option_value(prim, name, time)
}

/// The file of a body: relative paths are those beside the layer that has them.
fn body_file(prim: &Prim, name: &str, time: Option<TimeCode>) -> Result<Option<Json>, Error> {
    let named = match value(prim, name, time)? {
        Some(Value::AssetPath(asset)) => asset.into_string(),
        Some(other) => match text(&other) {
            Some(text) => text.to_owned(),
            None => return option_value(prim, name, time),
        },
        None => return Ok(None),
    };
    if named.is_empty() {
        return Ok(Some(Json::String(named)));
    }
    for site in prim.prim_stack().or_unreadable(prim.path())? {
        let (Some(layer), Ok(path)) = (prim.stage().layer(&site.layer), site.path.append_property(name)) else {
            continue;
        };
        let has_value = [FieldKey::Default, FieldKey::TimeSamples]
            .iter()
            .any(|key| layer.data().try_field(&path, key.as_str()).is_ok_and(|field| field.is_some()));
        if let Some(file) = layer.resolved_path().filter(|_| has_value) {
            let folder = folder_of(FilePath::new(&file_path(file))).to_path_buf();
            return Ok(Some(Json::String(folder.join(&named).to_string_lossy().into_owned())));
        }
    }
    Ok(Some(Json::String(named)))
}

/// The value of an attribute that is an option.
fn option_value(prim: &Prim, name: &str, time: Option<TimeCode>) -> Result<Option<Json>, Error> {
    let Some(value) = value(prim, name, time)? else { return Ok(None) };
    to_json(&value).map(Some).ok_or_else(|| {
        Error::usd(format!("{}.{name} has a type that no recipe field has", prim.path()))
            .code(tailor_costume::codes::RECIPE_ATTRIBUTE)
            .remedy("recipe fields are bool, int, float, double, token or string, or arrays of them")
    })
}

/// Inserts `value` at `key` (`a:b:c`); none when the place is taken.
fn insert(into: &mut Map<String, Json>, key: &str, value: Json) -> Option<()> {
    let Some((space, rest)) = key.split_once(':') else {
        return into.insert(key.to_owned(), value).is_none().then_some(());
    };
    let space = into.entry(space).or_insert_with(|| Json::Object(Map::new()));
    insert(space.as_object_mut()?, rest, value)
}

/// Names of the subsets that a relationship targets. A prim above several meshes may target subsets of each: those of others are
/// left out, and where all are, the mesh has no such option.
fn targets(prim: &Prim, mesh: &Prim, name: &str) -> Result<Option<Json>, Error> {
    let subsets = subset_prims(mesh)?;
    let targets = prim.relationship(name).targets().or_unreadable(prim.path())?;
    let mut found = Vec::with_capacity(targets.len());
    let mut is_of_others = false;
    for target in targets {
        if let Some(subset) = subsets.iter().find(|s| *s.path() == target) {
            found.push(Json::String(prim_name(subset)));
        } else if prim.path() != mesh.path() && is_a(&prim_at(mesh.stage(), &target)?, names::GEOM_SUBSET)? {
            is_of_others = true;
        } else {
            let known: Vec<_> = subsets.iter().map(prim_name).collect();
            return Err(Error::usd(format!(
                "{}.{name} targets {target}, which is not a GeomSubset of the mesh",
                prim.path()
            ))
            .code(tailor_costume::codes::RECIPE_ATTRIBUTE)
            .remedy(format!("target one of its subsets: {}", known.join(", "))));
        }
    }
    Ok((!found.is_empty() || !is_of_others).then_some(Json::Array(found)))
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

/// Makes a set one of the constraints of the simulation mesh.
pub fn add_constraint(options: &mut Map<String, Json>, set: &str) {
    let sim = options.entry("sim").or_insert_with(|| Json::Object(Map::new()));
    if let Json::Object(sim) = sim {
        let constraints = sim.entry("constraints").or_insert_with(|| Json::Array(Vec::new()));
        if let Json::Array(constraints) = constraints {
            constraints.push(set.into());
        }
    }
}
