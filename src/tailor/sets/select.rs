//! Selections that are changed by further sets.

use super::elements::ElementSet;
use super::expression::{Expression, Operation, quoted, split_list};
use super::functions::picked;
use super::list::ListedSet;
use super::{SetEvaluator, SetFault};
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use tailor_mesh::garment::{DERIVED, Subset};

/// Sets that are named together. Artists read more of them no more easily than numbers.
const MOST_NAMES: usize = 6;

/// How a set changes a selection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Change {
    /// It replaces the selection.
    Replace,
    /// Its elements are added.
    Add,
    /// Its elements are taken away.
    Remove,
}

impl SetEvaluator<'_> {
    /// A selection after a change; none where no element is left. Its expression is made from the two texts. Numbers of
    /// elements in these give way to the names of `known` sets that have the same elements together.
    ///
    /// # Errors
    /// Faults of either text, and sets of two kinds.
    pub fn select(
        &self,
        selection: &str,
        change: Change,
        set: &str,
        known: &[Subset],
    ) -> Result<Option<ListedSet>, SetFault> {
        let other = Expression::parse(set)?;
        let mut selected = self.elements(&other)?;
        let mut text = set.to_owned();
        let mut is_picked = picked::is_picked(&other);
        if change != Change::Replace && !selection.is_empty() {
            let before = Expression::parse(selection)?;
            let (operation, sign) =
                if change == Change::Add { (Operation::Union, '+') } else { (Operation::Difference, '-') };
            selected = self.elements(&before)?.combine(operation, selected)?;
            is_picked |= picked::is_picked(&before);
            let before = if split_list(selection).len() > 1 { format!("({selection})") } else { selection.to_owned() };
            let after = if matches!(other, Expression::Combined(..)) { format!("({set})") } else { set.to_owned() };
            text = format!("{before} {sign} {after}");
        }
        if is_picked {
            let numbers = || picked::expression(&self.topology, &selected);
            text = self.names_of(&selected, known).or_else(numbers).unwrap_or(text);
        }
        Ok(self.listed(text, &selected, ""))
    }

    /// The names of known sets that are these elements together, the largest first.
    fn names_of(&self, set: &ElementSet, known: &[Subset]) -> Option<String> {
        let elements = |subset: &Subset| ElementSet::of(&self.topology, &subset.elements);
        // Sets of one element are of primvars that number elements.
        let fits = |len: usize| len == set.len() || (2..set.len()).contains(&len);
        let all = known.iter().filter(|subset| fits(subset.elements.len()));
        let mut inside: Vec<_> =
            all.map(|subset| (subset, elements(subset))).filter(|(_, of)| set.contains(of)).collect();
        // Of equals, a subset of the garment comes before what is derived.
        inside.sort_by_key(|(_, of)| Reverse(of.len()));
        let (mut rest, mut names) = (set.clone(), Vec::new());
        for (subset, of) in inside {
            if rest.contains(&of) {
                rest = rest.combine(Operation::Difference, of).ok()?;
                names.push(if subset.family == DERIVED { subset.name.clone() } else { quoted(&subset.name) });
            }
        }
        (rest.is_empty() && names.len() <= MOST_NAMES).then(|| names.join(" + "))
    }
}
