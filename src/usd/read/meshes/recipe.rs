//! The options of several panels as those of one garment.

use serde_json::{Map, Value};
use tailor_mesh::error::Error;

/// Options that list sets of elements: panels share the sets, and so the lists.
const LISTS_OF_SETS: &[&str] = &["constraints", "pins", "edges", "faces"];

/// Merges the options of panels, each with its path. Lists of sets are joined.
///
/// # Errors
/// An option that two panels give different values; it names both.
pub fn merge(panels: &[(&str, Map<String, Value>)]) -> Result<Map<String, Value>, Error> {
    let mut merged = Map::new();
    for (i, (panel, options)) in panels.iter().enumerate() {
        for (key, value) in options {
            let mut path = vec![key.as_str()];
            add(&mut merged, &mut path, value).map_err(|key| {
                let lookup = |options: &Map<String, Value>| lookup(options, &key).cloned();
                let (with, earlier) = panels[..i]
                    .iter()
                    .find_map(|(name, options)| Some((*name, lookup(options)?)))
                    .unwrap_or((panels[0].0, Value::Null));
                let now = lookup(options).unwrap_or_default();
                let attribute = format!("tailor:{}", key.join(":"));
                Error::recipe(
                    format!("{with}, {panel}"),
                    format!(
                        "they are parts of one garment, and {attribute} is {earlier} on one and {now} on the other"
                    ),
                )
                .code(tailor_mesh::codes::PANELS_DIFFER)
                .remedy("give both the same value, or author it on one of them alone")
            })?;
        }
    }
    Ok(merged)
}

/// Adds the value of an option.
///
/// # Errors
/// The names that lead to an option with another value.
fn add(into: &mut Map<String, Value>, path: &mut Vec<&str>, value: &Value) -> Result<(), Vec<String>> {
    let key = path.last().copied().unwrap_or_default().to_owned();
    match (into.get_mut(&key), value) {
        (None, value) => _ = into.insert(key, value.clone()),
        (Some(Value::Object(known)), Value::Object(fields)) => {
            for (field, value) in fields {
                let mut path = path.clone();
                path.push(field);
                add(known, &mut path, value)?;
            }
        }
        (Some(Value::Array(known)), Value::Array(more)) if LISTS_OF_SETS.contains(&key.as_str()) => {
            for set in more {
                if !known.contains(set) {
                    known.push(set.clone());
                }
            }
        }
        (Some(known), value) if known == value => {}
        _ => return Err(path.iter().map(|&name| name.to_owned()).collect()),
    }
    Ok(())
}

fn lookup<'a>(options: &'a Map<String, Value>, path: &[String]) -> Option<&'a Value> {
    let (last, spaces) = path.split_last()?;
    spaces.iter().try_fold(options, |options, space| options.get(space)?.as_object())?.get(last)
}
