//! What the writer gives back of the model as it was, and what it needs to know of the model's surroundings.

use super::UsdError;
use super::assets::settle;
use super::choose::{prim_at, product_role, unreadable};
use super::geometry::{prim_name, subset_prims};
use super::names;
use super::origin::Origin;
use super::record::{Content, Depth, Record, is_children, metadata};
use super::shapes::Shape;
use crate::error::Warning;
use openusd::sdf::{self, FieldKey, Value};
use openusd::tf::Token;
use openusd::usd::{Prim, Stage, TimeCode};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// The model and its surroundings, free of the stage.
#[derive(Clone, Debug)]
pub struct Model {
    /// The model's path.
    pub path: sdf::Path,
    /// Properties that products take as they are.
    pub carried: Vec<Record>,
    /// Declarations of the primvars that products state anew, by name without `primvars:`.
    pub primvars: BTreeMap<String, Record>,
    /// Applied schemas that products take.
    pub applied: Vec<Token>,
    /// The model's subsets.
    pub subsets: BTreeMap<String, SubsetRecord>,
    /// The model's blend shapes.
    pub shapes: Vec<Shape>,
    /// Names of the properties that stay on the model alone.
    pub staying: Vec<String>,
    /// The prims beside the model.
    pub siblings: BTreeMap<String, Sibling>,
    /// Where the asset paths in primvars point, by the path as authored.
    pub assets: BTreeMap<String, String>,
    /// What was opened.
    pub origin: Origin,
    /// The files of all layers in use.
    pub layers: Vec<PathBuf>,
    /// The stage's own metadata.
    pub stage_metadata: Vec<(String, Value)>,
}

/// What a product's subset takes from the model's subset of the same name.
#[derive(Clone, Debug, Default)]
pub struct SubsetRecord {
    /// Metadata of the prim.
    pub metadata: Vec<(String, Value)>,
    /// Applied schemas.
    pub applied: Vec<Token>,
    /// Material bindings, and the sharpness of what were creases.
    pub carried: Vec<Record>,
}

/// A prim beside the model.
#[derive(Clone, Debug)]
pub struct Sibling {
    /// Whether this program wrote it.
    pub product: bool,
    /// Declarations of what it holds, when this program wrote it.
    pub properties: Vec<Record>,
    /// Names of the prims below it, when this program wrote it.
    pub children: Vec<String>,
}

/// Metadata of prims that says how they compose.
pub const COMPOSITION: &[FieldKey] = &[
    FieldKey::References,
    FieldKey::Payload,
    FieldKey::InheritPaths,
    FieldKey::Specializes,
    FieldKey::VariantSetNames,
    FieldKey::VariantSelection,
    FieldKey::Relocates,
    FieldKey::Instanceable,
    FieldKey::Clips,
    FieldKey::ClipSets,
    FieldKey::Specifier,
    FieldKey::TypeName,
    FieldKey::ApiSchemas,
];

/// Metadata of the root layer that is the layer's own and not the stage's.
const LAYER_METADATA: &[FieldKey] = &[
    FieldKey::SubLayers,
    FieldKey::SubLayerOffsets,
    FieldKey::LayerRelocates,
    FieldKey::PrimOrder,
    FieldKey::Documentation,
    FieldKey::Comment,
    FieldKey::CustomLayerData,
    FieldKey::Owner,
    FieldKey::SessionOwner,
    FieldKey::HasOwnedSubLayers,
];

impl Model {
    /// Takes what the writer needs of `prim`.
    ///
    /// # Errors
    /// A stage that cannot be queried.
    pub fn take(
        prim: &Prim,
        origin: Origin,
        time: Option<TimeCode>,
        warnings: &mut Vec<Warning>,
    ) -> Result<Self, UsdError> {
        let mut model = Self {
            path: prim.path().clone(),
            carried: Vec::new(),
            primvars: BTreeMap::new(),
            applied: applied(prim, &[names::MATERIAL_BINDING_API, names::SKEL_BINDING_API])?,
            subsets: BTreeMap::new(),
            shapes: Vec::new(),
            staying: Vec::new(),
            siblings: siblings(prim)?,
            assets: BTreeMap::new(),
            origin,
            layers: layer_files(prim.stage()),
            stage_metadata: stage_metadata(prim.stage()),
        };
        for name in prim.authored_property_names().map_err(|e| unreadable(prim, &e))? {
            model.take_property(prim, &name, time, warnings);
        }
        for subset in subset_prims(prim)? {
            model.subsets.insert(prim_name(&subset), subset_record(&subset, prim.path(), warnings)?);
        }
        Ok(model)
    }

    fn take_property(&mut self, prim: &Prim, name: &str, time: Option<TimeCode>, warnings: &mut Vec<Warning>) {
        if names::REWRITTEN.contains(&name) || name.starts_with(names::SUBSET_FAMILY) || name.starts_with(names::RECIPE)
        {
            return;
        }
        let mut not_carried = |why: String| {
            warnings.push(Warning::NotCarried { what: format!("{}.{name}", prim.path()), why });
        };
        let copied = names::COPIED.contains(&name)
            || name.starts_with(names::XFORM_OP)
            || name.starts_with(names::MATERIAL_BINDING)
            || name.starts_with(names::PRIMVARS);
        let depth = if copied { Depth::Whole } else { Depth::Declaration };
        if let Some((_, why)) = names::NOT_CARRIED.iter().find(|(n, _)| *n == name) {
            if has_value(prim, name) {
                not_carried((*why).to_owned());
            }
            return;
        }
        let varying = self.is_varying(prim, name);
        match Record::take(prim, name, if varying { Depth::Declaration } else { depth }) {
            Ok(None) => {}
            Ok(Some(_)) if !copied => self.staying.push(name.to_owned()),
            Ok(Some(record)) if varying => self.take_primvar(prim, record, time),
            Ok(Some(record)) => match inward_collection(&record, prim.path()) {
                Some(why) => not_carried(why),
                None => self.carried.push(record),
            },
            Err(e) if copied && !varying => not_carried(format!("it cannot be read: {e}")),
            Err(_) => {}
        }
    }

    /// Whether a property belongs to a primvar that is not constant.
    fn is_varying(&self, prim: &Prim, name: &str) -> bool {
        let Some(primvar) = name.strip_prefix(names::PRIMVARS) else { return false };
        let base = primvar.strip_suffix(names::INDICES_SUFFIX).unwrap_or(primvar);
        super::primvars::interpolation(prim, base).is_ok_and(|i| i != crate::garment::Interpolation::Constant)
    }

    fn take_primvar(&mut self, prim: &Prim, record: Record, time: Option<TimeCode>) {
        let name = record.name.strip_prefix(names::PRIMVARS).unwrap_or_default().to_owned();
        let attribute = prim.attribute(record.name.as_str());
        if let Ok(Some(value @ Value::AssetPathVec(_))) = attribute.get_at::<Value>(time) {
            let value = settle(prim.stage(), &attribute.property_stack().unwrap_or_default(), value);
            for asset in value.try_as_asset_path_vec().unwrap_or_default() {
                if let Some(file) = asset.resolved_path() {
                    self.assets.insert(asset.as_str().to_owned(), file.to_owned());
                }
            }
        }
        self.primvars.insert(name, record);
    }
}

fn has_value(prim: &Prim, name: &str) -> bool {
    match Record::take(prim, name, Depth::Whole) {
        Ok(record) => record.is_some_and(|r| r.has_value()),
        Err(_) => true,
    }
}

/// Why a material binding by a collection that the model itself holds is not carried.
fn inward_collection(record: &Record, model: &sdf::Path) -> Option<String> {
    let Content::Relationship { targets } = &record.content else { return None };
    let inward = record.name.starts_with(names::MATERIAL_BINDING_COLLECTION)
        && targets.iter().any(|t| t.is_property_path() && t.prim_path().has_prefix(model));
    inward.then(|| "it binds by a collection of the model, which holds no prim of a product".to_owned())
}

/// The applied schemas of a prim, of those in `wanted`.
fn applied(prim: &Prim, wanted: &[&str]) -> Result<Vec<Token>, UsdError> {
    let mut all = prim.authored_api_schemas().map_err(|e| unreadable(prim, &e))?;
    all.retain(|schema| wanted.contains(&schema.as_str()));
    Ok(all)
}

fn subset_record(subset: &Prim, model: &sdf::Path, warnings: &mut Vec<Warning>) -> Result<SubsetRecord, UsdError> {
    let fault = |e: openusd::Error| unreadable(subset, &e);
    let mut fields = metadata(subset.stage(), subset.path(), &subset.prim_stack().map_err(fault)?).map_err(fault)?;
    fields.retain(|(key, _)| !COMPOSITION.iter().any(|k| k.as_str() == key));
    let mut carried = Vec::new();
    for name in subset.authored_property_names().map_err(fault)? {
        if !name.starts_with(names::MATERIAL_BINDING) && name != names::SHARPNESS {
            continue;
        }
        let Some(record) = Record::take(subset, &name, Depth::Whole).map_err(fault)? else { continue };
        match inward_collection(&record, model) {
            Some(why) => warnings.push(Warning::NotCarried { what: format!("{}.{name}", subset.path()), why }),
            None => carried.push(record),
        }
    }
    Ok(SubsetRecord { metadata: fields, applied: applied(subset, &[names::MATERIAL_BINDING_API])?, carried })
}

fn siblings(prim: &Prim) -> Result<BTreeMap<String, Sibling>, UsdError> {
    let stage = prim.stage();
    let parent = prim.path().parent().unwrap_or_else(sdf::Path::abs_root);
    let children = prim_at(stage, &parent)?.child_names().map_err(|e| unreadable(prim, &e))?;
    let mut found = BTreeMap::new();
    for name in children {
        let path = parent.append_path(name.as_str()).map_err(|e| UsdError::new(e.to_string()))?;
        if path != *prim.path() {
            found.insert(name.as_str().to_owned(), sibling(&prim_at(stage, &path)?)?);
        }
    }
    Ok(found)
}

fn sibling(prim: &Prim) -> Result<Sibling, UsdError> {
    if product_role(prim).is_none() {
        return Ok(Sibling { product: false, properties: Vec::new(), children: Vec::new() });
    }
    let fault = |e: openusd::Error| unreadable(prim, &e);
    let mut properties = Vec::new();
    for name in prim.authored_property_names().map_err(fault)? {
        properties.extend(Record::take(prim, &name, Depth::Declaration).map_err(fault)?);
    }
    let children = prim.child_names().map_err(fault)?.iter().map(|c| c.as_str().to_owned()).collect();
    Ok(Sibling { product: true, properties, children })
}

/// The files of all layers that composition has loaded; a package stands for the layers inside it.
fn layer_files(stage: &Stage) -> Vec<PathBuf> {
    let mut files: Vec<_> = stage
        .layer_identifiers()
        .iter()
        .map(|id| {
            let file = stage.layer(id).and_then(|layer| layer.resolved_path().map(str::to_owned));
            let file = file.unwrap_or_else(|| id.clone());
            PathBuf::from(file.split('[').next().unwrap_or_default())
        })
        .collect();
    files.sort();
    files.dedup();
    files
}

fn stage_metadata(stage: &Stage) -> Vec<(String, Value)> {
    let layer = stage.root_layer();
    let root = sdf::Path::abs_root();
    let mut keys = layer.data().list_fields(&root).unwrap_or_default();
    keys.retain(|key| !is_children(key) && !LAYER_METADATA.iter().any(|k| k.as_str() == key));
    keys.sort();
    keys.into_iter()
        .filter_map(|key| {
            let value = layer.data().try_field(&root, &key).ok()??.into_owned();
            Some((key, value))
        })
        .collect()
}
