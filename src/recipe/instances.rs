//! Options that a recipe has once for each instance of an operator: `seam.<name>.width`.

use super::Recipe;
use crate::render::{Instance, Kind, SeamOptions, ThicknessOptions};
use serde_json::Value;

/// The kinds of operators, in the order in which their instances run where no other is given.
pub static KINDS: [Kind; 2] = [Kind::of::<SeamOptions>(), Kind::of::<ThicknessOptions>()];

impl Recipe {
    /// The options of all instances, by name, in the order of [`KINDS`].
    pub fn instances(&self) -> Vec<(&str, &dyn Instance)> {
        let seams = self.seams.iter().map(|(name, options)| (name.as_str(), options as &dyn Instance));
        let thicknesses = self.thicknesses.iter().map(|(name, options)| (name.as_str(), options as &dyn Instance));
        seams.chain(thicknesses).collect()
    }

    /// The same, to be changed.
    pub(crate) fn instances_mut(&mut self) -> impl Iterator<Item = &mut dyn Instance> {
        let seams = self.seams.values_mut().map(|options| options as &mut dyn Instance);
        seams.chain(self.thicknesses.values_mut().map(|options| options as &mut dyn Instance))
    }
}

/// The kind of a name.
pub fn kind_named(name: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| kind.name == name)
}

/// The defaults of an instance of a kind, as an object; none when there is no such kind.
pub fn instance_defaults(kind: &str) -> Option<Value> {
    kind_named(kind).map(|kind| (kind.defaults)())
}

/// Name and field of an instance's key, of which `rest` is what follows its kind.
pub fn split<'a>(kind: &str, rest: &'a str) -> Option<(&'a str, &'a str)> {
    kind_named(kind)?;
    Some(rest.rsplit_once('.').unwrap_or(("", rest)))
}

/// The table is complete, and each option of it exists.
#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_of_instances_are_complete() {
        for kind in &KINDS {
            let defaults = (kind.defaults)();
            assert!(kind.keys.iter().all(|key| defaults.get(key.field).is_some()), "{kind:?}");
            assert_eq!(kind.keys.len(), defaults.as_object().map_or(0, serde_json::Map::len), "{kind:?}");
        }
        assert_eq!(split("seam", "placket.width"), Some(("placket", "width")));
        assert_eq!(split("sim", "uvSet"), None);
    }
}
