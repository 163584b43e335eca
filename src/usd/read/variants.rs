//! Variant sets of the model and of the prims above it, and layers that select variants.

use super::query::{OrUnreadable, prim_at, property_names, subset_prims, with_ancestors};
use crate::codes;
use crate::names;
use crate::record::states;
use openusd::sdf::{self, AbstractData, ChildrenKey, Data, FieldKey, PrimSpec, SpecType, Value};
use openusd::usd::{Prim, SpecSite};
use openusd::usda::TextWriter;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt::Display;
use tailor_mesh::error::{Error, Warning, Warnings, names as listed};

/// A variant of a variant set.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Selection {
    /// Path of the prim with the variant set.
    pub prim: String,
    /// Name of the variant set.
    pub set: String,
    /// Name of the variant.
    pub choice: String,
}

/// A variant set and its selection.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct VariantSet {
    /// The variant that is selected.
    pub selected: Selection,
    /// Names of all variants.
    pub choices: Vec<String>,
}

/// Identifier of the session layer that selects variants. The library reads it by its content, which is text or a crate.
pub const SESSION: &str = "usdtailor-session.usd";

/// The variant sets of `prim` and of its ancestors, outermost first.
///
/// # Errors
/// A stage that cannot be queried.
pub fn variant_sets(prim: &Prim) -> Result<Vec<VariantSet>, Error> {
    let mut paths: Vec<sdf::Path> = prim.path().strict_ancestors_below_root().collect();
    paths.reverse();
    paths.push(prim.path().clone());
    let mut found = Vec::new();
    for path in &paths {
        let prim = prim_at(prim.stage(), path)?;
        let mut selections = prim.variant_sets().get_all_variant_selections().or_unreadable(path)?;
        selections.sort();
        let sites = prim.prim_stack().or_unreadable(path)?;
        for (set, choice) in selections {
            let mut choices: Vec<String> = sites.iter().flat_map(|site| choices_at(&prim, site, &set)).collect();
            choices.sort();
            choices.dedup();
            found.push(VariantSet { selected: Selection { prim: path.as_str().into(), set, choice }, choices });
        }
    }
    Ok(found)
}

/// The variant sets of `prim` with what is selected, for a message: `/Coat has size=S, of L, M, S`.
///
/// # Errors
/// A stage that cannot be queried.
pub fn in_words(prim: &Prim) -> Result<Vec<String>, Error> {
    let path = prim.path();
    let selected: HashMap<String, String> =
        prim.variant_sets().get_all_variant_selections().or_unreadable(path)?.into_iter().collect();
    let sites = prim.prim_stack().or_unreadable(path)?;
    let names = sites.iter().flat_map(|site| children_at(prim, site, &site.path, ChildrenKey::VariantSetChildren));
    let sets: BTreeSet<String> = names.collect();
    let words = |set: String| {
        let choices: BTreeSet<String> = sites.iter().flat_map(|site| choices_at(prim, site, &set)).collect();
        let of = choices.into_iter().collect::<Vec<_>>().join(", ");
        match selected.get(&set) {
            Some(choice) => format!("{path} has {set}={choice}, of {of}"),
            None => format!("{path} has no selection of {set}, of {of}"),
        }
    };
    Ok(sets.into_iter().map(words).collect())
}

/// The variants of a set of a prim, selected or not.
///
/// # Errors
/// A stage that cannot be queried.
pub fn choices_of(prim: &Prim, set: &str) -> Result<Vec<Selection>, Error> {
    let sites = prim.prim_stack().or_unreadable(prim.path())?;
    let choices: BTreeSet<String> = sites.iter().flat_map(|site| choices_at(prim, site, set)).collect();
    let path = prim.path().as_str();
    Ok(choices.into_iter().map(|choice| Selection { prim: path.to_owned(), set: set.to_owned(), choice }).collect())
}

/// The properties of `prim` that variants have, each with their sets: variants of the prim and of those above it, selected or not, as
/// far as the layers with the variants say so themselves.
///
/// # Errors
/// A stage that cannot be queried.
pub fn varied_properties(prim: &Prim) -> Result<BTreeMap<String, BTreeSet<String>>, Error> {
    let mut found: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for path in with_ancestors(prim.path()) {
        let owner = prim_at(prim.stage(), &path)?;
        let below = prim.path().as_str().strip_prefix(path.as_str()).unwrap_or_default().trim_start_matches('/');
        for site in owner.prim_stack().or_unreadable(&path)? {
            for set in children_at(&owner, &site, &site.path, ChildrenKey::VariantSetChildren) {
                for choice in choices_at(&owner, &site, &set) {
                    let variant = site.path.append_variant_selection(&set, &choice);
                    let Ok(place) = variant.and_then(|variant| joined(variant, below)) else { continue };
                    for property in children_at(&owner, &site, &place, ChildrenKey::PropertyChildren) {
                        found.entry(property).or_default().insert(set.clone());
                    }
                }
            }
        }
    }
    Ok(found)
}

/// The prim at a relative path such as `a/b` below another, or the other itself where the path is empty.
///
/// # Errors
/// A path that cannot be one.
pub fn joined(above: sdf::Path, below: &str) -> Result<sdf::Path, sdf::PathParseError> {
    below.split('/').filter(|name| !name.is_empty()).try_fold(above, |path, name| path.append_path(name))
}

/// The note that products keep what other variants than the selected ones have, of each set but those that are `built` one by one.
/// Materials follow, as products bind that of the model. Of those that are built, the warning that stronger opinions hide them.
///
/// # Errors
/// A stage that cannot be queried.
pub fn frozen(mesh: &Prim, sets: &[VariantSet], built: &[Selection]) -> Result<Warnings, Error> {
    let prims = [mesh.clone()].into_iter().chain(subset_prims(mesh)?);
    let kept = varied_by_set(prims, |property| !names::is_material(property) && !property.starts_with(names::RECIPE))?;
    let is_built = |set: &Selection| built.iter().any(|built| built.set == set.set && built.prim == set.prim);
    let open = sets.iter().filter(|set| !is_built(&set.selected));
    let mut warnings = frozen_sets(mesh, open, &kept, "products keep", |set| {
        format!("Build with --variants {set}, or once for each selection")
    });
    for Selection { set, choice, .. } in built {
        let is_of_variant = |site: &SpecSite| site.path.as_str().contains(&format!("{{{set}={choice}}}"));
        for name in property_names(mesh)? {
            let mut sites = mesh.attribute(name.as_str()).property_stack().or_unreadable(mesh.path())?;
            sites.retain(|site| states(mesh.stage(), site, &["default", "timeSamples"]));
            if let Some(first) = sites.iter().position(is_of_variant).filter(|&first| first > 0).map(|_| &sites[0]) {
                let why = format!("{set}={choice} has it, and what {} says is stronger", first.layer);
                let remedy = "Remove it in that layer, or build the layer that has the variants";
                warnings.push(Warning::not_carried(format!("{}.{name}", mesh.path()), why).remedy(remedy));
            }
        }
    }
    Ok(warnings)
}

/// The note that a trim on another body has what it has of the selected variants, among the `changed` properties.
///
/// # Errors
/// A stage that cannot be queried.
pub fn frozen_trim(trim: &Prim, changed: &BTreeSet<&str>) -> Result<Warnings, Error> {
    let kept = varied_by_set([trim.clone()], |property| changed.contains(property))?;
    Ok(frozen_sets(trim, variant_sets(trim)?.iter(), &kept, "the fit keeps", |set| {
        format!("Fit once for each selection of {set}")
    }))
}

/// The properties of some prims that variants have, by the sets of these variants.
fn varied_by_set(
    prims: impl IntoIterator<Item = Prim>,
    is_kept: impl Fn(&str) -> bool,
) -> Result<BTreeMap<String, BTreeSet<String>>, Error> {
    let mut kept: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for prim in prims {
        for (property, sets) in varied_properties(&prim)?.into_iter().filter(|(property, _)| is_kept(property)) {
            sets.into_iter().for_each(|set| _ = kept.entry(set).or_default().insert(property.clone()));
        }
    }
    Ok(kept)
}

/// The notes of sets with several variants that have properties which are kept, by set.
fn frozen_sets<'a>(
    prim: &Prim,
    sets: impl Iterator<Item = &'a VariantSet>,
    kept: &BTreeMap<String, BTreeSet<String>>,
    who: &str,
    remedy: impl Fn(&str) -> String,
) -> Warnings {
    let note = |VariantSet { selected: Selection { set, choice, .. }, .. }: &VariantSet| {
        let properties = listed(&kept.get(set)?.iter().collect::<Vec<_>>());
        let problem = format!("{who} {properties} of {set}={choice}, also where another variant is selected");
        Some(Warning::new(codes::FROZEN_VARIANT, prim.path(), problem).remedy(remedy(set)))
    };
    sets.filter(|set| set.choices.len() > 1).filter_map(note).collect()
}

/// The note that a flattened output has no variants. None where the stage has none to select.
pub fn flattened_variants(prim: &str, sets: &[VariantSet]) -> Option<Warning> {
    let several = sets.iter().filter(|set| set.choices.len() > 1);
    let selected: Vec<String> =
        several.map(|VariantSet { selected, .. }| format!("{}={}", selected.set, selected.choice)).collect();
    let problem = format!("the flattened output is of {}, and has no variants", selected.join(" and "));
    let remedy = "Write it over the input, without --flatten, to keep them";
    (!selected.is_empty()).then(|| Warning::new(codes::FROZEN_VARIANT, prim, problem).remedy(remedy))
}

/// Names of the variants of a set that one layer holds.
fn choices_at(prim: &Prim, site: &SpecSite, set: &str) -> Vec<String> {
    match site.path.append_variant_selection(set, "") {
        Ok(path) => children_at(prim, site, &path, ChildrenKey::VariantChildren),
        Err(_) => Vec::new(),
    }
}

fn children_at(prim: &Prim, site: &SpecSite, path: &sdf::Path, key: ChildrenKey) -> Vec<String> {
    let Some(layer) = prim.stage().layer(&site.layer) else { return Vec::new() };
    match layer.data().try_field(path, key.as_str()) {
        Ok(Some(value)) => match value.as_ref() {
            Value::TokenVec(names) => names.iter().map(|name| name.as_str().to_owned()).collect(),
            _ => Vec::new(),
        },
        _ => Vec::new(),
    }
}

/// Authors selections in a layer, beside those that it has.
///
/// # Errors
/// A path that is not a prim.
pub fn select(data: &mut Data, selections: &[Selection]) -> openusd::Result<()> {
    for selection in selections {
        let path = sdf::Path::new(&selection.prim)?;
        PrimSpec::over(data, &path)?;
        let key = FieldKey::VariantSelection.as_str();
        let mut all = match AbstractData::try_field(data, &path, key)?.as_deref() {
            Some(Value::VariantSelectionMap(all)) => all.clone(),
            _ => HashMap::new(),
        };
        all.insert(selection.set.clone(), selection.choice.clone());
        AbstractData::set_field(data, &path, key, Value::VariantSelectionMap(all));
    }
    Ok(())
}

/// The text of a layer that selects variants.
///
/// # Errors
/// A path that is not a prim.
pub fn session_layer(selections: &[Selection]) -> Result<String, Error> {
    let fault =
        |e: &dyn Display| Error::usd(format!("the variants cannot be selected: {e}")).code(codes::COMPOSITION_FAILED);
    let mut data = Data::new();
    data.create_spec(sdf::Path::abs_root(), SpecType::PseudoRoot);
    select(&mut data, selections).map_err(|e| fault(&e))?;
    TextWriter::write_to_string(&data).map_err(|e| fault(&e))
}
