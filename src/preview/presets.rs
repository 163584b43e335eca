//! Presets: values of seams and folds under names, in the words of a `.tailor` file. Built-in presets are in
//! `presets.json`. A file of the same form beside a garment has the user's own.

use serde_json::{Map, Value};
use std::path::Path;
use tailor_costume::codes;
use tailor_costume::recipe::{Domain, Layers, Recipe, RecipeFile};
use tailor_mesh::error::Error;
use tailor_mesh::garment::Units;
use tailor_mesh::options::Group;

/// The built-in presets.
const BUILT_IN: &str = include_str!("presets.json");

/// Longest name. \[characters\]
const LONGEST_NAME: usize = 60;

/// The values of an operator.
type Values = Map<String, Value>;

/// Presets as they are in a file: for each kind of operator, values by name. Lengths have units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Presets {
    kinds: Map<String, Value>,
}

impl Presets {
    /// The built-in presets.
    ///
    /// # Errors
    /// None, which a test proves.
    pub fn built_in() -> Result<Self, Error> {
        Self::parse(Path::new("presets.json"), BUILT_IN)
    }

    /// Parses the text of the file at `path`, which errors name.
    ///
    /// # Errors
    /// A text that is not a recipe, with line and column; a recipe with other options than values of operators.
    pub fn parse(path: &Path, text: &str) -> Result<Self, Error> {
        let fault = |text: String, remedy: &str| {
            Err(Error::recipe(path.display(), text).code(codes::RECIPE_FILE).remedy(remedy))
        };
        let file = RecipeFile::parse(path, text)?;
        if file.source.is_some() || file.prim.is_some() {
            return fault("presets have neither source nor prim".into(), "remove them");
        }
        let kinds = file.into_layer();
        for (kind, named) in &kinds {
            let Some(group) = Recipe::OPERATORS.iter().find(|group| group.name == kind) else {
                return fault(format!("{kind} has no presets"), "keep the presets of seams and folds alone");
            };
            for (name, values) in named.as_object().into_iter().flatten() {
                let fields = values.as_object().into_iter().flat_map(Map::keys);
                if let Some(field) = fields.into_iter().find(|field| !is_value(group, field)) {
                    let text = format!("the preset {name:?} cannot contain `{field}`: it belongs to one {kind}");
                    return fault(text, &format!("remove {field} from the preset"));
                }
            }
        }
        Ok(Self { kinds })
    }

    /// The text of a file with them.
    pub fn to_text(&self) -> String {
        serde_json::to_string_pretty(&self.kinds).unwrap_or_default() + "\n"
    }

    /// For each kind of operator, values by name, with lengths in units of the mesh.
    pub fn in_units(&self, units: Units) -> Map<String, Value> {
        let mut layers = Layers::default();
        layers.add(self.kinds.clone());
        layers.convert_lengths(units);
        layers.into_map()
    }

    /// Adds a preset, or replaces one of its kind and name. Lengths are in units of the mesh.
    ///
    /// # Errors
    /// A name that cannot be shown, a kind that has no presets, values that operators have of their own.
    pub fn put(&mut self, kind: &str, name: &str, values: &Values, units: Units) -> Result<(), Error> {
        let fault = |text: String, remedy: &str| {
            Err(Error::recipe(name, text).code(tailor_mesh::codes::OPTION_VALUE).remedy(remedy))
        };
        if name.trim().is_empty() || name.chars().count() > LONGEST_NAME || name.chars().any(char::is_control) {
            return fault("it cannot be the name of a preset".into(), "give a name of 1 to 60 characters");
        }
        let Some(group) = Recipe::OPERATORS.iter().find(|group| group.name == kind) else {
            return fault(format!("{kind} has no presets"), "save the values of a seam or fold");
        };
        let mut with_units = Values::new();
        for (field, value) in values {
            if !is_value(group, field) {
                return fault(format!("presets do not hold {field}"), "save the other values");
            }
            with_units.insert(field.clone(), with_unit(group, field, value, units));
        }
        let named = self.kinds.entry(kind).or_insert_with(|| Value::Object(Values::new()));
        if let Some(named) = named.as_object_mut() {
            named.insert(name.trim().to_owned(), Value::Object(with_units));
        }
        Ok(())
    }

    /// Takes a preset out.
    pub fn remove(&mut self, kind: &str, name: &str) {
        if let Some(named) = self.kinds.get_mut(kind).and_then(Value::as_object_mut) {
            named.remove(name);
        }
    }
}

/// True for an option whose value operators may share: neither a set, nor the switch of the operator.
fn is_value(group: &Group, field: &str) -> bool {
    group.key(field).is_some_and(|key| field != "enabled" && !matches!(key.domain, Domain::Sets { .. }))
}

/// A length in millimetres, with as many digits as single precision holds; other values as they are.
fn with_unit(group: &Group, field: &str, value: &Value, units: Units) -> Value {
    let is_length = group.key(field).is_some_and(|key| key.domain.is_length());
    match value.as_f64().filter(|_| is_length) {
        Some(length) => Value::String(format!("{}mm", (length * units.meters() * 1000.0) as f32)),
        None => value.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    const CENTIMETRES: Units = Units { meters_per_unit: 0.01, scale: 1.0 };

    fn parse(text: &str) -> Result<Presets, Error> {
        Presets::parse(Path::new("a.presets.json"), text)
    }

    fn values(value: &Value) -> Values {
        value.as_object().cloned().expect("an object")
    }

    #[test]
    fn those_of_the_program_are_complete_and_can_be_built() {
        let built_in = Presets::built_in().expect("good presets");
        let all = built_in.in_units(CENTIMETRES);
        for (kind, sets) in [("seam", "edges"), ("fold", "faces")] {
            for (name, fields) in all[kind].as_object().expect("presets") {
                let mut options = fields.clone();
                options[sets] = json!(["uvSeams"]);
                let mut layers = Layers::default();
                layers.add(values(&json!({kind: {"a": options}})));
                assert!(layers.recipe().is_ok(), "{kind} {name}");
            }
        }
        let felled = all["seam"]["Flat-felled"]["width"].as_f64().expect("a number");
        let of_metres = built_in.in_units(Units { meters_per_unit: 1.0, scale: 1.0 });
        let in_metres = of_metres["seam"]["Flat-felled"]["width"].as_f64().expect("a number");
        assert!((felled - 100.0 * in_metres).abs() < 1e-6 && felled > 0.5 && felled < 2.0, "{felled} {in_metres}");
    }

    #[test]
    fn topstitching_is_beside_a_felled_seam_of_the_same_edges() {
        let all = Presets::built_in().expect("good presets").in_units(CENTIMETRES);
        let of = |name: &str, field: &str| all["seam"][name][field].as_f64().expect("a number");
        let (row, seam) = (of("Topstitch", "width"), of("Flat-felled", "width"));
        let between = of("Topstitch", "offset") - 0.5 * (row + seam);
        assert!(between > 0.5 * row, "{between} between them");
    }

    #[test]
    fn the_documents_list_those_of_the_program() {
        let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/recipe.md");
        let page = std::fs::read_to_string(page).expect("the page");
        for (kind, named) in &Presets::built_in().expect("good presets").kinds {
            for (name, fields) in named.as_object().expect("presets") {
                let word = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
                let fields = fields.as_object().expect("values").iter();
                let fields: Vec<String> = fields.map(|(key, value)| format!("`{key}` {}", word(value))).collect();
                let row = format!("| {kind} | {name} | {} |\n", fields.join(", "));
                assert!(page.contains(&row), "docs/recipe.md lacks {row}");
            }
        }
    }

    #[test]
    fn a_saved_preset_comes_back_and_fits_another_unit() {
        let mut presets = Presets::default();
        let given = values(&json!({"width": 0.9083, "normalOffset": -0.05, "asymmetry": 0.25}));
        presets.put("seam", " 2.5 oz, \"mine\" ", &given, CENTIMETRES).expect("a good preset");
        let text = presets.to_text();
        assert!(text.contains("\"9.083mm\""), "{text}");
        let read = parse(&text).expect("good presets");
        assert_eq!(read, presets);
        assert_eq!(read.in_units(CENTIMETRES)["seam"]["2.5 oz, \"mine\""], Value::Object(given));
        let in_metres = read.in_units(Units { meters_per_unit: 1.0, scale: 1.0 });
        assert_eq!(in_metres["seam"]["2.5 oz, \"mine\""]["width"], json!(0.009083));
        let mut emptied = read;
        emptied.remove("seam", "2.5 oz, \"mine\"");
        assert!(emptied.in_units(CENTIMETRES).is_empty());
    }

    #[test]
    fn what_a_preset_cannot_hold_is_refused() {
        let mut presets = Presets::default();
        let good = values(&json!({"width": 1.0}));
        let long = "a".repeat(61);
        for (kind, name, fields) in [
            ("seam", " ", good.clone()),
            ("seam", "a\nb", good.clone()),
            ("seam", long.as_str(), good.clone()),
            ("sim", "a", good),
            ("seam", "a", values(&json!({"edges": ["b"]}))),
            ("fold", "a", values(&json!({"enabled": true}))),
            ("fold", "a", values(&json!({"width": 1.0}))),
        ] {
            assert!(presets.put(kind, name, &fields, CENTIMETRES).is_err(), "{kind} {name} {fields:?}");
        }
        assert_eq!(presets, Presets::default());
        for text in [
            "{",
            "{\"seam\": {\"a\": {\"width\": \"8 apples\"}}}",
            "{\"seam\": {\"a\": {\"edges\": [\"b\"]}}}",
            "{\"seam\": {\"a\": {\"enabled\": false}}}",
            "{\"seam\": {\"a\": {\"colour\": 1}}}",
            "{\"sim\": {\"maxEdgeLength\": 2}}",
            "{\"source\": \"a.usda\"}",
        ] {
            let error = parse(text).expect_err(text);
            assert!(error.to_string().contains("a.presets.json"), "{error}");
        }
    }
}
