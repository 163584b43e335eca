//! The recipe: all options of a build, and how they are read, merged and checked.
//!
//! Options come from the model's attributes, `.tailor` files and the command line ([`Layers`]). All use the same keys,
//! such as `sim.maxEdgeLength`; an attribute has colons instead of dots and the prefix `tailor:`.

mod file;
mod groups;
mod layers;
mod listed;
mod lod;
mod resolved;

pub use file::{RecipeFile, is_recipe, map_files};
pub use groups::Recipe;
pub use groups::{all, find, group_with_instances};
pub use layers::Layers;
pub use listed::ListedOperator;
pub use lod::LodOptions;
pub use resolved::Resolved;

pub use tailor_mesh::options::{Domain, Group, Key};

use groups::{pattern, split};
use serde::Serialize;
use serde_json::Value;
use std::fmt::Write as _;
use tailor_mesh::options::nearest;

/// The default recipe, as nested keys.
pub fn defaults() -> Value {
    serde_json::to_value(Recipe::default()).unwrap_or_default()
}

/// The default of an option by its key, such as `sim.maxEdgeLength`.
pub fn default_of(key: &str) -> Option<Value> {
    let (group, key) = find(key)?;
    (group.defaults)().get(key.key).cloned()
}

/// Whether an option is the path of a file.
pub fn is_file(key: &str) -> bool {
    find(key).is_some_and(|(_, key)| key.domain == Domain::File)
}

fn all_keys() -> Vec<String> {
    all().flat_map(|group| group.keys.iter().map(|key| pattern(group, key))).collect()
}

/// All options as help text, one a line: key, default, meaning and unit.
pub fn help() -> String {
    let mut text = "Options of the recipe, each with its default:\n".to_owned();
    for group in all() {
        let defaults = (group.defaults)();
        for key in group.keys {
            let (name, default) = (pattern(group, key), defaults.get(key.key).map(Value::to_string));
            let _ = writeln!(text, "  {name:<21} {:<6} {} [{}]", default.unwrap_or_default(), key.meaning, key.unit);
        }
    }
    text
}

/// A group of the table of options.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS), ts(rename = "Group"))]
pub struct GroupTable {
    /// The first part of the keys, such as `sim` or `seam`.
    pub name: &'static str,
    /// Description, in a few sentences.
    pub about: &'static str,
    /// Their API schema, such as `TailorSeamAPI`.
    pub schema: String,
    /// True if a recipe has the options for each of several names.
    pub has_instances: bool,
    /// True if these are operators of the render mesh.
    pub is_operator: bool,
    /// Its options, in the order of the schema.
    pub options: Vec<OptionRow>,
}

/// A row of the table of options.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS), ts(rename = "Option"))]
pub struct OptionRow {
    /// The declaration.
    #[serde(flatten)]
    pub key: Key,
    /// The default.
    #[cfg_attr(feature = "typescript", ts(type = "Value"))]
    pub default: Value,
}

/// The table of options, in the order of the schema.
pub fn table() -> Vec<GroupTable> {
    let of_group = |group: &'static Group| {
        let defaults = (group.defaults)();
        let row = |key: &Key| OptionRow { key: *key, default: defaults.get(key.key).cloned().unwrap_or_default() };
        GroupTable {
            name: group.name,
            about: group.about,
            schema: group.schema(None),
            has_instances: group_with_instances(group.name).is_some(),
            is_operator: Recipe::OPERATORS.iter().any(|operator| operator.name == group.name),
            options: group.keys.iter().map(row).collect(),
        }
    };
    all().map(of_group).collect()
}

/// True if an attribute is an option, for any name of an instance.
pub fn is_attribute(name: &str) -> bool {
    let Some(key) = name.strip_prefix("tailor:").map(layers::dotted) else { return false };
    let is_named = |(group, rest): (&str, &str)| split(group, rest).is_none_or(|(name, _)| !name.is_empty());
    find(&key).is_some() && key.split_once('.').is_some_and(is_named)
}

/// The type of an option, as messages describe it.
struct ValueType {
    /// With its article.
    recipe: &'static str,
    /// The declaration of the attribute, with an example.
    usd: &'static str,
}

fn value_type(value: &Value) -> ValueType {
    let (recipe, usd) = match value {
        Value::Bool(_) => ("true or false", "bool, such as true"),
        Value::Number(n) if n.is_f64() => ("a number", "float, such as 2.5"),
        Value::Number(_) => ("a whole number", "int, such as 3 (0 or more)"),
        Value::Array(_) => {
            ("a list", "rel, with subsets of the mesh as targets, or string, such as \"uvSeams, borders.1\"")
        }
        _ => ("a name", "token, such as \"st\""),
    };
    ValueType { recipe, usd }
}

/// The message of a serde error, with Rust types replaced by words.
fn in_words(e: &serde_json::Error) -> String {
    const WORDS: [(&str, &str); 5] = [
        ("expected f32", "expected a number"),
        ("expected u32", "expected a whole number, 0 or more"),
        ("expected a sequence", "expected a list"),
        ("expected a boolean", "expected true or false"),
        ("expected a map", "expected { name: { options } }"),
    ];
    let text = WORDS.iter().fold(e.to_string(), |text, (ours, theirs)| text.replace(ours, theirs));
    if let Some(text) = suggested(&text) {
        return text;
    }
    let Some((before, after)) = text.split_once("expected struct ") else { return text };
    format!("{before}expected {{ options }}{}", after.trim_start_matches(char::is_alphanumeric))
}

/// The words about an unknown option with the known one that is nearest, in the place of the list of all; none without one.
fn suggested(text: &str) -> Option<String> {
    let (before, list) = text.split_once("`, expected one of ")?;
    let (list, place) = list.split_once(" at line ")?;
    let known: Vec<&str> = list.split(", ").map(|name| name.trim_matches('`')).collect();
    let near = nearest(before.rsplit('`').next()?, &known)?;
    Some(format!("{before}`, did you mean `{near}`? at line {place}"))
}
