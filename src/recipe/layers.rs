//! Layers of a recipe: attributes, file, arguments and flags, the strongest last.

use super::instances::split;
use super::{Recipe, all_keys, default_of, in_words, instance_defaults, kind_of};
use crate::error::{Error, Warning, Warnings};
use serde_json::{Map, Value};

/// The layers of a recipe, the strongest added last.
#[derive(Clone, Debug, Default)]
pub struct Layers {
    pub(super) merged: Map<String, Value>,
}

impl Layers {
    /// Adds the attributes of the model's prim; what is in none of the schemas is reported.
    pub fn add_attributes(&mut self, attributes: Map<String, Value>, warnings: &mut Warnings) {
        for (space, value) in attributes {
            match (space.as_str(), value) {
                ("sim" | "render", Value::Object(fields)) => {
                    for (key, value) in fields {
                        self.add_known(&space, &key, value, &mut |name| warnings.push(not_understood(name)));
                    }
                }
                (kind, Value::Object(names)) if instance_defaults(kind).is_some() => {
                    for (name, fields) in names {
                        self.add_instance(kind, &name, fields, &mut |name| warnings.push(not_understood(name)));
                    }
                }
                _ => warnings.push(not_understood(&format!("tailor:{space}"))),
            }
        }
    }

    /// Adds the fields of an instance; names in it that hold fields again are part of the instance's name.
    fn add_instance(&mut self, kind: &str, name: &str, fields: Value, unknown: &mut dyn FnMut(&str)) {
        let Value::Object(fields) = fields else {
            return unknown(&format!("tailor:{kind}:{name}"));
        };
        for (field, value) in fields {
            match value {
                Value::Object(_) => self.add_instance(kind, &format!("{name}:{field}"), value, unknown),
                value => self.add_known(kind, &format!("{name}.{field}"), value, unknown),
            }
        }
    }

    fn add_known(&mut self, space: &str, key: &str, value: Value, unknown: &mut dyn FnMut(&str)) {
        match default_of(space, key) {
            Some(_) => self.set(space, key, value),
            None => unknown(&format!("tailor:{space}:{}", key.replace('.', ":"))),
        }
    }

    /// Adds a layer of nested keys.
    pub fn add(&mut self, layer: Map<String, Value>) {
        for (space, fields) in layer {
            let Value::Object(fields) = fields else { continue };
            for (key, value) in fields {
                match value {
                    Value::Object(of_instance) => {
                        self.instance(&space, &key);
                        for (field, value) in of_instance {
                            self.set(&space, &format!("{key}.{field}"), value);
                        }
                    }
                    value => self.set(&space, &key, value),
                }
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
        self.add_text("--set", key.trim(), text.trim())
    }

    /// Adds an option whose value is text, as given by `giver`, such as "--set".
    ///
    /// # Errors
    /// A key that no option has, or a value of another type.
    pub fn add_text(&mut self, giver: &str, key: &str, text: &str) -> Result<(), Error> {
        let (space, field) = key.split_once('.').unwrap_or((key, ""));
        let Some(default) = default_of(space, field) else {
            return Err(Error::Usage(format!("{giver} {key}: there is no such option\n  hint: {}", all_keys())));
        };
        if let Some(("", _)) = split(space, field) {
            let hint = format!("write {space}.<name>.{field}, such as {space}.a.{field}");
            return Err(Error::Usage(format!("{giver} {key}: the {space} has no name\n  hint: {hint}")));
        }
        let unfit = || {
            let kind = kind_of(&default).recipe;
            Error::Usage(format!("{giver} {key}: \"{text}\" is no {kind}\n  hint: its default is {default}"))
        };
        let value = parse_like(&default, text).ok_or_else(unfit)?;
        let mut alone = Self::default();
        alone.set(space, field, value.clone());
        if let Err(e) = serde_json::from_value::<Recipe>(Value::Object(alone.merged)) {
            let fault = in_words(&e);
            return Err(Error::Usage(format!("{giver} {key}: {fault}\n  hint: its default is {default}")));
        }
        self.set(space, field, value);
        Ok(())
    }

    fn space(&mut self, space: &str) -> Option<&mut Map<String, Value>> {
        self.merged.entry(space).or_insert_with(|| Value::Object(Map::new())).as_object_mut()
    }

    fn instance(&mut self, kind: &str, name: &str) -> Option<&mut Map<String, Value>> {
        self.space(kind)?.entry(name).or_insert_with(|| Value::Object(Map::new())).as_object_mut()
    }

    fn set(&mut self, space: &str, key: &str, value: Value) {
        let (fields, key) = match split(space, key) {
            Some((name, field)) => (self.instance(space, name), field),
            None => (self.space(space), key),
        };
        if let Some(fields) = fields {
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
        let fault = |path: &str, space: &str, key: &str, e: &serde_json::Error| {
            let default = default_of(space, key).unwrap_or_default();
            let (words, kind) = (in_words(e), kind_of(&default).usd);
            Error::Recipe(format!("tailor:{path} of the model: {words}\n  hint: declare it as {kind}"))
        };
        for (space, fields) in &self.merged {
            for (key, value) in fields.as_object().into_iter().flatten() {
                let of_instance = value.as_object().filter(|_| instance_defaults(space).is_some());
                for (field, value) in of_instance.into_iter().flatten() {
                    let alone = serde_json::json!({ space: { key: { field: value } } });
                    if let Err(e) = serde_json::from_value::<Recipe>(alone) {
                        return fault(&format!("{space}:{key}:{field}"), space, &format!("{key}.{field}"), &e);
                    }
                }
                let alone = serde_json::json!({ space: { key: value } });
                if let Err(e) = serde_json::from_value::<Recipe>(alone) {
                    return fault(&format!("{space}:{key}"), space, key, &e);
                }
            }
        }
        Error::Recipe(format!("tailor: attributes of the model: {}\n  hint: see the schemas", in_words(whole)))
    }
}

fn not_understood(what: &str) -> Warning {
    Warning::NotCarried { what: what.into(), why: "this version has no such option; it stays on the model".into() }
}

/// Text as a value of the same type as `like`; lists are separated by commas.
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
    use crate::sim::SimOptions;

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
    fn instances_are_merged_field_by_field() {
        let mut layers = Layers::default();
        let layer =
            serde_json::json!({"seam": {"placket": {"width": 3.0, "edges": ["a"]}, "left": {"hip": {"width": 1.0}}}});
        layers.add_attributes(layer.as_object().cloned().unwrap_or_default(), &mut Warnings::default());
        layers.add_override("seam.placket.width=2").expect("a good override");
        layers.add_override("seam.left:hip.edges=b,c").expect("a good override");
        layers.add_override("thickness.hem.faces=d").expect("a good override");
        layers.add_override("thickness.hem.side=outer").expect("a good override");
        let recipe = layers.recipe().expect("a good recipe");
        assert_eq!((recipe.seams["placket"].width, recipe.seams["placket"].edges.as_slice()), (2.0, &["a".into()][..]));
        assert_eq!((recipe.seams["left:hip"].width, recipe.seams["left:hip"].edges.len()), (1.0, 2));
        assert_eq!(recipe.thicknesses["hem"].side, crate::render::Side::Outer);
    }

    #[test]
    fn bad_overrides_name_the_key_and_the_remedy() {
        let mut layers = Layers::default();
        for (text, expected) in [
            ("sim.maxEdge=2", "sim.maxEdgeLength"),
            ("sim.iterations=many", "whole number"),
            ("sim.iterations", "has no value"),
            ("render.level=-1", "whole number"),
            ("seam.placket.wide=1", "seam.<name>.width"),
            ("seam.width=1", "no name"),
            ("seam.placket.width=wide", "is no number"),
            ("thickness.hem.side=under", "`inner`"),
        ] {
            let message = layers.add_override(text).expect_err(text).to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
