//! Recipes of a few options, with values of their type or absurd ones.

use super::choices::Choices;
use tailor_costume::recipe::{Domain, Layers, table};

/// Numbers in the text of a recipe.
const NUMBERS: [&str; 18] = [
    "0", "1", "0.1", "0.5", "0.05", "2", "3", "0.02", "-0.1", "-1", "30", "180", "1e-30", "1e3", "1e9", "-1e9",
    "3.4e38", "nan",
];
/// Names that a mesh may or may not have.
const NAMES: [&str; 8] = ["edges", "faces", "points", "edges,edges", "", "st", "paint", "seam.a,fold.a"];
/// Levels and counts; those between 3 and the limits would take minutes.
const COUNTS: [&str; 7] = ["0", "1", "2", "3", "7", "100000", "4294967295"];

/// The options, without those that are refused as they are given.
pub fn layers(choices: &mut Choices) -> Layers {
    let (groups, mut layers) = (table(), Layers::default());
    for _ in 0..choices.below(8) {
        let group = &groups[choices.below(groups.len())];
        let prefix = if group.has_instances { format!("{}.a", group.name) } else { group.name.to_owned() };
        if group.is_operator {
            // An operator without its sets is refused.
            let sets = if group.name == "seam" { "edges" } else { "faces" };
            let _ = layers.add_override(&format!("{prefix}.{sets}={sets}"));
        }
        let option = &group.options[choices.below(group.options.len())].key;
        let _ = layers.add_override(&format!("{prefix}.{}={}", option.key, value(choices, option.domain)));
    }
    layers
}

fn value(choices: &mut Choices, domain: Domain) -> String {
    let words = match domain {
        Domain::Flag => &["true", "false"][..],
        Domain::Number { .. } | Domain::Length { .. } => &NUMBERS,
        Domain::Whole { .. } => &COUNTS,
        Domain::Choice { words } | Domain::Words { words } => words,
        _ => &NAMES,
    };
    choices.one_of(words).to_owned()
}
