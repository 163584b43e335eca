//! The recipe: all options of a build, and how they are read, merged and checked.
//!
//! Options come from the model's attributes, `.tailor` files and the command line ([`Layers`]). All use the same keys,
//! such as `sim.maxEdgeLength`; an attribute has colons instead of dots and the prefix `tailor:`.

mod bind;
mod check;
mod file;
mod layers;
mod operators;
mod uv_set;

pub(crate) use bind::{bind, bind_sim, bind_uv_set};
pub use file::{RecipeFile, is_recipe};
pub use layers::Layers;
pub use operators::KINDS;
pub(crate) use operators::kind_named;
pub(crate) use uv_set::resolve_uv_set;

pub use crate::render::{Domain, Key, Kind};

use crate::cloth::{ClothOptions, DIALECTS, FabricOptions};
use crate::render::{RenderOptions, SeamOptions, ThicknessOptions};
use crate::sim::SimOptions;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// The options that a recipe has once, in schema order.
pub const KEYS: [Key; 29] = [
    Key {
        key: "sim.minEdgeLength",
        unit: "mesh units",
        domain: Domain::Length { least: 0.0, most: 2.0, automatic: 0.5 },
        meaning: "target edge length at density 1; 0: half of maxEdgeLength",
    },
    Key {
        key: "sim.maxEdgeLength",
        unit: "mesh units",
        domain: Domain::Length { least: 0.0, most: 2.0, automatic: 0.5 },
        meaning: "target edge length at density 0; 0: half of the input's mean edge",
    },
    Key {
        key: "sim.density",
        unit: "name",
        domain: Domain::Weights,
        meaning: "painted float primvar, 1 fine to 0 coarse; empty: maxEdgeLength everywhere",
    },
    Key {
        key: "sim.grading",
        unit: "factor",
        domain: Domain::Number { least: 0.0, most: 4.0, step: 0.05 },
        meaning: "largest ratio of neighbouring target lengths, 1.05 or more; 0: no limit",
    },
    Key {
        key: "sim.baselineLevel",
        unit: "levels",
        domain: Domain::Whole { most: 4 },
        meaning: "subdivision level of the surface that the mesh approximates",
    },
    Key {
        key: "sim.iterations",
        unit: "rounds",
        domain: Domain::Whole { most: 10 },
        meaning: "rounds of split, collapse, flip and relax",
    },
    Key {
        key: "sim.uvSet",
        unit: "name",
        domain: Domain::UvSet,
        meaning: "UV set whose shell borders are seams; empty: none",
    },
    Key {
        key: "sim.constrainUvSeams",
        unit: "true or false",
        domain: Domain::Flag,
        meaning: "keep UV seams as edges of the mesh",
    },
    Key {
        key: "sim.smallestShell",
        unit: "target triangles",
        domain: Domain::Number { least: 0.0, most: 16.0, step: 0.5 },
        meaning: "smaller UV shells do not constrain the mesh, and UVs beside them are approximate; 0: all do",
    },
    Key {
        key: "sim.constraints",
        unit: "names",
        domain: Domain::EdgeSets,
        meaning: "edge subsets to keep as edges of the mesh",
    },
    Key {
        key: "sim.cornerAngle",
        unit: "degrees",
        domain: Domain::Number { least: 5.0, most: 180.0, step: 5.0 },
        meaning: "keep a corner where a curve turns by more within one edge length; 180: none",
    },
    Key {
        key: "sim.ridgeAngle",
        unit: "degrees",
        domain: Domain::Number { least: 30.0, most: 180.0, step: 5.0 },
        meaning: "keep a fold that turns by more within one target length as a line of edges; 180: none",
    },
    Key {
        key: "sim.transferSamples",
        unit: "samples per face",
        domain: Domain::Whole { most: 128 },
        meaning: "samples to transfer face sets, colours and uniform primvars",
    },
    Key {
        key: "sim.seed",
        unit: "integer",
        domain: Domain::Whole { most: 100 },
        meaning: "seed of the transfer samples",
    },
    Key {
        key: "sim.cleanIslands",
        unit: "true or false",
        domain: Domain::Flag,
        meaning: "merge single stray faces of a face set into the set around them",
    },
    Key {
        key: "sim.provenance",
        unit: "true or false",
        domain: Domain::Flag,
        meaning: "store the source face and coordinates of each vertex",
    },
    Key {
        key: "render.level",
        unit: "levels",
        domain: Domain::Whole { most: 3 },
        meaning: "subdivision level of the render mesh",
    },
    Key {
        key: "render.seamLevel",
        unit: "levels",
        domain: Domain::Whole { most: 3 },
        meaning: "refinements before the first seam; 0: as many as leave its lines room",
    },
    Key {
        key: "render.operators",
        unit: "names",
        domain: Domain::Operators,
        meaning: "operators in the order they run; empty: all thicknesses, then all seams",
    },
    Key {
        key: "render.faceSets",
        unit: "true or false",
        domain: Domain::Flag,
        meaning: "add face subsets of the faces that each operator creates",
    },
    Key {
        key: "cloth.physics",
        unit: "names",
        domain: Domain::Words(DIALECTS),
        meaning: "dialects of USD physics to write: aousd, omni, chaos; empty: none",
    },
    Key {
        key: "cloth.fabric",
        unit: "name",
        domain: Domain::Text,
        meaning: "cotton, denim, wool, silk, leather or jersey, or the name of a fabric of the recipe",
    },
    Key {
        key: "cloth.warp",
        unit: "name",
        domain: Domain::Choice(&["u", "v"]),
        meaning: "axis of the UV panels that the warp follows",
    },
    Key {
        key: "cloth.rest",
        unit: "name",
        domain: Domain::Choice(&["auto", "mesh", "panels"]),
        meaning: "shape without strain: the UV panels, or the mesh; auto: panels where they are patterns",
    },
    Key { key: "cloth.pins", unit: "names", domain: Domain::LineSets, meaning: "point and edge subsets that are held" },
    Key {
        key: "cloth.pinTarget",
        unit: "prim path",
        domain: Domain::Text,
        meaning: "prim that holds the pins; empty: the world",
    },
    Key {
        key: "cloth.attach",
        unit: "true or false",
        domain: Domain::Flag,
        meaning: "attach loose pieces, such as pockets, to the cloth below them",
    },
    Key {
        key: "cloth.panels",
        unit: "true or false",
        domain: Domain::Flag,
        meaning: "write the flat panels of the shape at rest as a mesh of their own",
    },
    Key {
        key: "cloth.scene",
        unit: "true or false",
        domain: Domain::Flag,
        meaning: "write a PhysicsScene with gravity",
    },
];

/// All options of a build.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default, deny_unknown_fields)]
pub struct Recipe {
    /// Options of the simulation mesh.
    pub sim: SimOptions,
    /// Options of the render mesh.
    pub render: RenderOptions,
    /// Options of the cloth.
    pub cloth: ClothOptions,
    /// Options of each seam, by name.
    #[serde(rename = "seam", skip_serializing_if = "BTreeMap::is_empty")]
    pub seams: BTreeMap<String, SeamOptions>,
    /// Options of each thickness, by name.
    #[serde(rename = "thickness", skip_serializing_if = "BTreeMap::is_empty")]
    pub thicknesses: BTreeMap<String, ThicknessOptions>,
    /// Options of each fabric, by name.
    #[serde(rename = "fabric", skip_serializing_if = "BTreeMap::is_empty")]
    pub fabrics: BTreeMap<String, FabricOptions>,
}

/// The default recipe, as nested keys.
pub fn defaults() -> Value {
    serde_json::to_value(Recipe::default()).unwrap_or_default()
}

/// The default of the option `space.key`; for an operator, `key` is `instance.field`.
fn default_of(space: &str, key: &str) -> Option<Value> {
    match operators::split(space, key) {
        Some((_, field)) => (kind_named(space)?.defaults)().get(field).cloned(),
        None => defaults().get(space)?.get(key).cloned(),
    }
}

/// The default of an option by its full key, such as `sim.maxEdgeLength`.
pub(crate) fn default_at(key: &str) -> Option<Value> {
    let (space, field) = key.split_once('.')?;
    default_of(space, field)
}

/// The key of an operator's option with a placeholder for its name, such as `seam.<name>.width`.
fn pattern(kind: &str, field: &str) -> String {
    format!("{kind}.<name>.{field}")
}

fn all_keys() -> Vec<String> {
    let of_instances = KINDS.iter().flat_map(|kind| kind.keys.iter().map(|key| pattern(kind.name, key.key)));
    KEYS.iter().map(|k| k.key.to_owned()).chain(of_instances).collect()
}

/// All options as help text, one per line: key, default, meaning and unit.
pub fn help() -> String {
    let mut text = "Options of the recipe, each with its default:\n".to_owned();
    let mut line = |key: &str, default: Option<Value>, meaning: &str, unit: &str| {
        let default = default.unwrap_or_default().to_string();
        let _ = writeln!(text, "  {key:<21} {default:<6} {meaning} [{unit}]");
    };
    for Key { key, unit, meaning, .. } in KEYS {
        line(key, default_at(key), meaning, unit);
    }
    for kind in KINDS.iter() {
        let defaults = (kind.defaults)();
        for key in kind.keys {
            line(&pattern(kind.name, key.key), defaults.get(key.key).cloned(), key.meaning, key.unit);
        }
    }
    text
}

/// True if an attribute is an option, for any name of an operator.
pub fn is_attribute(name: &str) -> bool {
    let Some((space, rest)) = name.strip_prefix("tailor:").and_then(|a| a.split_once(':')) else { return false };
    let is_of_kind = |field: &str| kind_named(space).is_some_and(|kind| kind.keys.iter().any(|key| key.key == field));
    KEYS.iter().any(|key| key.key.split_once('.') == Some((space, rest)))
        || rest.rsplit_once(':').is_some_and(|(_, field)| is_of_kind(field))
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
        Value::Array(_) => ("a list", "rel, with subsets of the mesh as targets"),
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
        assert!(KEYS.iter().all(|key| default_at(key.key).is_some()));
    }
}
