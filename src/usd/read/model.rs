//! The parts of the model and its surroundings that the writer needs.

use super::bindings::{follow_variants, resolve_collections};
use super::choose::{instancer_of, purpose_of, without_purpose};
use super::origin::{ReadFiles, StageOrigin, first_used, package_file};
use super::primvars::Declarations;
use super::query::{OrUnreadable, interpolation, prim_name, property_names, subset_prims};
use super::space::{Transforms, transforms};
use super::surroundings::{KnownSurroundings, Siblings};
use super::variants::SESSION;
use crate::assets::same_file;
use crate::names;
use crate::record::{Depth, NO_SPLINE, Record, is_children, metadata};
use openusd::sdf::{self, FieldKey, Value};
use openusd::tf::Token;
use openusd::usd::{Prim, Stage, TimeCode};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tailor_mesh::error::{Error, Warning, Warnings};
use tailor_mesh::garment::Interpolation;

/// The model and its surroundings, free of the stage.
#[derive(Clone, Debug)]
pub struct Model {
    /// The model's purpose, its own or from above.
    pub purpose: Option<String>,
    /// The prims below its meshes that would inherit another purpose.
    pub below: Vec<sdf::Path>,
    /// The PointInstancer that repeats it.
    pub instancer: Option<sdf::Path>,
    /// The model's path; that of the first of several panels.
    pub path: sdf::Path,
    /// The meshes that it consists of: itself, or the panels that are sewn together.
    pub panels: Vec<sdf::Path>,
    /// How the points of its meshes become those of the garment; nothing where they are the same.
    pub sewing: Sewing,
    /// The prim below which products go.
    pub parent: sdf::Path,
    /// Properties that products copy.
    pub carried: Vec<Record>,
    /// Declarations of the properties that products author with new values.
    pub declarations: Declarations,
    /// Applied schemas that products have too.
    pub applied: Vec<Token>,
    /// The model's subsets.
    pub subsets: BTreeMap<String, SubsetRecord>,
    /// Names of the properties that no product has.
    pub staying: Vec<String>,
    /// The siblings of the model, by name.
    pub siblings: Arc<Siblings>,
    /// The file or bytes of the stage.
    pub origin: StageOrigin,
    /// The files of all layers in use.
    pub layers: Vec<PathBuf>,
    /// Its transforms.
    pub transforms: Transforms,
    /// The stage's own metadata.
    pub stage_metadata: Vec<(String, Value)>,
}

/// Meshes in the one to which they are sewn, or a mesh whose own borders are sewn.
#[derive(Clone, Debug, Default)]
pub struct Sewing {
    /// The face set of each panel.
    pub sets: Vec<String>,
    /// The point of the sewn mesh behind each point of each panel, one panel after the other.
    pub points: Vec<usize>,
    /// The ends of the edges of a lone mesh before it was sewn, the lower one first.
    pub edges: Vec<[usize; 2]>,
}

/// The properties of a subset that the product's subset of the same name copies.
#[derive(Clone, Debug, Default)]
pub struct SubsetRecord {
    /// Metadata of the prim.
    pub metadata: Vec<(String, Value)>,
    /// Applied schemas.
    pub applied: Vec<Token>,
    /// Material bindings, and the sharpness of former creases.
    pub carried: Vec<Record>,
}

/// Metadata of prims that describes their composition.
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

/// Metadata of the root layer that belongs to the layer alone.
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

/// How products treat a property of the model.
enum Treatment {
    /// Products author it from their mesh, or have no use for it.
    Rewritten,
    /// Products have a copy.
    Copied,
    /// It is dropped with a warning, which gives the reason.
    Dropped(&'static str),
    /// It stays on the model.
    Stays,
}

impl Treatment {
    fn of(prim: &Prim, name: &str) -> Self {
        let is_in = |spaces: &[&str]| spaces.iter().any(|space| name.starts_with(space));
        let rewritten = [names::SUBSET_FAMILY, names::RECIPE, names::MATERIAL_BINDING_COLLECTION];
        if names::REWRITTEN.contains(&name) || is_in(&rewritten) {
            return Self::Rewritten;
        }
        if let Some((_, why)) = names::NOT_CARRIED.iter().find(|(n, _)| *n == name) {
            return Self::Dropped(why);
        }
        if name.starts_with(names::PRIMVARS) {
            let primvar = name.strip_suffix(names::INDICES_SUFFIX).unwrap_or(name);
            // An interpolation that USD does not know is an error of the mesh.
            let constant = interpolation(prim, primvar).is_ok_and(|i| i == Interpolation::Constant);
            return if constant { Self::Copied } else { Self::Rewritten };
        }
        let copied = names::COPIED.contains(&name) || is_in(&[names::XFORM_OP, names::MATERIAL_BINDING]);
        if copied { Self::Copied } else { Self::Stays }
    }
}

impl Model {
    /// Copies what the writer needs of `prim`. `has_normals` tells whether products have its normals. Warns of properties that
    /// products lack.
    ///
    /// # Errors
    /// A stage that cannot be queried.
    pub fn take(
        prim: &Prim,
        time: Option<TimeCode>,
        origin: StageOrigin,
        declarations: Declarations,
        has_normals: bool,
        known: &mut KnownSurroundings,
    ) -> Result<(Self, Warnings), Error> {
        let mut model = Self {
            purpose: purpose_of(prim)?,
            below: without_purpose(prim)?,
            instancer: instancer_of(prim.path(), known.repeated(prim.stage(), &origin)).cloned(),
            path: prim.path().clone(),
            panels: vec![prim.path().clone()],
            sewing: Sewing::default(),
            parent: prim.path().parent().expect("the path of a prim has a parent"),
            carried: Vec::new(),
            declarations,
            applied: applied(prim, &[names::MATERIAL_BINDING_API, names::SKEL_BINDING_API])?,
            subsets: BTreeMap::new(),
            staying: Vec::new(),
            siblings: Arc::default(),
            layers: layer_files(prim.stage(), &origin.read),
            origin,
            transforms: transforms(prim, time)?,
            stage_metadata: stage_metadata(prim.stage())?,
        };
        model.siblings = known.siblings(prim.stage(), &model)?;
        let mut warnings = Warnings::default();
        if let Some(instancer) = &model.instancer {
            let why = format!("{instancer} repeats it; its instances show the garment and keep its purpose");
            warnings.push(Warning::not_carried(format!("the instances of {}", prim.path()), why));
        }
        let naming = known.namings(prim.stage(), &model.origin).iter();
        warnings.extend(naming.filter_map(|naming| naming.misses_products(prim.path())));
        for name in property_names(prim)? {
            if !(has_normals && name == names::NORMALS) {
                warnings.extend(model.take_property(prim, &name));
            }
        }
        follow_variants(prim, &mut model.carried, &mut model.applied)?;
        for subset in subset_prims(prim)? {
            model.subsets.insert(prim_name(&subset), subset_record(&subset)?);
        }
        resolve_collections(prim, &mut model)?;
        Ok((model, warnings))
    }

    /// Whether it consists of panels that are sewn together.
    pub fn is_sewn(&self) -> bool {
        self.panels.len() > 1
    }

    /// Whether the stage uses a file, under any selection of variants.
    ///
    /// # Errors
    /// A stage of too many layers.
    pub fn uses(&self, file: &Path) -> Result<bool, Error> {
        let is_layer = self.layers.iter().any(|layer| same_file(layer, file));
        Ok(is_layer || first_used(&self.origin.file, &[file.to_path_buf()])?.is_some())
    }

    /// The path of a sibling of the model.
    ///
    /// # Errors
    /// A name that no prim can have.
    pub fn sibling_path(&self, name: &str) -> Result<sdf::Path, sdf::PathParseError> {
        self.parent.append_path(name)
    }

    /// Its name below the parent of its products, by which they know it. Panels have that of the first of them.
    pub fn name(&self) -> String {
        let path = self.path.as_str();
        path.strip_prefix(self.parent.as_str()).unwrap_or(path).trim_start_matches('/').to_owned()
    }

    /// Whether one of its meshes has this name below the parent of its products.
    pub fn has_panel(&self, name: &str) -> bool {
        self.sibling_path(name).is_ok_and(|path| self.panels.contains(&path))
    }

    /// Takes what products have of a property. Warns of one that they lack.
    fn take_property(&mut self, prim: &Prim, name: &str) -> Option<Warning> {
        let why = match Treatment::of(prim, name) {
            Treatment::Rewritten => None,
            Treatment::Stays => {
                self.staying.push(name.to_owned());
                None
            }
            Treatment::Dropped(why) => {
                let record = Record::take(prim, name, Depth::Whole);
                let is_empty = record.is_ok_and(|r| r.is_none_or(|r| !r.has_value()));
                (!is_empty).then(|| why.to_owned())
            }
            Treatment::Copied => match Record::take(prim, name, Depth::Whole) {
                Ok(record) => {
                    let has_spline = record.as_ref().is_some_and(|record| record.has_spline);
                    self.carried.extend(record);
                    let why = || format!("{NO_SPLINE}; animate a prim above the mesh, or by time samples");
                    has_spline.then(why)
                }
                Err(e) => Some(format!("it cannot be read: {e}")),
            },
        };
        why.map(|why| Warning::not_carried(format!("{}.{name}", prim.path()), why))
    }
}

/// The applied schemas of a prim that are in `wanted`.
fn applied(prim: &Prim, wanted: &[&str]) -> Result<Vec<Token>, Error> {
    let mut all = prim.authored_api_schemas().or_unreadable(prim.path())?;
    all.retain(|schema| wanted.contains(&schema.as_str()));
    Ok(all)
}

/// The records of a subset on products.
fn subset_record(subset: &Prim) -> Result<SubsetRecord, Error> {
    let path = subset.path();
    let sites = subset.prim_stack().or_unreadable(path)?;
    let mut fields = metadata(subset.stage(), path, &sites).or_unreadable(path)?;
    fields.retain(|(key, _)| !COMPOSITION.iter().any(|k| k.as_str() == key));
    let mut carried = Vec::new();
    for name in property_names(subset)? {
        let is_direct = names::is_material(&name) && !name.starts_with(names::MATERIAL_BINDING_COLLECTION);
        if is_direct || name == names::SHARPNESS {
            carried.extend(Record::take(subset, &name, Depth::Whole).or_unreadable(path)?);
        }
    }
    let mut applied = applied(subset, &[names::MATERIAL_BINDING_API])?;
    follow_variants(subset, &mut carried, &mut applied)?;
    Ok(SubsetRecord { metadata: fields, applied, carried })
}

/// The files of all layers that composition has loaded, with the package for layers inside one, and those of a stage that was flattened.
pub fn layer_files(stage: &Stage, read: &ReadFiles) -> Vec<PathBuf> {
    let mut files: Vec<_> = stage
        .layer_identifiers()
        .iter()
        .filter(|id| *id != SESSION)
        .map(|id| {
            let file = stage.layer(id).and_then(|layer| layer.resolved_path().map(str::to_owned));
            let file = file.unwrap_or_else(|| id.clone());
            package_file(Path::new(&file))
        })
        .chain(read.flattened_files())
        .collect();
    files.sort();
    files.dedup();
    files
}

/// The metadata of a stage that is not of its layer alone.
///
/// # Errors
/// A layer that cannot be read.
pub fn stage_metadata(stage: &Stage) -> Result<Vec<(String, Value)>, Error> {
    let layer = stage.root_layer();
    let root = sdf::Path::abs_root();
    let mut keys = layer.data().list_fields(&root).unwrap_or_default();
    keys.retain(|key| !is_children(key) && !LAYER_METADATA.iter().any(|k| k.as_str() == key));
    keys.sort();
    let mut fields = Vec::with_capacity(keys.len());
    for key in keys {
        let value = layer.data().get_field(&root, &key).or_unreadable(&root)?.into_owned();
        fields.push((key, value));
    }
    Ok(fields)
}
