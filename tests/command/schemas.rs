//! The schemas and the crate name the same options, with the same types and defaults.

use serde_json::Value;
use std::collections::BTreeMap;
use tailor::recipe::{KINDS, defaults};

/// What stands for the name of an instance in a schema that is applied more than once.
const INSTANCE: &str = "__INSTANCE_NAME__";

/// Type and default of each `tailor:` property of the schemas.
fn schema_properties() -> BTreeMap<String, (String, String)> {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/schemas/generatedSchema.usda"))
        .expect("generatedSchema.usda");
    let properties = text.lines().filter_map(|line| {
        let line = line.trim().trim_end_matches('(').trim();
        let (head, default) = line.split_once('=').unwrap_or((line, ""));
        let mut words = head.trim().trim_start_matches("uniform ").split_whitespace();
        let (kind, name) = (words.next()?, words.next()?.strip_prefix("tailor:")?);
        Some((name.replace(':', "."), (kind.to_owned(), default.trim().to_owned())))
    });
    properties.collect()
}

/// The type and default that the schema must have for an option of the crate.
fn expected(value: &Value) -> Vec<(&'static str, String)> {
    match value {
        Value::Bool(b) => vec![("bool", u8::from(*b).to_string())],
        Value::Number(n) if n.is_f64() => vec![("float", format!("{}", n.as_f64().unwrap_or_default()))],
        Value::Number(n) => vec![("int", n.to_string())],
        Value::String(s) => vec![("token", format!("\"{s}\""))],
        Value::Array(words) if !words.is_empty() => {
            let words: Vec<String> = words.iter().map(ToString::to_string).collect();
            vec![("token[]", format!("[{}]", words.join(", ")))]
        }
        // A list of names is a relationship where the names are prims, else tokens.
        _ => vec![("rel", String::new()), ("token[]", "[]".into())],
    }
}

#[test]
fn schemas_and_options_agree() {
    let properties = schema_properties();
    let mut options = Vec::new();
    let once = defaults();
    let once = once.as_object().expect("an object").iter().map(|(space, fields)| (space.clone(), fields.clone()));
    let each = KINDS.iter().map(|kind| (format!("{}.{INSTANCE}", kind.name), (kind.defaults)()));
    for (space, fields) in once.chain(each) {
        for (key, value) in fields.as_object().expect("an object") {
            let name = format!("{space}.{key}");
            let (kind, default) = properties.get(&name).unwrap_or_else(|| panic!("the schema has no {name}"));
            let fits = expected(value).iter().any(|(k, d)| k == kind && d == default);
            assert!(fits, "{name} is {kind} = {default} in the schema and {value} in the crate");
            options.push(name);
        }
    }
    let extra: Vec<_> = properties.keys().filter(|name| !options.contains(name)).collect();
    assert!(extra.is_empty(), "the crate has no {extra:?}");
}
