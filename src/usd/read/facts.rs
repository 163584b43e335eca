//! Facts about the model and its surroundings, which `info` prints.

use super::model::Model;
use super::query::{OrUnreadable, interpolation, prim_at, primvar_names, property_names, subset_prims, value};
use super::variants::{VariantSet, variant_sets};
use crate::names;
use crate::record::{Content, Record};
use crate::values::{number, text};
use openusd::sdf::Value;
use openusd::usd::{Prim, TimeCode};
use openusd::usda::TextWriter;
use serde::Serialize;
use std::collections::BTreeMap;
use tailor_mesh::error::Error;
use tailor_mesh::garment::{Interpolation, Units};

/// The model and its surroundings.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Facts {
    /// The file as it was named.
    pub file: String,
    /// Path of the mesh.
    pub prim: String,
    /// `upAxis`, with USD's fallback.
    pub up_axis: String,
    /// `metersPerUnit`, with USD's fallback.
    pub meters_per_unit: f64,
    /// `purpose` of the mesh, with USD's fallback.
    pub purpose: String,
    /// `visibility` of the mesh, with USD's fallback.
    pub visibility: String,
    /// Local transform ops, in their order.
    pub transform: Vec<TransformOp>,
    /// Applied API schemas, known here or not.
    pub api_schemas: Vec<String>,
    /// Constant primvars of the mesh itself, by name without `primvars:`.
    pub constant_primvars: Vec<String>,
    /// Constant primvars that the mesh inherits; its siblings inherit them too.
    pub inherited_primvars: Vec<InheritedPrimvar>,
    /// Material bindings of the mesh, its ancestors and its subsets.
    pub bindings: Vec<MaterialBinding>,
    /// Properties that stay on the model: no product takes them.
    pub staying: Vec<String>,
    /// Files of all layers in use.
    pub layers: Vec<String>,
    /// Variant sets of the mesh and of its ancestors, outermost first.
    pub variants: Vec<VariantSet>,
}

/// A transform op.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct TransformOp {
    /// Its entry in `xformOpOrder`.
    pub name: String,
    /// Its value as USD writes it; empty for a marker such as `!resetXformStack!`.
    pub value: String,
    /// How many time samples it has.
    pub samples: usize,
}

/// A primvar of an ancestor.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct InheritedPrimvar {
    /// Name without `primvars:`.
    pub name: String,
    /// USD's name of the value type.
    pub type_name: String,
    /// Path of the ancestor.
    pub from: String,
}

/// A material binding.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct MaterialBinding {
    /// Path of the bound prim.
    pub prim: String,
    /// The relationship: `material:binding`, with the purpose and collection where there are any.
    pub relationship: String,
    /// Paths of the targets.
    pub targets: Vec<String>,
}

/// Gathers the facts about `prim`.
///
/// # Errors
/// A stage that cannot be queried.
pub fn gather(prim: &Prim, model: &Model, time: Option<TimeCode>) -> Result<Facts, Error> {
    // Without a time, an animated purpose or visibility has no value.
    let token = |name, fallback: &str| {
        let value = value(prim, name, time).ok().flatten();
        value.as_ref().and_then(text).unwrap_or(fallback).to_owned()
    };
    let stage = |key| model.stage_metadata.iter().find(|(k, _)| k == key).map(|(_, v)| v);
    let schemas = prim.authored_api_schemas().or_unreadable(prim.path())?;
    Ok(Facts {
        file: model.origin.file.display().to_string(),
        prim: prim.path().as_str().to_owned(),
        up_axis: stage(names::UP_AXIS).and_then(text).unwrap_or("Y").to_owned(),
        meters_per_unit: stage(names::METERS_PER_UNIT).and_then(number).unwrap_or(Units::default().meters_per_unit),
        purpose: token(names::PURPOSE, "default"),
        visibility: token(names::VISIBILITY, "inherited"),
        transform: transform(model)?,
        api_schemas: schemas.iter().map(|s| s.as_str().to_owned()).collect(),
        constant_primvars: constant_primvars(model),
        inherited_primvars: inherited(prim)?,
        bindings: bindings(prim)?,
        staying: model.staying.clone(),
        layers: model.layers.iter().map(|l| l.display().to_string()).collect(),
        variants: variant_sets(prim)?,
    })
}

fn transform(model: &Model) -> Result<Vec<TransformOp>, Error> {
    let record = |name: &str| model.carried.iter().find(|r| r.name == name);
    let order = record(names::XFORM_OP_ORDER).map(|r| &r.content);
    let Some(Content::Attribute { default: Some(Value::TokenVec(order)), .. }) = order else { return Ok(Vec::new()) };
    order
        .iter()
        .map(|op| {
            let content = record(op.strip_prefix("!invert!").unwrap_or(op)).map(|r| &r.content);
            let (default, samples) = match content {
                Some(Content::Attribute { default, samples, .. }) => (default.as_ref(), samples.as_ref()),
                _ => (None, None),
            };
            let value = default.map_or(Ok(String::new()), TextWriter::value_to_string).or_unreadable(&model.path)?;
            Ok(TransformOp { name: op.as_str().to_owned(), value, samples: samples.map_or(0, Vec::len) })
        })
        .collect()
}

fn constant_primvars(model: &Model) -> Vec<String> {
    let names = model.carried.iter().filter(|r| r.has_value()).filter_map(|r| r.name.strip_prefix(names::PRIMVARS));
    names.filter(|n| !n.ends_with(names::INDICES_SUFFIX)).map(str::to_owned).collect()
}

fn inherited(prim: &Prim) -> Result<Vec<InheritedPrimvar>, Error> {
    let mut hidden = primvar_names(prim)?;
    let mut found = Vec::new();
    for path in prim.path().strict_ancestors_below_root() {
        let ancestor = prim_at(prim.stage(), &path)?;
        for name in primvar_names(&ancestor)? {
            let property = format!("{}{name}", names::PRIMVARS);
            let attribute = ancestor.attribute(property.as_str());
            let constant = interpolation(&ancestor, &property).is_ok_and(|i| i == Interpolation::Constant);
            if !constant || hidden.contains(&name) || !attribute.has_authored_value().or_unreadable(&path)? {
                continue;
            }
            let type_name = attribute.type_name().or_unreadable(attribute.path())?;
            found.push(InheritedPrimvar {
                name: name.clone(),
                type_name: type_name.map_or_else(|| "unknown".to_owned(), |t| t.as_str().to_owned()),
                from: path.as_str().to_owned(),
            });
            hidden.push(name);
        }
    }
    Ok(found)
}

/// The names of [`material_paths`].
pub fn materials(paths: &BTreeMap<String, String>) -> BTreeMap<String, String> {
    let name = |path: &String| path.rsplit('/').next().unwrap_or_default().to_owned();
    paths.iter().map(|(subset, path)| (subset.clone(), name(path))).collect()
}

/// The path of the material of each subset that has one; that of the whole mesh, or else of the nearest prim above it that has
/// one, under an empty name.
pub fn material_paths(model: &Model, facts: &Facts) -> BTreeMap<String, String> {
    let of_records = |records: &[Record]| {
        let binding = records.iter().find(|record| record.name == names::MATERIAL_BINDING)?;
        let Content::Relationship { targets, .. } = &binding.content else { return None };
        targets.first().map(|target| target.as_str().to_owned())
    };
    let is_above = |binding: &&MaterialBinding| {
        let path = model.path.as_str().strip_prefix(&binding.prim);
        binding.relationship == names::MATERIAL_BINDING && path.is_some_and(|below| below.starts_with('/'))
    };
    let above = || facts.bindings.iter().find(is_above)?.targets.first().cloned();
    let whole = of_records(&model.carried).or_else(above).map(|material| (String::new(), material));
    let subsets =
        model.subsets.iter().filter_map(|(subset, record)| Some((subset.clone(), of_records(&record.carried)?)));
    subsets.chain(whole).collect()
}

fn bindings(prim: &Prim) -> Result<Vec<MaterialBinding>, Error> {
    let mut prims = vec![prim.clone()];
    for path in prim.path().strict_ancestors_below_root() {
        prims.push(prim_at(prim.stage(), &path)?);
    }
    prims.extend(subset_prims(prim)?);
    let mut found = Vec::new();
    for bound in &prims {
        for relationship in property_names(bound)?.into_iter().filter(|n| n.starts_with(names::MATERIAL_BINDING)) {
            let targets = bound.relationship(relationship.as_str()).targets().or_unreadable(bound.path())?;
            if !targets.is_empty() {
                let (prim, targets) = (bound.path().to_string(), targets.iter().map(ToString::to_string).collect());
                found.push(MaterialBinding { prim, relationship, targets });
            }
        }
    }
    Ok(found)
}
