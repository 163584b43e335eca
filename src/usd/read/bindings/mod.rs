//! Materials that collections bind to a garment, as the direct bindings that its products need: a collection names the prims
//! of the stage, and has no product. `looks` says how materials look.

mod collection;

pub use collection::{COLLECTION, Naming, members, namings};

use super::model::Model;
use super::query::{OrUnreadable, prim_at, prim_name, property_names, subset_prims, text_value, with_ancestors};
use super::variants::varied_properties;
use crate::names;
use crate::record::{Content, Record};
use openusd::sdf::{Path, Value, Variability};
use openusd::tf::Token;
use openusd::usd::Prim;
use tailor_mesh::error::Error;

/// Purposes of bindings: the one for all, and USD's others.
const PURPOSES: [&str; 3] = ["", "preview", "full"];

/// Puts direct bindings in place of collections that bind a material to the model or to its subsets.
///
/// # Errors
/// A collection that cannot be read.
pub fn resolve_collections(prim: &Prim, model: &mut Model) -> Result<(), Error> {
    if !has_collections(prim)? {
        return Ok(());
    }
    let mut of_mesh = Vec::new();
    for purpose in PURPOSES {
        let winner = winner(prim, purpose)?;
        if let Some(Winner { material, is_collection: true }) = &winner {
            bind(&mut model.carried, &mut model.applied, &binding_name(purpose), direct(material));
        }
        of_mesh.push(winner);
    }
    for subset in subset_prims(prim)? {
        let is_of_materials = text_value(&subset, names::FAMILY_NAME, None)?.as_deref() == Some(names::MATERIAL_FAMILY);
        let Some(record) = model.subsets.get_mut(&prim_name(&subset)).filter(|_| is_of_materials) else { continue };
        for (purpose, of_mesh) in PURPOSES.iter().zip(&of_mesh) {
            let Some(winner) = winner(&subset, purpose)? else { continue };
            let is_by_collection = winner.is_collection || of_mesh.as_ref().is_some_and(|mesh| mesh.is_collection);
            let own = record.carried.iter().find(|record| record.name == binding_name(purpose)).and_then(target);
            let without = own.or_else(|| of_mesh.as_ref().map(|mesh| mesh.material.clone()));
            if is_by_collection && without.as_ref() != Some(&winner.material) {
                bind(&mut record.carried, &mut record.applied, &binding_name(purpose), direct(&winner.material));
            }
        }
    }
    Ok(())
}

/// Binds to a panel what prims between it and `parent` bind: its products are below `parent`.
///
/// # Errors
/// A binding that cannot be read.
pub fn resolve_inherited(prim: &Prim, parent: &Path, model: &mut Model) -> Result<(), Error> {
    let above = prim_at(prim.stage(), parent)?;
    for purpose in PURPOSES {
        let found = winner(prim, purpose)?.map(|winner| winner.material);
        let of_parent =
            if parent.is_abs_root() { None } else { winner(&above, purpose)?.map(|winner| winner.material) };
        let own = model.carried.iter().find(|record| record.name == binding_name(purpose)).and_then(target);
        if let Some(material) = found.filter(|found| Some(found) != own.as_ref() && Some(found) != of_parent.as_ref()) {
            bind(&mut model.carried, &mut model.applied, &binding_name(purpose), direct(&material));
        }
    }
    Ok(())
}

/// Whether a collection may bind a material to a mesh or its subsets: few stages have one.
fn has_collections(prim: &Prim) -> Result<bool, Error> {
    let subsets = subset_prims(prim)?.into_iter().map(|subset| subset.path().clone());
    for path in with_ancestors(prim.path()).chain(subsets) {
        let names = property_names(&prim_at(prim.stage(), &path)?)?;
        if names.iter().any(|name| name.starts_with(names::MATERIAL_BINDING_COLLECTION)) {
            return Ok(true);
        }
    }
    Ok(false)
}

fn target(record: &Record) -> Option<Path> {
    let Content::Relationship { targets, .. } = &record.content else { return None };
    targets.first().cloned()
}

/// Binds a material directly, in place of what is there under the name.
fn bind(records: &mut Vec<Record>, applied: &mut Vec<Token>, name: &str, content: Content) {
    records.retain(|record| record.name != name);
    records.push(Record {
        name: name.to_owned(),
        variability: Variability::Uniform,
        custom: false,
        metadata: Vec::new(),
        content,
        has_spline: false,
    });
    if !applied.iter().any(|schema| schema.as_str() == names::MATERIAL_BINDING_API) {
        applied.push(Token::from(names::MATERIAL_BINDING_API));
    }
}

/// A binding to one material.
fn direct(material: &Path) -> Content {
    Content::Relationship { targets: vec![material.clone()], of_variant: None }
}

/// Lets products follow the bindings that variants have, selected or not: of those that only other variants have, there are records too.
///
/// # Errors
/// A stage that cannot be queried.
pub fn follow_variants(prim: &Prim, records: &mut Vec<Record>, applied: &mut Vec<Token>) -> Result<(), Error> {
    let varied = varied_properties(prim)?;
    for name in PURPOSES.map(binding_name).into_iter().filter(|name| varied.contains_key(name)) {
        let path = prim.path().append_property(name.as_str()).or_unreadable(prim.path())?;
        match records.iter_mut().find(|record| record.name == name).map(|record| &mut record.content) {
            Some(Content::Relationship { of_variant, .. }) => *of_variant = Some(path),
            _ => bind(records, applied, &name, Content::Relationship { targets: Vec::new(), of_variant: Some(path) }),
        }
    }
    Ok(())
}

fn binding_name(purpose: &str) -> String {
    if purpose.is_empty() {
        names::MATERIAL_BINDING.to_owned()
    } else {
        format!("{}:{purpose}", names::MATERIAL_BINDING)
    }
}

/// Whether a property binds by a collection for a purpose: `material:binding:collection:<purpose>:<name>`, or without purpose.
fn is_by_collection(property: &str, purpose: &str) -> bool {
    let Some(rest) = property.strip_prefix(names::MATERIAL_BINDING_COLLECTION).and_then(|rest| rest.strip_prefix(':'))
    else {
        return false;
    };
    match rest.split_once(':') {
        Some((first, _)) => first == purpose,
        None => purpose.is_empty(),
    }
}

/// The binding that decides about a prim.
struct Winner {
    material: Path,
    is_collection: bool,
}

/// The binding of a purpose that `UsdShadeMaterialBindingAPI::ComputeBoundMaterial` finds: the nearest one, unless one above
/// is stronger than its descendants. On one prim, collections come before the direct binding.
fn winner(prim: &Prim, purpose: &str) -> Result<Option<Winner>, Error> {
    let (stage, mut found) = (prim.stage(), None);
    for path in with_ancestors(prim.path()) {
        let place = prim_at(stage, &path)?;
        let bindings = property_names(&place)?;
        let mut here = None;
        for name in bindings.iter().filter(|name| is_by_collection(name, purpose)) {
            let [collection, material] = &place.relationship(name.as_str()).targets().or_unreadable(&path)?[..] else {
                continue;
            };
            if here.is_none() && members(stage, collection.as_str()).is_ok_and(|all| all.is_path_included(prim.path()))
            {
                here = Some((name.clone(), Winner { material: material.clone(), is_collection: true }));
            }
        }
        let direct = binding_name(purpose);
        if here.is_none() && bindings.contains(&direct) {
            let targets = place.relationship(direct.as_str()).targets().or_unreadable(&path)?;
            here =
                targets.first().map(|material| (direct, Winner { material: material.clone(), is_collection: false }));
        }
        if let Some((name, binding)) = here
            && (found.is_none() || is_stronger(&place, &name)?)
        {
            found = Some(binding);
        }
    }
    Ok(found)
}

fn is_stronger(prim: &Prim, name: &str) -> Result<bool, Error> {
    let strength = prim.relationship(name).get_metadata::<Value>(names::BIND_MATERIAL_AS).or_unreadable(prim.path())?;
    Ok(strength.as_ref().is_some_and(names::is_stronger))
}
