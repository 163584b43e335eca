//! The recipe: what the user asked for, from flags, a `.tailor` file, the model's attributes and the defaults.

mod bind;
mod check;
mod file;
mod instances;
mod layers;

pub use bind::{Bound, bind};
pub use file::{Document, RecipeFile, is_recipe};
pub use instances::{KINDS, instance_defaults};
pub use layers::Layers;

use crate::render::{RenderOptions, SeamOptions, ThicknessOptions};
use crate::sim::SimOptions;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// The options that each recipe has once: key, unit and meaning, in the order of the schemas.
pub const KEYS: [(&str, &str, &str); 17] = [
    ("sim.minEdgeLength", "stage units", "edge length where the density is 1; 0: half of maxEdgeLength"),
    ("sim.maxEdgeLength", "stage units", "edge length where the density is 0; 0: half the mean edge of the input"),
    ("sim.density", "name", "painted float primvar, 1 fine to 0 coarse; empty: maxEdgeLength everywhere"),
    ("sim.grading", "factor", "how many times longer than its neighbour an edge may be asked to be; 0: any"),
    ("sim.baselineLevel", "levels", "refinements that give the surface which the mesh lies on"),
    ("sim.iterations", "rounds", "rounds of split, collapse, flip and relax"),
    ("sim.uvSet", "name", "UV set whose shell borders are seams; empty: none"),
    ("sim.constrainUvSeams", "true or false", "whether UV seams are edges of the mesh"),
    ("sim.constraints", "names", "edge subsets that become edges of the mesh"),
    ("sim.cornerAngle", "degrees", "a curve that turns more within one edge length keeps a corner there; 180: none"),
    ("sim.transferSamples", "samples a face", "samples that face sets, colours and uniform primvars are counted by"),
    ("sim.seed", "number", "seed of the samples"),
    ("sim.cleanIslands", "true or false", "whether single stray faces of a face set go to their neighbours"),
    ("sim.provenance", "true or false", "whether vertices say which face of the input they came from"),
    ("render.level", "levels", "refinements of the render mesh"),
    ("render.operators", "names", "operators in their order; empty: seams, then thicknesses"),
    ("render.faceSets", "true or false", "whether operators leave face subsets of what they made"),
];

/// All options of a build.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default, deny_unknown_fields)]
pub struct Recipe {
    /// Of the simulation mesh.
    pub sim: SimOptions,
    /// Of the render mesh.
    pub render: RenderOptions,
    /// Of the seams, by name.
    #[serde(rename = "seam", skip_serializing_if = "BTreeMap::is_empty")]
    pub seams: BTreeMap<String, SeamOptions>,
    /// Of the thicknesses, by name.
    #[serde(rename = "thickness", skip_serializing_if = "BTreeMap::is_empty")]
    pub thicknesses: BTreeMap<String, ThicknessOptions>,
}

/// The default recipe, as nested keys.
pub fn defaults() -> Value {
    serde_json::to_value(Recipe::default()).unwrap_or_default()
}

/// The default of an option that is written `space.key`, or `kind.instance.field`.
fn default_of(space: &str, key: &str) -> Option<Value> {
    match instances::split(space, key) {
        Some((_, field)) => instance_defaults(space)?.get(field).cloned(),
        None => defaults().get(space)?.get(key).cloned(),
    }
}

/// The key of an option of instances, with a place for their name.
fn pattern(kind: &str, field: &str) -> String {
    format!("{kind}.<name>.{field}")
}

fn all_keys() -> String {
    let of_instances = KINDS.iter().flat_map(|kind| kind.keys.iter().map(|key| pattern(kind.name, key.field)));
    let keys: Vec<String> = KEYS.iter().map(|k| k.0.to_owned()).chain(of_instances).collect();
    format!("the options are {}", keys.join(", "))
}

/// The options as lines of help: key, default, unit and meaning.
pub fn help() -> String {
    let mut text = "Options of the recipe, each with its default:\n".to_owned();
    let mut line = |key: &str, default: Option<Value>, meaning: &str, unit: &str| {
        let default = default.unwrap_or_default().to_string();
        let _ = writeln!(text, "  {key:<21} {default:<6} {meaning} [{unit}]");
    };
    for (key, unit, meaning) in KEYS {
        let (space, field) = key.split_once('.').unwrap_or((key, ""));
        line(key, default_of(space, field), meaning, unit);
    }
    for kind in &KINDS {
        let defaults = (kind.defaults)();
        for key in kind.keys {
            line(&pattern(kind.name, key.field), defaults.get(key.field).cloned(), key.meaning, key.unit);
        }
    }
    text
}

/// The type of an option, in a recipe, and in the schemas as an example of its declaration.
struct Kind {
    recipe: &'static str,
    usd: &'static str,
}

fn kind_of(value: &Value) -> Kind {
    let (recipe, usd) = match value {
        Value::Bool(_) => ("true or false", "bool, such as true"),
        Value::Number(n) if n.is_f64() => ("number", "float, such as 2.5"),
        Value::Number(_) => ("whole number", "int, such as 3 (0 or more)"),
        Value::Array(_) => ("list", "rel, with subsets of the mesh as targets"),
        _ => ("name", "token, such as \"st\""),
    };
    Kind { recipe, usd }
}

/// What serde found, without the names of our types.
fn in_words(e: &serde_json::Error) -> String {
    const WORDS: [(&str, &str); 5] = [
        ("expected f32", "expected a number"),
        ("expected u32", "expected a whole number, 0 or more"),
        ("expected a sequence", "expected a list"),
        ("expected a boolean", "expected true or false"),
        ("expected a map", "expected { name: { options } }"),
    ];
    let text = WORDS.iter().fold(e.to_string(), |text, (ours, theirs)| text.replace(ours, theirs));
    let Some((before, after)) = text.split_once("expected struct ") else { return text };
    format!("{before}expected {{ options }}{}", after.trim_start_matches(char::is_alphanumeric))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Map;

    #[test]
    fn the_table_of_options_is_complete() {
        let count: usize =
            defaults().as_object().into_iter().flatten().filter_map(|(_, f)| f.as_object()).map(Map::len).sum();
        assert_eq!(count, KEYS.len());
        assert!(
            KEYS.iter().all(|(key, _, _)| key
                .split_once('.')
                .is_some_and(|(space, field)| default_of(space, field).is_some()))
        );
    }
}
