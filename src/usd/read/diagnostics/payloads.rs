//! Payloads of `.tailor` files, and options below them, which nothing reads.

use crate::codes;
use crate::read::choose::all_prims;
use crate::read::origin::{Files, StageOrigin, without_arguments};
use crate::read::query::{OrUnreadable, prim_at, property_names};
use crate::{names, on_large_stack};
use openusd::ar::{ResolvedPath, Resolver};
use openusd::sdf::{self, FieldKey, PayloadListOp, Value};
use openusd::usd::{Prim, PrimPredicate};
use std::path::{Path, PathBuf};
use tailor_costume::recipe::group_with_instances;
use tailor_mesh::error::{Error, Warning};

/// The payloads of `.tailor` files in a stage.
#[derive(Clone, Debug, Default)]
pub struct TailorPayloads {
    /// The prims with a payload, each with the path of the `.tailor` file.
    pub recipes: Vec<(String, PathBuf)>,
    /// A warning for each option on a prim below one of them. OpenUSD shows the file format of a payload only the prim that has it, so
    /// the option belongs there.
    pub misplaced: Vec<Warning>,
    /// Whether the composition has other faults than these payloads, which this program does not compose.
    pub has_other_faults: bool,
}

/// A prim with a payload of a `.tailor` file.
struct Holder {
    path: sdf::Path,
    /// The asset path.
    recipe: String,
}

/// The payloads of `.tailor` files in a stage.
///
/// # Errors
/// A stage that cannot be opened or searched.
pub fn tailor_payloads(file: &Path) -> Result<TailorPayloads, Error> {
    on_large_stack(|| {
        let stage = StageOrigin::new(file, None, &[]).open()?;
        let (mut found, mut holder) = (TailorPayloads::default(), None::<Holder>);
        // The prims that a payload defines are overs here, as this program composes no `.tailor` file.
        for path in all_prims(&stage, file, PrimPredicate::ALL, false)? {
            let prim = prim_at(&stage, &path)?;
            if let Some((recipe, place)) = recipe_of(&prim)? {
                if stage.prim_matches(&path, PrimPredicate::DEFAULT).or_unreadable(&path)? {
                    found.recipes.push((path.to_string(), place));
                }
                holder = Some(Holder { path, recipe });
            } else if let Some(holder) = holder.as_ref().filter(|holder| path.has_prefix(&holder.path)) {
                found.misplaced.extend(options(&prim)?.iter().map(|option| holder.misplaced(&prim, option)));
            } else {
                holder = None;
            }
        }
        found.has_other_faults = stage.composition_errors().iter().any(|fault| super::recipe_of(fault).is_none());
        Ok(found)
    })
}

impl Holder {
    fn misplaced(&self, prim: &Prim, option: &str) -> Warning {
        let Self { path, recipe } = self;
        let problem = format!("not read: it is below {path}, whose payload is {recipe}");
        let mut remedy = format!("Author it on {path}");
        if prim.prim_index().property_type(option).is_ok_and(|kind| kind == Some(sdf::SpecType::Relationship)) {
            remedy += " as token[] with the names of the sets";
        }
        let named = option.strip_prefix(names::RECIPE).and_then(|key| key.split_once(':'));
        if let Some((kind, key)) = named
            && let Some(group) = group_with_instances(kind)
            && let Some((name, _)) = key.rsplit_once(':')
        {
            // The schema makes a payload follow the options of this name.
            remedy += &format!(", with the schema {}", group.schema(Some(name)));
        }
        Warning::new(codes::MISPLACED_OPTION, format!("{}.{option}", prim.path()), problem).remedy(remedy)
    }
}

/// The options that are authored on a prim.
fn options(prim: &Prim) -> Result<Vec<String>, Error> {
    let mut names = property_names(prim)?;
    names.retain(|name| name.starts_with(names::RECIPE) && name != names::SHARPNESS && !names::is_produced(name));
    Ok(names)
}

/// The `.tailor` file that a prim has as a payload in one of its layers: its asset path, and its path.
fn recipe_of(prim: &Prim) -> Result<Option<(String, PathBuf)>, Error> {
    for site in prim.prim_stack().or_unreadable(prim.path())? {
        let Some(layer) = prim.stage().layer(&site.layer) else { continue };
        let payload = layer.data().try_field(&site.path, FieldKey::Payload.as_str()).or_unreadable(prim.path())?;
        let files = match payload.as_deref() {
            Some(Value::PayloadListOp(all)) => added(all),
            Some(Value::Payload(one)) => vec![one.asset_path.as_str()],
            _ => Vec::new(),
        };
        let mut files = files.into_iter().map(without_arguments);
        let is_recipe = |file: &&str| Path::new(file).extension().is_some_and(|e| e.eq_ignore_ascii_case("tailor"));
        if let Some(recipe) = files.find(is_recipe) {
            let anchor = layer.resolved_path().map(ResolvedPath::new);
            let place = Files::default().create_identifier(recipe, anchor.as_ref());
            return Ok(Some((recipe.to_owned(), PathBuf::from(place))));
        }
    }
    Ok(None)
}

/// The files of the payloads that a list adds.
fn added(all: &PayloadListOp) -> Vec<&str> {
    let lists = [&all.explicit_items, &all.added_items, &all.prepended_items, &all.appended_items];
    lists.into_iter().flatten().map(|payload| payload.asset_path.as_str()).collect()
}
