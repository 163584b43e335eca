//! Selections that are changed by further sets.

use super::elements::ElementSet;
use super::expression::{Expression, Operation, quoted, split_list};
use super::functions::picked;
use super::list::ListedSet;
use super::{SetEvaluator, SetFault};
use crate::garment::{DERIVED, Subset};
use serde::{Deserialize, Serialize};

/// What is done with a set that comes to a selection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum Change {
    /// It replaces the selection.
    Replace,
    /// Its elements are added.
    Add,
    /// Its elements are taken away.
    Remove,
}

impl SetEvaluator<'_> {
    /// A selection after a change; none where no element is left. Its expression is the name of one of the `known` sets that
    /// has the same elements, or else made from the two texts, or else has the numbers of the elements if one of these does.
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
        let numbers = || picked::expression(&self.topology, &selected).filter(|_| is_picked);
        let text = self.name_of(&selected, known).or_else(numbers).unwrap_or(text);
        Ok(self.listed(text, &selected, ""))
    }

    /// The first of some sets that has these elements.
    fn name_of(&self, set: &ElementSet, known: &[Subset]) -> Option<String> {
        let same = |subset: &&Subset| {
            subset.elements.len() == set.len() && ElementSet::of(&self.topology, &subset.elements).has_same(set)
        };
        let found = known.iter().find(same)?;
        Some(if found.family == DERIVED { found.name.clone() } else { quoted(&found.name) })
    }
}
