//! The selection of a page, from the sets that it is made of.

use super::hub::Snapshot;
use super::messages::SelectionMessage;
use tailor::sets::{Change, SetEvaluator};
use tailor_costume::recipe::Recipe;

/// A selection after a change, in the UV set of the recipe that is shown.
pub fn select(now: &Snapshot, selection: &str, change: Change, set: &str) -> SelectionMessage {
    let (stage, recipe) = (&now.stage, now.stage.recipe(&now.state.edits));
    let resolved = recipe.and_then(|recipe| stage.checks.resolve(&recipe));
    let uv_set = match resolved.or_else(|_| stage.checks.resolve(&Recipe::default())) {
        Ok(recipe) => recipe.sim.uv_set,
        Err(error) => {
            return SelectionMessage { fault: error.faults.into_iter().next(), ..SelectionMessage::default() };
        }
    };
    let sets = SetEvaluator::new(stage.checks.garment(), &uv_set);
    match sets.select(selection, change, set, &stage.shown.subsets) {
        Ok(None) => SelectionMessage::default(),
        Ok(Some(set)) => SelectionMessage {
            expression: set.expression,
            elements: Some(set.elements),
            size: set.size,
            is_closed: set.is_closed,
            fault: None,
        },
        Err(fault) => {
            let fault = fault.at("the selection").faults.into_iter().next();
            SelectionMessage { fault, ..SelectionMessage::default() }
        }
    }
}
