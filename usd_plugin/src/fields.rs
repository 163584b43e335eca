//! Lists the attributes of a prim that a dynamic payload reads.
//!
//! OpenUSD composes only attributes that are requested by name. Attributes of seams and folds include the name of
//! an instance. These names come from the `.tailor` file, the prim's applied schemas and the arguments of the asset
//! path.

use crate::ffi::Field;
use std::collections::BTreeSet;
use std::path::Path;
use std::str;
pub use tailor_costume::recipe::is_attribute as is_field;
use tailor_costume::recipe::{GroupTable, RecipeFile, table};

/// An operator: its kind and its name.
type Instance = (&'static str, String);

/// The attributes that a payload reads: one for each option of `sim` and `render`, and those of all named instances.
///
/// `recipe` is the text of the `.tailor` file, `schemas` the applied schemas as OpenUSD prints them, and `arguments` a
/// list of `key=value` separated by `&`.
pub fn fields(recipe: &[u8], schemas: &str, arguments: &str) -> Vec<Field> {
    let instances: BTreeSet<Instance> =
        in_recipe(recipe).into_iter().chain(in_schemas(schemas)).chain(in_arguments(arguments)).collect();
    let mut fields = Vec::new();
    for group in table().iter().filter(|group| !group.has_instances) {
        fields.extend(of_group(group, group.name));
    }
    for (kind, name) in &instances {
        fields.extend(
            kinds()
                .iter()
                .filter(|group| group.name == *kind)
                .flat_map(|group| of_group(group, &format!("{kind}.{name}"))),
        );
    }
    fields
}

/// The attributes of a group of options whose keys start with `prefix`.
fn of_group(group: &GroupTable, prefix: &str) -> Vec<Field> {
    group.options.iter().map(|option| field(format!("{prefix}.{}", option.key.key))).collect()
}

fn field(argument: String) -> Field {
    Field { attribute: format!("tailor:{}", argument.replace('.', ":")), argument }
}

/// The groups of options that have instances.
fn kinds() -> Vec<GroupTable> {
    table().into_iter().filter(|group| group.has_instances).collect()
}

/// The instances that a `.tailor` file names. An invalid text names none; its error is reported when the layer is read.
fn in_recipe(text: &[u8]) -> Vec<Instance> {
    let file = str::from_utf8(text).ok().and_then(|text| RecipeFile::parse(Path::new(""), text).ok());
    let layer = file.map(RecipeFile::into_layer).unwrap_or_default();
    let names = |kind: &'static str| {
        let of_kind = layer.get(kind).and_then(|fields| fields.as_object());
        of_kind.into_iter().flat_map(|fields| fields.keys()).map(move |name| (kind, name.clone()))
    };
    kinds().iter().flat_map(|group| names(group.name)).collect()
}

/// OpenUSD's label of the items that a list operation deletes.
const DELETED: &str = "Deleted Items: [";

/// The instances in lists of applied schemas, one line for each layer, strongest first. Deletions of stronger layers
/// apply.
fn in_schemas(text: &str) -> Vec<Instance> {
    let (mut found, mut deleted) = (Vec::new(), Vec::new());
    for list in text.lines() {
        let (before, rest) = list.split_once(DELETED).unwrap_or((list, ""));
        let (removed, after) = rest.split_once(']').unwrap_or((rest, ""));
        let named = in_words(before).into_iter().chain(in_words(after));
        found.extend(named.filter(|instance| !deleted.contains(instance)));
        deleted.extend(in_words(removed));
    }
    found
}

/// The instances in a printed list, such as `TailorSeamAPI:placket`, among other words.
fn in_words(text: &str) -> Vec<Instance> {
    let words: Vec<&str> = text.split(|c: char| c.is_whitespace() || "[],".contains(c)).collect();
    let named = |group: &GroupTable| {
        let names = words.iter().filter_map(|word| word.strip_prefix(&group.schema)?.strip_prefix(':'));
        names.filter(|name| !name.is_empty()).map(|name| (group.name, name.to_owned())).collect::<Vec<_>>()
    };
    kinds().iter().flat_map(named).collect()
}

fn in_arguments(text: &str) -> Vec<Instance> {
    let kinds = kinds();
    let key = |argument: &str| {
        let (key, _) = argument.split_once('=')?;
        let (kind, rest) = key.split_once('.')?;
        let (name, _) = rest.rsplit_once('.')?;
        Some((kinds.iter().find(|group| group.name == kind)?.name, name.to_owned()))
    };
    text.split('&').filter_map(key).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schemas_that_a_stronger_layer_takes_out_name_nothing() {
        let stronger = "SdfTokenListOp(Deleted Items: [TailorSeamAPI:hip], Prepended Items: [TailorSeamAPI:yoke])";
        let weaker = "SdfTokenListOp(Prepended Items: [TailorSeamAPI:hip, TailorFoldAPI:hem])";
        let both = in_schemas(&format!("{stronger}\n{weaker}\n"));
        assert_eq!(both, [("seam", "yoke".to_owned()), ("fold", "hem".to_owned())]);
        let added_again = in_schemas(&format!("{weaker}\n{stronger}\n"));
        assert_eq!(added_again.len(), 3);
    }

    fn attributes(recipe: &str, schemas: &str, arguments: &str) -> Vec<String> {
        let all = fields(recipe.as_bytes(), schemas, arguments);
        all.into_iter().map(|f| f.attribute).skip(fields(b"", "", "").len()).collect()
    }

    #[test]
    fn options_that_a_recipe_has_once_are_always_read() {
        let all = fields(b"", "", "");
        let once = table().into_iter().filter(|group| !group.has_instances);
        assert_eq!(all.len(), once.map(|group| group.options.len()).sum::<usize>());
        for field in all {
            assert_eq!(field.attribute, format!("tailor:{}", field.argument.replace('.', ":")));
            assert!(is_field(&field.attribute));
        }
    }

    #[test]
    fn instances_are_named_by_file_schemas_and_arguments() {
        let file = r#"{"source": "a.usda", "seam": {"placket": {}}, "fold": {"hem": {"thickness": 1}}, "fabric": {"rib": {}}, "trim": {"zip": {}}}"#;
        let found = attributes(file, "", "");
        assert_eq!(found.len(), kinds().iter().map(|group| group.options.len()).sum::<usize>());
        assert!(found.contains(&"tailor:seam:placket:normalOffset".to_owned()));
        assert!(found.contains(&"tailor:fold:hem:weights".to_owned()));
        let printed = "SdfListOp(Prepended Items: [TailorSimAPI, TailorSeamAPI:left:hip, TailorSeamAPI:back])\n";
        let found = attributes("", printed, "sim.seed=1&seam.dart.width=2&seam.back.width=2");
        for name in ["left:hip", "back", "dart"] {
            assert!(found.contains(&format!("tailor:seam:{name}:width")), "{found:?}");
        }
        assert!(found.iter().all(|attribute| is_field(attribute)));
        let seam = kinds().into_iter().find(|group| group.name == "seam").expect("seams");
        assert_eq!(found.len(), 3 * seam.options.len());
    }

    #[test]
    fn a_text_that_is_no_recipe_and_other_schemas_name_nothing() {
        assert!(
            attributes("{", "SdfListOp(Explicit Items: [TailorSeamAPI:, SkelBindingAPI:x])", "seam=1&a.b.c=2")
                .is_empty()
        );
        for other in ["tailor:seam:width", "tailor:seam:a:wide", "tailor:sim:maxEdge", "primvars:seam:a:width"] {
            assert!(!is_field(other), "{other}");
        }
    }
}
