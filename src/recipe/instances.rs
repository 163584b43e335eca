//! Options that a recipe has once for each instance of an operator: `seam.<name>.width`.

use crate::render::{SeamOptions, ThicknessOptions};
use serde_json::Value;

/// An option of every instance of a kind of operator.
#[derive(Clone, Copy, Debug)]
pub struct InstanceKey {
    /// The kind: the first part of its keys.
    pub kind: &'static str,
    /// The last part of its keys.
    pub field: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What it means.
    pub meaning: &'static str,
}

impl InstanceKey {
    /// The key, with a place for the name of the instance.
    pub fn pattern(&self) -> String {
        format!("{}.<name>.{}", self.kind, self.field)
    }
}

const fn key(kind: &'static str, field: &'static str, unit: &'static str, meaning: &'static str) -> InstanceKey {
    InstanceKey { kind, field, unit, meaning }
}

/// The options of instances, in the order of the schemas.
pub const INSTANCE_KEYS: [InstanceKey; 10] = [
    key("seam", "edges", "names", "edge subsets that the seam follows"),
    key("seam", "width", "stage units", "from side to side; 0: a quarter of the mean edge"),
    key("seam", "depth", "stage units", "how far the flanks swell over straight ones"),
    key("seam", "normalOffset", "stage units", "height of the centre; below 0 a groove, above a ridge"),
    key("seam", "asymmetry", "-1 to 1", "-1: all of the width on the left, 1: all on the right"),
    key("thickness", "faces", "names", "face subsets that are folded over at their border"),
    key("thickness", "amount", "stage units", "distance of the layers; 0: a tenth of the mean edge"),
    key("thickness", "weights", "name", "painted float primvar that scales the amount; empty: 1"),
    key("thickness", "side", "inner or outer", "the side of the second layer"),
    key("thickness", "closed", "true or false", "whether faces without a border get a second layer too"),
];

/// The defaults of an instance of a kind, as an object; none when there is no such kind.
pub fn instance_defaults(kind: &str) -> Option<Value> {
    match kind {
        "seam" => serde_json::to_value(SeamOptions::default()).ok(),
        "thickness" => serde_json::to_value(ThicknessOptions::default()).ok(),
        _ => None,
    }
}

/// Name and field of an instance's key, of which `rest` is what follows its kind.
pub fn split<'a>(kind: &str, rest: &'a str) -> Option<(&'a str, &'a str)> {
    instance_defaults(kind)?;
    Some(rest.rsplit_once('.').unwrap_or(("", rest)))
}

/// The table is complete, and each option of it exists.
#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_instances_is_complete() {
        for kind in ["seam", "thickness"] {
            let defaults = instance_defaults(kind).expect("a kind");
            let fields: Vec<&str> = INSTANCE_KEYS.iter().filter(|k| k.kind == kind).map(|k| k.field).collect();
            assert!(fields.iter().all(|f| defaults.get(f).is_some()), "{kind}: {fields:?}");
            assert_eq!(fields.len(), defaults.as_object().map_or(0, serde_json::Map::len), "{kind}");
        }
        assert_eq!(split("seam", "placket.width"), Some(("placket", "width")));
        assert_eq!(split("sim", "uvSet"), None);
    }
}
