//! Merges the sources of options: the model's attributes, `.tailor` files, layer arguments and `--set` flags.

use super::groups::{all, find, group_with_instances, split};
use super::{Domain, Key, Recipe, all_keys, default_of, in_words, value_type};
use crate::codes;
use serde_json::{Map, Value};
use serde_path_to_error::Segment;
use tailor::recipe::bind_uv_set;
use tailor::sets::split_list;
use tailor_mesh::error::{Error, ErrorKind, Warning, Warnings};
use tailor_mesh::garment::units::{UNITS, meters_of};
use tailor_mesh::garment::{Mesh, Units};
use tailor_mesh::options::nearest;

/// The merged options of several layers. A layer overrides those added before it, option by option.
#[derive(Clone, Debug, Default)]
pub struct Layers {
    merged: Map<String, Value>,
}

impl Layers {
    /// Adds the `tailor:` attributes of the model's prim; warnings of those that are not options.
    pub fn add_attributes(&mut self, attributes: Map<String, Value>) -> Warnings {
        let mut warnings = Warnings::default();
        let mut unknown = |name: &str| warnings.push(not_understood(name));
        for (space, value) in attributes {
            match value {
                Value::Object(names) if group_with_instances(&space).is_some() => {
                    for (name, fields) in names {
                        self.add_instance(&space, &name, fields, &mut unknown);
                    }
                }
                Value::Object(fields) if all().any(|group| group.name == space) => {
                    for (key, value) in fields {
                        self.add_known(&space, &key, value, &mut unknown);
                    }
                }
                _ => unknown(&format!("tailor:{space}")),
            }
        }
        warnings
    }

    /// Adds the fields of an instance. Nested names are part of the instance's name, as in `left:hip`.
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
        match find(&format!("{space}.{key}")) {
            // Some exporters write no lists, only texts.
            Some((group, option)) => match ((group.defaults)().get(option.key), &value) {
                (Some(Value::Array(_)), Value::String(text)) => {
                    self.set(space, key, split_list(text).into_iter().map(Value::String).collect());
                }
                _ => self.set(space, key, value),
            },
            None => unknown(&format!("tailor:{space}:{}", key.replace('.', ":"))),
        }
    }

    /// Warnings of applied schemas of operators for which no layer names a set, such as `TailorSeamAPI:side`.
    pub fn check_schemas(&self, prim: &str, schemas: &[String]) -> Warnings {
        let mut warnings = Warnings::default();
        let is_required = |key: &&Key| matches!(key.domain, Domain::Sets { required: true, .. });
        for (group, sets) in
            Recipe::OPERATORS.iter().filter_map(|group| Some((group, group.keys.iter().find(is_required)?)))
        {
            let (kind, schema, sets) = (group.name, group.schema(Some("")), sets.key);
            for name in schemas.iter().filter_map(|applied| applied.strip_prefix(&schema)) {
                let named =
                    self.merged.get(kind).and_then(|names| names.get(name)).and_then(|of_name| of_name.get(sets));
                if named.is_none() {
                    let problem = format!("{schema}{name} is applied, and tailor:{kind}:{name}:{sets} names no set");
                    let remedy = format!("Target the {sets} with tailor:{kind}:{name}:{sets}, or remove the schema");
                    warnings.push(Warning::new(codes::SCHEMA_WITHOUT_SETS, prim, problem).remedy(remedy));
                }
            }
        }
        warnings
    }

    /// Whether no option is given.
    pub fn is_empty(&self) -> bool {
        self.merged.values().all(|fields| fields.as_object().is_none_or(Map::is_empty))
    }

    /// The prims of all trims, as they are named.
    pub fn trims(&self) -> Vec<String> {
        let trims = self.merged.get("trim").and_then(Value::as_object);
        let lists = trims.into_iter().flat_map(Map::values).filter_map(|trim| trim.get("prims")?.as_array());
        lists.flatten().filter_map(|name| name.as_str().map(str::to_owned)).collect()
    }

    /// Takes an option out by its key, such as `sim.maxEdgeLength`. An operator that lacks the option is taken out whole. Returns
    /// whether anything was there.
    pub fn remove(&mut self, key: &str) -> bool {
        let Some((space, key)) = key.split_once('.') else { return false };
        let Some(fields) = self.merged.get_mut(space).and_then(Value::as_object_mut) else { return false };
        let Some((name, field)) = split(space, key) else { return fields.remove(key).is_some() };
        let Some(of_instance) = fields.get_mut(name).and_then(Value::as_object_mut) else { return false };
        if of_instance.remove(field).is_none() || of_instance.is_empty() {
            fields.remove(name);
        }
        true
    }

    /// All layers merged, as nested keys.
    pub fn map(&self) -> &Map<String, Value> {
        &self.merged
    }

    /// All layers merged, as nested keys.
    pub fn into_map(self) -> Map<String, Value> {
        self.merged
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

    /// Adds a `key=value` of the command line, such as `sim.maxEdgeLength=2`.
    ///
    /// # Errors
    /// A key that no option has, or a value of another type.
    pub fn add_override(&mut self, assignment: &str) -> Result<(), Error> {
        let (key, text) = assignment.split_once('=').ok_or_else(|| {
            let fault = Error::new(ErrorKind::Usage, format!("--set {assignment}"), "it has no value")
                .code(tailor_mesh::codes::OPTION_VALUE);
            fault.remedy("write --set sim.maxEdgeLength=2")
        })?;
        self.add_text("--set", key.trim(), text.trim())
    }

    /// Adds an option with its value as text. Errors name its `giver`, such as `--set`.
    ///
    /// # Errors
    /// A key that no option has, or a value of another type.
    pub fn add_text(&mut self, giver: &str, key: &str, text: &str) -> Result<(), Error> {
        let fault = |text: String| {
            Error::new(ErrorKind::Usage, format!("{giver} {key}"), text).code(tailor_mesh::codes::OPTION_VALUE)
        };
        let dotted = dotted(key);
        let (space, field) = dotted.split_once('.').unwrap_or((&dotted, ""));
        let Some(default) = default_of(&dotted) else {
            let likely = nearest_key(&dotted).map(|key| format!("did you mean {key}? ")).unwrap_or_default();
            let remedy = format!("{likely}{}", options_of(space));
            return Err(fault("there is no such option".into()).code(codes::UNKNOWN_OPTION).remedy(remedy));
        };
        if let Some(("", _)) = split(space, field) {
            let remedy = format!("write {space}.<name>.{field}, such as {space}.a.{field}");
            return Err(fault(format!("the {space} has no name")).code(codes::UNKNOWN_OPTION).remedy(remedy));
        }
        let its_default = match is_length(&dotted) {
            true => format!("give mesh units, or a number with {UNITS}; its default is {default}"),
            false => format!("its default is {default}"),
        };
        let is_signed = find(&dotted).is_some_and(|(_, key)| key.domain.is_signed_length());
        if is_length(&dotted) && !is_signed && meters_of(text).is_some_and(|meters| meters < 0.0) {
            return Err(fault(format!("\"{text}\" is negative")).remedy("give a positive length, such as 8mm"));
        }
        let with_unit = || (is_length(&dotted) && meters_of(text).is_some()).then(|| Value::String(text.into()));
        let Some(value) = parse_like(&default, text).or_else(with_unit) else {
            return Err(fault(format!("\"{text}\" is not {}", value_type(&default).recipe)).remedy(its_default));
        };
        let mut alone = Self::default();
        alone.set(space, field, value.clone());
        if let Err(e) = serde_json::from_value::<Recipe>(Value::Object(alone.merged)) {
            return Err(fault(in_words(&e)).remedy(its_default));
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

    /// Replaces lengths that have a unit of their own, such as `8mm`, by mesh units.
    pub fn convert_lengths(&mut self, units: Units) {
        for (space, fields) in &mut self.merged {
            let Value::Object(fields) = fields else { continue };
            for (name, value) in fields {
                match value {
                    Value::Object(of_instance) => {
                        let of_instance = of_instance.iter_mut();
                        of_instance
                            .for_each(|(field, value)| convert(&format!("{space}.{name}.{field}"), value, units));
                    }
                    value => convert(&format!("{space}.{name}"), value, units),
                }
            }
        }
    }

    /// The merged recipe for a garment. A UV set that a layer names must be there; the default one may be absent.
    ///
    /// # Errors
    /// As [`Layers::recipe`]; a named UV set that the garment lacks.
    pub fn recipe_for(&self, garment: &Mesh) -> Result<Recipe, Error> {
        let recipe = self.recipe()?;
        if self.merged.get("sim").is_some_and(|sim| sim.get("uvSet").is_some()) {
            bind_uv_set(&recipe.sim, garment)?;
        }
        Ok(recipe)
    }

    /// The merged recipe, completed with defaults.
    ///
    /// # Errors
    /// A value of another type or out of its range.
    pub fn recipe(&self) -> Result<Recipe, Error> {
        let merged = Value::Object(self.merged.clone());
        let recipe: Recipe = serde_path_to_error::deserialize(merged).map_err(|e| mistyped(&e))?;
        recipe.check()?;
        Ok(recipe)
    }
}

/// The error for an option of a wrong type. It comes from an attribute, as files and flags are checked when they are read.
fn mistyped(e: &serde_path_to_error::Error<serde_json::Error>) -> Error {
    let key = |segment: &Segment| if let Segment::Map { key } = segment { Some(key.clone()) } else { None };
    let keys: Vec<String> = e.path().iter().filter_map(key).collect();
    let default = default_of(&keys.join("."));
    let fault = Error::recipe(format!("tailor:{} of the model", keys.join(":")), in_words(e.inner()))
        .code(codes::RECIPE_ATTRIBUTE);
    fault.remedy(format!("declare it as {}", value_type(&default.unwrap_or_default()).usd))
}

fn not_understood(attribute: &str) -> Warning {
    let warning = Warning::not_carried(attribute, "this version has no such option; it stays on the model");
    match nearest_key(&dotted(attribute)) {
        Some(key) => warning.remedy(format!("Did you mean tailor:{}?", key.replace('.', ":"))),
        None => warning,
    }
}

/// The key of an option that is written as its attribute is, such as `tailor:sim:maxEdgeLength`. Names of operators may
/// have colons.
pub fn dotted(key: &str) -> String {
    let key = key.strip_prefix("tailor:").unwrap_or(key);
    if key.contains('.') {
        return key.to_owned();
    }
    match (key.split_once(':'), key.rsplit_once(':')) {
        (Some((space, rest)), Some((_, field))) if group_with_instances(space).is_some() => {
            let name = rest.strip_suffix(field).unwrap_or(rest).trim_end_matches(':');
            if name.is_empty() { format!("{space}.{field}") } else { format!("{space}.{name}.{field}") }
        }
        (Some((space, rest)), _) => format!("{space}.{rest}"),
        _ => key.to_owned(),
    }
}

/// The option whose key is most like `key`, under the name of an operator that `key` has.
fn nearest_key(key: &str) -> Option<String> {
    let (space, field) = key.split_once('.').unwrap_or((key, ""));
    let name = split(space, field).map_or("", |(name, _)| name);
    let keys: Vec<String> = all_keys().iter().map(|key| key.replace("<name>", name)).collect();
    nearest(key, &keys).map(str::to_owned)
}

/// The options of a group, or the groups, in words.
fn options_of(space: &str) -> String {
    let Some(group) = all().find(|group| group.name == space) else {
        let groups: Vec<&str> = all().map(|group| group.name).collect();
        return format!("options begin with {}; `usdtailor options` lists all", groups.join(", "));
    };
    let keys: Vec<&str> = group.keys.iter().map(|key| key.key).collect();
    format!("the options of {space} are {}", keys.join(", "))
}

/// Whether an option is a length.
fn is_length(key: &str) -> bool {
    find(key).is_some_and(|(_, key)| key.domain.is_length())
}

/// Replaces the value of an option by mesh units if it is a length with a unit of its own.
fn convert(key: &str, value: &mut Value, units: Units) {
    if let Some(meters) = value.as_str().and_then(meters_of).filter(|_| is_length(key)) {
        *value = decimal(meters / units.meters());
    }
}

/// A number in single precision, with no more digits than it has.
fn decimal(value: f64) -> Value {
    (value as f32).to_string().parse().ok().and_then(serde_json::Number::from_f64).map_or(Value::Null, Value::Number)
}

/// Parses text as a value of the same type as `like`. Lists are separated by commas.
fn parse_like(like: &Value, text: &str) -> Option<Value> {
    match like {
        Value::Bool(_) => text.parse::<bool>().ok().map(Value::Bool),
        Value::Number(n) if n.is_f64() => serde_json::Number::from_f64(text.parse().ok()?).map(Value::Number),
        Value::Number(_) => text.parse::<u32>().ok().map(|n| Value::Number(n.into())),
        Value::Array(_) => Some(split_list(text).into_iter().map(Value::String).collect()),
        _ => Some(Value::String(text.into())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tailor::sim::SimOptions;

    #[test]
    fn stronger_layers_win() {
        let mut layers = Layers::default();
        let layer = serde_json::json!({"sim": {"iterations": 3, "maxEdgeLength": 4.0}});
        layers.add_attributes(layer.as_object().cloned().unwrap_or_default());
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
        layers.add_attributes(layer.as_object().cloned().unwrap_or_default());
        layers.add_override("seam.placket.width=2").expect("a good override");
        layers.add_override("seam.left:hip.edges=b,c").expect("a good override");
        layers.add_override("fold.hem.faces=d").expect("a good override");
        layers.add_override("fold.hem.side=outer").expect("a good override");
        let recipe = layers.recipe().expect("a good recipe");
        assert_eq!((recipe.seam["placket"].width, recipe.seam["placket"].edges.as_slice()), (2.0, &["a".into()][..]));
        assert_eq!((recipe.seam["left:hip"].width, recipe.seam["left:hip"].edges.len()), (1.0, 2));
        assert_eq!(recipe.fold["hem"].side, tailor::render::Side::Outer);
    }

    #[test]
    fn bad_overrides_name_the_key_and_the_remedy() {
        let mut layers = Layers::default();
        for (text, expected) in [
            ("sim.maxEdge=2", "sim.maxEdgeLength"),
            ("sim.iterations=many", "whole number"),
            ("sim.iterations", "has no value"),
            ("render.level=-1", "whole number"),
            ("seam.placket.wide=1", "width"),
            ("seam.width=1", "no name"),
            ("seam.placket.width=wide", "is not a number"),
            ("fold.hem.side=under", "`inner`"),
        ] {
            let message = layers.add_override(text).expect_err(text).to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
