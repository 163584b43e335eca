//! The schemas and the crate name the same options, with the same types and defaults: a second reading of what
//! `cargo xtask options` writes.

use serde_json::Value;
use std::collections::BTreeMap;
use tailor_costume::recipe::table;

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
fn expected(option: &Value) -> (&'static str, String) {
    let value = &option["default"];
    match value {
        _ if option["domain"]["type"] == "sets" || option["domain"]["type"] == "prims" => ("rel", String::new()),
        _ if option["domain"]["type"] == "file" => ("asset", "@@".to_owned()),
        Value::Bool(b) => ("bool", u8::from(*b).to_string()),
        Value::Number(n) if n.is_f64() => ("float", format!("{}", n.as_f64().unwrap_or_default())),
        Value::Number(n) => ("int", n.to_string()),
        Value::Array(words) => {
            let words: Vec<String> = words.iter().map(ToString::to_string).collect();
            ("token[]", format!("[{}]", words.join(", ")))
        }
        _ => ("token", value.to_string()),
    }
}

#[test]
fn schemas_and_options_agree() {
    let mut properties = schema_properties();
    let table = serde_json::to_value(table()).expect("JSON");
    for group in table.as_array().expect("groups") {
        let name = group["name"].as_str().expect("a name");
        let space = if group["hasInstances"] == true { format!("{name}.{INSTANCE}") } else { name.to_owned() };
        for option in group["options"].as_array().expect("options") {
            let name = format!("{space}.{}", option["key"].as_str().expect("a key"));
            let (kind, default) = properties.remove(&name).unwrap_or_else(|| panic!("the schema has no {name}"));
            assert_eq!((kind.as_str(), default), expected(option), "{name}");
        }
    }
    assert!(properties.is_empty(), "the crate has no {properties:?}");
}
