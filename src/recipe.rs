//! The recipe: what the user asked for, from flags, a `.tailor` file, the model's attributes and the defaults.

use crate::error::{Error, Warning, Warnings, plain};
use crate::garment::{Elements, Garment, Interpolation, Primvar, Values};
use crate::render::RenderOptions;
use crate::sim::SimOptions;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::path::Path;

/// Refinement quadruples the faces, so a level above this is a mistake. \[levels\]
const MAX_LEVEL: u32 = 6;
/// Rounds above this change nothing any more. \[rounds\]
const MAX_ITERATIONS: u32 = 100;

/// The options: key, unit and meaning, in the order of the schemas.
pub const KEYS: [(&str, &str, &str); 14] = [
    ("sim.minEdgeLength", "stage units", "edge length where the density is 1; 0: half of maxEdgeLength"),
    ("sim.maxEdgeLength", "stage units", "edge length where the density is 0; 0: half the mean edge of the input"),
    ("sim.density", "name", "painted float primvar, 1 fine to 0 coarse; empty: maxEdgeLength everywhere"),
    ("sim.baselineLevel", "levels", "refinements that give the surface which the mesh lies on"),
    ("sim.iterations", "rounds", "rounds of split, collapse, flip and relax"),
    ("sim.uvSet", "name", "UV set whose shell borders are seams; empty: none"),
    ("sim.constrainUvSeams", "true or false", "whether UV seams are edges of the mesh"),
    ("sim.constraints", "names", "edge subsets that become edges of the mesh"),
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

/// A `.tailor` file.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default, deny_unknown_fields)]
pub struct RecipeFile {
    /// The USD file, relative to this one.
    pub source: Option<String>,
    /// Path of the mesh.
    pub prim: Option<String>,
    sim: Map<String, Value>,
    render: Map<String, Value>,
}

/// The layers of a recipe, the strongest added last.
#[derive(Clone, Debug, Default)]
pub struct Layers {
    merged: Map<String, Value>,
}

impl RecipeFile {
    /// Reads a `.tailor` file.
    ///
    /// # Errors
    /// A file that is missing or is not a recipe, with line and column.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let shown = path.display();
        let text = std::fs::read_to_string(path).map_err(|e| {
            Error::Recipe(format!(
                "cannot read recipe {shown}: {}\n  hint: check the path given by --recipe",
                plain(&e)
            ))
        })?;
        let fault = |e: serde_json::Error| {
            Error::Recipe(format!(
                "{shown}: {}\n  hint: a recipe is JSON, such as {{\"sim\": {{\"maxEdgeLength\": 2}}}}",
                in_words(&e)
            ))
        };
        // Once for its form with unknown keys by line and column, once for what it says.
        serde_json::from_str::<Form>(&text).map_err(fault)?;
        serde_json::from_str(&text).map_err(fault)
    }

    /// What the file says about the products.
    pub fn into_layer(self) -> Map<String, Value> {
        let mut layer = Map::new();
        layer.insert("sim".into(), Value::Object(self.sim));
        layer.insert("render".into(), Value::Object(self.render));
        layer
    }
}

/// The keys and types of a `.tailor` file.
#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default, deny_unknown_fields)]
struct Form {
    #[serde(rename = "source")]
    _source: Option<String>,
    #[serde(rename = "prim")]
    _prim: Option<String>,
    #[serde(rename = "sim")]
    _sim: SimOptions,
    #[serde(rename = "render")]
    _render: RenderOptions,
}

impl Layers {
    /// Adds the attributes of the model's prim; what is in none of the schemas is reported.
    pub fn add_attributes(&mut self, attributes: Map<String, Value>, warnings: &mut Warnings) {
        for (space, value) in attributes {
            match (space.as_str(), value) {
                ("sim" | "render", Value::Object(fields)) => {
                    for (key, value) in fields {
                        if known(&space, &key) {
                            self.set(&space, &key, value);
                        } else {
                            warnings.push(not_understood(&format!("tailor:{space}:{key}")));
                        }
                    }
                }
                _ => warnings.push(not_understood(&format!("tailor:{space}"))),
            }
        }
    }

    /// Adds a layer of nested keys.
    pub fn add(&mut self, layer: Map<String, Value>) {
        for (space, fields) in layer {
            if let Value::Object(fields) = fields {
                fields.into_iter().for_each(|(key, value)| self.set(&space, &key, value));
            }
        }
    }

    /// Adds `key=value` as given on the command line, such as `sim.maxEdgeLength=2`.
    ///
    /// # Errors
    /// A key that no option has, or a value of another type.
    pub fn add_override(&mut self, assignment: &str) -> Result<(), Error> {
        let (key, text) = assignment.split_once('=').ok_or_else(|| {
            Error::Usage(format!("--set {assignment} has no value\n  hint: write --set sim.maxEdgeLength=2"))
        })?;
        let (space, field) = key.trim().split_once('.').unwrap_or((key, ""));
        if !known(space, field) {
            return Err(Error::Usage(format!("--set {key}: there is no such option\n  hint: {}", all_keys())));
        }
        let defaults = defaults();
        let value = parse_like(&defaults[space][field], text.trim()).ok_or_else(|| {
            Error::Usage(format!(
                "--set {key}: \"{text}\" is no {}\n  hint: its default is {}",
                type_of(&defaults[space][field]),
                defaults[space][field]
            ))
        })?;
        self.set(space, field, value);
        Ok(())
    }

    fn set(&mut self, space: &str, key: &str, value: Value) {
        let fields = self.merged.entry(space).or_insert_with(|| Value::Object(Map::new()));
        if let Value::Object(fields) = fields {
            fields.insert(key.into(), value);
        }
    }

    /// Whether any layer says something about an option.
    pub fn says(&self, space: &str, key: &str) -> bool {
        self.merged.get(space).is_some_and(|f| f.get(key).is_some())
    }

    /// The recipe, with defaults for what no layer says.
    ///
    /// # Errors
    /// A value of another type or out of its range.
    pub fn recipe(&self) -> Result<Recipe, Error> {
        let recipe: Recipe =
            serde_json::from_value(Value::Object(self.merged.clone())).map_err(|e| self.mistyped(&e))?;
        recipe.check()?;
        Ok(recipe)
    }

    /// The first option whose value is of another type. Only attributes can be: files and flags are checked as they
    /// are read.
    fn mistyped(&self, whole: &serde_json::Error) -> Error {
        let defaults = defaults();
        for (space, fields) in &self.merged {
            for (key, value) in fields.as_object().into_iter().flatten() {
                let alone = serde_json::json!({ space: { key: value } });
                if let Err(e) = serde_json::from_value::<Recipe>(alone) {
                    return Error::Recipe(format!(
                        "tailor:{space}:{key} of the model: {}\n  hint: declare it as {}",
                        in_words(&e),
                        usd_type_of(&defaults[space][key])
                    ));
                }
            }
        }
        Error::Recipe(format!("tailor: attributes of the model: {}\n  hint: see the schemas", in_words(whole)))
    }
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
        for (key, value, most) in [
            ("sim.baselineLevel", self.sim.baseline_level, MAX_LEVEL),
            ("render.level", self.render.level, MAX_LEVEL),
            ("sim.iterations", self.sim.iterations, MAX_ITERATIONS),
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

/// What the recipe names on the garment.
pub struct Bound<'a> {
    /// The primvar with the constraint UVs.
    pub uv_set: Option<&'a Primvar>,
    /// The painted density.
    pub density: Option<&'a Primvar>,
}

/// Finds what a recipe names on its garment. The default UV set may be missing; one that was asked for may not.
///
/// # Errors
/// A primvar or subset that is missing or of another kind.
pub fn bind<'a>(recipe: &Recipe, garment: &'a Garment, uv_set_was_given: bool) -> Result<Bound<'a>, Error> {
    let sim = &recipe.sim;
    let is_uv = |p: &&Primvar| {
        p.interpolation == Interpolation::FaceVarying && p.width() == 2 && matches!(p.values, Values::F32(_))
    };
    let uv_set = garment.primvar(&sim.uv_set).filter(is_uv);
    if uv_set.is_none() && uv_set_was_given && !sim.uv_set.is_empty() {
        return Err(missing(
            garment,
            "uvSet",
            &sim.uv_set,
            "face-varying float2 primvar",
            garment.primvars.iter().filter(is_uv),
        ));
    }
    let is_weight = |p: &&Primvar| {
        matches!(p.interpolation, Interpolation::Vertex | Interpolation::Varying)
            && p.width() == 1
            && matches!(p.values, Values::F32(_))
    };
    let density = garment.primvar(&sim.density).filter(is_weight);
    if density.is_none() && !sim.density.is_empty() {
        return Err(missing(
            garment,
            "density",
            &sim.density,
            "float primvar per vertex",
            garment.primvars.iter().filter(is_weight),
        ));
    }
    for name in &sim.constraints {
        if !garment.subset(name).is_some_and(|s| matches!(s.elements, Elements::Edges(_))) {
            let names: Vec<&str> = garment
                .subsets
                .iter()
                .filter(|s| matches!(s.elements, Elements::Edges(_)))
                .map(|s| s.name.as_str())
                .collect();
            return Err(Error::Recipe(format!(
                "{}: sim.constraints names \"{name}\", which is no edge subset of the mesh\n  hint: its edge subsets are: {}",
                garment.prim,
                names.join(", ")
            )));
        }
    }
    Ok(Bound { uv_set, density })
}

fn missing<'a>(
    garment: &Garment,
    key: &str,
    name: &str,
    kind: &str,
    fitting: impl Iterator<Item = &'a Primvar>,
) -> Error {
    let names: Vec<&str> = fitting.map(|p| p.name.as_str()).collect();
    let hint =
        if names.is_empty() { "the mesh has none".to_owned() } else { format!("the mesh has: {}", names.join(", ")) };
    Error::Recipe(format!(
        "{}: sim.{key} names \"{name}\", which is no {kind} of the mesh\n  hint: {hint}",
        garment.prim
    ))
}

fn not_understood(what: &str) -> Warning {
    Warning::NotCarried { what: what.into(), why: "this version has no such option; it stays on the model".into() }
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

fn type_of(value: &Value) -> &'static str {
    match value {
        Value::Bool(_) => "true or false",
        Value::Number(n) if n.is_f64() => "number",
        Value::Number(_) => "whole number",
        Value::Array(_) => "list",
        _ => "name",
    }
}

/// The type of an option in the schemas, as an example of its declaration.
fn usd_type_of(value: &Value) -> &'static str {
    match value {
        Value::Bool(_) => "bool, such as true",
        Value::Number(n) if n.is_f64() => "float, such as 2.5",
        Value::Number(_) => "int, such as 3 (0 or more)",
        Value::Array(_) => "rel, with subsets of the mesh as targets",
        _ => "token, such as \"st\"",
    }
}

/// What serde found, without the names of our types.
fn in_words(e: &serde_json::Error) -> String {
    const WORDS: [(&str, &str); 6] = [
        ("expected f32", "expected a number"),
        ("expected u32", "expected a whole number, 0 or more"),
        ("expected a sequence", "expected a list"),
        ("expected a boolean", "expected true or false"),
        ("expected struct SimOptions", "expected { options }"),
        ("expected struct RenderOptions", "expected { options }"),
    ];
    WORDS.iter().fold(e.to_string(), |text, (ours, theirs)| text.replace(ours, theirs))
}

/// A command line's text as a value of the same type as `like`; lists are separated by commas.
fn parse_like(like: &Value, text: &str) -> Option<Value> {
    match like {
        Value::Bool(_) => text.parse::<bool>().ok().map(Value::Bool),
        Value::Number(n) if n.is_f64() => serde_json::Number::from_f64(text.parse().ok()?).map(Value::Number),
        Value::Number(_) => text.parse::<u32>().ok().map(|n| Value::Number(n.into())),
        Value::Array(_) => {
            Some(text.split(',').filter(|t| !t.is_empty()).map(|t| Value::String(t.trim().into())).collect())
        }
        _ => Some(Value::String(text.into())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_options_is_complete() {
        let count: usize =
            defaults().as_object().into_iter().flatten().filter_map(|(_, f)| f.as_object()).map(Map::len).sum();
        assert_eq!(count, KEYS.len());
        assert!(KEYS.iter().all(|(key, _, _)| key.split_once('.').is_some_and(|(space, field)| known(space, field))));
    }

    #[test]
    fn stronger_layers_win() {
        let mut layers = Layers::default();
        let layer = serde_json::json!({"sim": {"iterations": 3, "maxEdgeLength": 4.0}});
        layers.add_attributes(layer.as_object().cloned().unwrap_or_default(), &mut Warnings::default());
        layers.add_override("sim.iterations=7").expect("a good override");
        let recipe = layers.recipe().expect("a good recipe");
        assert_eq!((recipe.sim.iterations, recipe.sim.max_edge_length), (7, 4.0));
        assert_eq!(recipe.sim.baseline_level, SimOptions::default().baseline_level);
    }

    #[test]
    fn bad_overrides_name_the_key_and_the_remedy() {
        let mut layers = Layers::default();
        for (text, expected) in [
            ("sim.maxEdge=2", "sim.maxEdgeLength"),
            ("sim.iterations=many", "whole number"),
            ("sim.iterations", "has no value"),
            ("render.level=-1", "whole number"),
        ] {
            let message = layers.add_override(text).expect_err(text).to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
