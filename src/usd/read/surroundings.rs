//! The surroundings of a model: the prims beside it, PointInstancers that repeat it, and collections that name it.

use super::bindings::{Naming, namings};
use super::choose::{Repeated, prototypes};
use super::model::Model;
use super::origin::StageOrigin;
use super::query::{OrUnreadable, prim_at, product_of, property_names};
use crate::record::{Depth, Record};
use openusd::sdf;
use openusd::usd::{Prim, Stage};
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use tailor_mesh::error::Error;

/// A sibling of the model.
#[derive(Clone, Debug)]
pub struct Sibling {
    /// Whether this program made it from the model.
    pub product: bool,
    /// The name of another model from which this program made it.
    pub of_other: Option<String>,
    /// Declarations of what it holds, when this program wrote it.
    pub properties: Vec<Record>,
    /// Names of the prims below it, when this program wrote it.
    pub children: Vec<String>,
}

/// The prims beside a model, by name.
pub type Siblings = BTreeMap<String, Sibling>;

/// The surroundings that the models of one stage share.
#[derive(Default)]
pub struct KnownSurroundings {
    /// The prims below parents without products, with the models among them.
    siblings: HashMap<sdf::Path, Arc<Siblings>>,
    repeated: Option<Vec<Repeated>>,
    namings: Option<Vec<Naming>>,
}

impl KnownSurroundings {
    /// What PointInstancers repeat. Nothing is known of a stage of too many prims, in which a mesh can be named still.
    pub fn repeated(&mut self, stage: &Stage, origin: &StageOrigin) -> &[Repeated] {
        self.repeated.get_or_insert_with(|| prototypes(stage, &origin.file).unwrap_or_default())
    }

    /// What names meshes for anything but materials, as far as is known of the stage.
    pub fn namings(&mut self, stage: &Stage, origin: &StageOrigin) -> &[Naming] {
        self.namings.get_or_insert_with(|| namings(stage, &origin.file).unwrap_or_default())
    }

    /// The prims beside a model. Those of parents without products are read once.
    ///
    /// # Errors
    /// A stage that cannot be queried.
    pub fn siblings(&mut self, stage: &Stage, model: &Model) -> Result<Arc<Siblings>, Error> {
        if let Some(known) = self.siblings.get(&model.parent) {
            return Ok(Arc::clone(known));
        }
        let mut found = all_siblings(stage, model)?;
        if found.values().any(|sibling| sibling.product || sibling.of_other.is_some()) {
            found.remove(&model.name());
            return Ok(Arc::new(found));
        }
        let found = Arc::new(found);
        self.siblings.insert(model.parent.clone(), Arc::clone(&found));
        Ok(found)
    }
}

/// The prims beside a model, without its own meshes.
///
/// # Errors
/// A stage that cannot be queried.
pub fn siblings(stage: &Stage, model: &Model) -> Result<Siblings, Error> {
    let mut found = all_siblings(stage, model)?;
    let is_other = |name: &String| model.sibling_path(name).is_ok_and(|path| !model.panels.contains(&path));
    found.retain(|name, _| is_other(name));
    Ok(found)
}

/// The prims below the parent of a model.
fn all_siblings(stage: &Stage, model: &Model) -> Result<Siblings, Error> {
    let (parent, own) = (&model.parent, model.name());
    let mut found = Siblings::new();
    for name in prim_at(stage, parent)?.child_names().or_unreadable(parent)? {
        let path = model.sibling_path(name.as_str()).or_unreadable(parent)?;
        found.insert(name.as_str().to_owned(), Sibling::take(&prim_at(stage, &path)?, &own)?);
    }
    Ok(found)
}

impl Sibling {
    fn take(prim: &Prim, model: &str) -> Result<Self, Error> {
        let source = product_of(prim)?;
        let is_own = |source: &String| source.is_empty() || source == model;
        let mut sibling = Self {
            product: source.as_ref().is_some_and(is_own),
            of_other: source.filter(|source| !is_own(source)),
            properties: Vec::new(),
            children: Vec::new(),
        };
        if sibling.product {
            for name in property_names(prim)? {
                sibling.properties.extend(Record::take(prim, &name, Depth::Declaration).or_unreadable(prim.path())?);
            }
            let children = prim.child_names().or_unreadable(prim.path())?;
            sibling.children = children.iter().map(ToString::to_string).collect();
            sibling.children.sort();
        }
        Ok(sibling)
    }
}
