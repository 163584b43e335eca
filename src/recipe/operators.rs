//! Options that a recipe has once for each instance, such as `seam.<name>.width`.

use super::Recipe;
use crate::cloth::FabricOptions;
use crate::render::{Kind, OperatorOptions, SeamOptions, ThicknessOptions};
use serde::Serialize;
use std::sync::LazyLock;

/// The kinds of options that have instances: operators in the default order of execution, and fabrics.
pub static KINDS: LazyLock<[Kind; 3]> =
    LazyLock::new(|| [kind::<ThicknessOptions>(), kind::<SeamOptions>(), FabricOptions::kind()]);

fn kind<O: OperatorOptions + Default + Serialize>() -> Kind {
    let (options, defaults) = (O::default(), || serde_json::to_value(O::default()).unwrap_or_default());
    Kind { name: options.kind(), keys: options.keys(), defaults, is_operator: true }
}

impl Recipe {
    /// The options of all operators by name, in the order of [`KINDS`].
    pub fn operators(&self) -> Vec<(&str, &dyn OperatorOptions)> {
        let seams = self.seams.iter().map(|(name, options)| (name.as_str(), options as &dyn OperatorOptions));
        let thicknesses = self.thicknesses.iter().map(|(name, options)| (name.as_str(), options as _));
        thicknesses.chain(seams).collect()
    }

    /// The operators that are not left out.
    pub(crate) fn enabled(&self) -> impl Iterator<Item = (&str, &dyn OperatorOptions)> {
        self.operators().into_iter().filter(|(_, options)| options.is_enabled())
    }

    /// Replaces automatic lengths (0) by multiples of the garment's mean edge length. \[mesh units\]
    pub(crate) fn resolve_lengths(&mut self, mean_edge: f32) {
        let sim = &mut self.sim;
        if sim.max_edge_length <= 0.0 {
            sim.max_edge_length = (0.5 * mean_edge).max(sim.min_edge_length);
        }
        if sim.min_edge_length <= 0.0 {
            sim.min_edge_length = sim.max_edge_length * if sim.density.is_empty() { 1.0 } else { 0.5 };
        }
        self.seams.values_mut().for_each(|options| options.resolve_lengths(mean_edge));
        self.thicknesses.values_mut().for_each(|options| options.resolve_lengths(mean_edge));
    }
}

/// The kind called `name`.
pub fn kind_named(name: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| kind.name == name)
}

/// Splits the rest of an operator's key, after its kind, into name and field. The name is empty if it is missing.
pub fn split<'a>(kind: &str, rest: &'a str) -> Option<(&'a str, &'a str)> {
    kind_named(kind)?;
    Some(rest.rsplit_once('.').unwrap_or(("", rest)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_of_operators_are_complete() {
        for kind in KINDS.iter() {
            let defaults = (kind.defaults)();
            assert!(kind.keys.iter().all(|key| defaults.get(key.key).is_some()), "{kind:?}");
            assert_eq!(kind.keys.len(), defaults.as_object().map_or(0, serde_json::Map::len), "{kind:?}");
        }
        assert_eq!(split("seam", "placket.width"), Some(("placket", "width")));
        assert_eq!(split("sim", "uvSet"), None);
    }
}
