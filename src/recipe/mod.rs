//! The recipe: what the user asked for, from flags, a `.tailor` file, the model's attributes and the defaults.

mod bind;
mod file;
mod layers;

pub use bind::{Bound, bind};
pub use file::{Document, RecipeFile, is_recipe};
pub use layers::Layers;

use crate::error::Error;
use crate::render::RenderOptions;
use crate::sim::SimOptions;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Refinement quadruples the faces, so a level above this is a mistake. \[levels\]
const MAX_LEVEL: u32 = 6;
/// Rounds above this change nothing any more. \[rounds\]
const MAX_ITERATIONS: u32 = 100;
/// Samples above this settle nothing more, and their time grows with their number. \[samples a face\]
const MAX_SAMPLES: u32 = 1024;

/// Lengths that grow more slowly than this spread a fine region over the whole garment. \[factor\]
const LEAST_GRADING: f32 = 1.05;

/// The options: key, unit and meaning, in the order of the schemas.
pub const KEYS: [(&str, &str, &str); 16] = [
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
    ("render.operators", "names", "operators in their order (none yet)"),
];

/// All options of a build.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default, deny_unknown_fields)]
pub struct Recipe {
    /// Of the simulation mesh.
    pub sim: SimOptions,
    /// Of the render mesh.
    pub render: RenderOptions,
}

impl Recipe {
    fn check(&self) -> Result<(), Error> {
        let fault =
            |key: &str, fault: String, hint: &str| Err(Error::Recipe(format!("{key}: {fault}\n  hint: {hint}")));
        for (key, length) in
            [("sim.minEdgeLength", self.sim.min_edge_length), ("sim.maxEdgeLength", self.sim.max_edge_length)]
        {
            if !(length.is_finite() && length >= 0.0) {
                return fault(
                    key,
                    format!("{length} is no length"),
                    "give a positive number of stage units, or 0 for automatic",
                );
            }
        }
        let (min, max) = (self.sim.min_edge_length, self.sim.max_edge_length);
        if min > max && max > 0.0 {
            return fault(
                "sim.minEdgeLength",
                format!("{min} is more than sim.maxEdgeLength, {max}"),
                "exchange the two",
            );
        }
        let grading = self.sim.grading;
        if !(grading == 0.0 || grading.is_finite() && grading >= LEAST_GRADING) {
            return fault(
                "sim.grading",
                format!("{grading} is no factor by which lengths can grow"),
                &format!("give {LEAST_GRADING} or more, or 0 to leave lengths as they are"),
            );
        }
        let angle = self.sim.corner_angle;
        if !(angle > 0.0 && angle <= 180.0) {
            return fault(
                "sim.cornerAngle",
                format!("{angle} is no angle of a corner"),
                "give more than 0, at most 180",
            );
        }
        for (key, value, most) in [
            ("sim.baselineLevel", self.sim.baseline_level, MAX_LEVEL),
            ("render.level", self.render.level, MAX_LEVEL),
            ("sim.iterations", self.sim.iterations, MAX_ITERATIONS),
            ("sim.transferSamples", self.sim.transfer_samples, MAX_SAMPLES),
        ] {
            if value > most {
                return fault(key, format!("{value} is too much"), &format!("give at most {most}"));
            }
        }
        if !self.render.operators.is_empty() {
            return fault("render.operators", "there are no operators yet".into(), "leave it empty");
        }
        Ok(())
    }
}

/// The default recipe, as nested keys.
pub fn defaults() -> Value {
    serde_json::to_value(Recipe::default()).unwrap_or_default()
}

fn known(space: &str, key: &str) -> bool {
    defaults().get(space).is_some_and(|f| f.get(key).is_some())
}

fn all_keys() -> String {
    let keys: Vec<&str> = KEYS.iter().map(|k| k.0).collect();
    format!("the options are {}", keys.join(", "))
}

/// The options as lines of help: key, default, unit and meaning.
pub fn help() -> String {
    let defaults = defaults();
    let lines = KEYS.iter().map(|(key, unit, meaning)| {
        let (space, field) = key.split_once('.').unwrap_or((key, ""));
        format!("  {key:<21} {:<6} {meaning} [{unit}]\n", defaults[space][field].to_string())
    });
    format!("Options of the recipe, each with its default:\n{}", lines.collect::<String>())
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
    const WORDS: [(&str, &str); 8] = [
        ("expected f32", "expected a number"),
        ("expected u32", "expected a whole number, 0 or more"),
        ("expected a sequence", "expected a list"),
        ("expected a boolean", "expected true or false"),
        ("expected struct Form", "expected { options }"),
        ("expected a map", "expected { options }"),
        ("expected struct SimOptions", "expected { options }"),
        ("expected struct RenderOptions", "expected { options }"),
    ];
    WORDS.iter().fold(e.to_string(), |text, (ours, theirs)| text.replace(ours, theirs))
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
        assert!(KEYS.iter().all(|(key, _, _)| key.split_once('.').is_some_and(|(space, field)| known(space, field))));
    }
}
