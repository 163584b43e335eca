//! The options that were changed in the preview, with undo and redo.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::collections::VecDeque;

/// A sparse recipe, as nested keys.
pub type Options = Map<String, Value>;

/// Steps of undo that are kept.
const HISTORY: usize = 200;
/// Memory of the steps of undo that are kept, in all. \[bytes\]
const HISTORY_BYTES: usize = 64 << 20;

/// A state that is shown in place of the edits, for comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Before {
    /// Before the last step.
    Step,
    /// As it was last saved, or else opened.
    Saved,
}

/// Earlier or later edits.
#[derive(Debug)]
struct Step {
    edits: Options,
    /// About the memory that they take.
    bytes: usize,
}

impl Step {
    fn new(edits: Options) -> Self {
        Self { bytes: edits.iter().map(entry_bytes).sum(), edits }
    }
}

/// The edits of all pages over the options of the garment.
#[derive(Debug, Default)]
pub struct EditHistory {
    edits: Options,
    past: VecDeque<Step>,
    future: Vec<Step>,
    /// The gesture of the last step. Edits of one gesture, such as one drag, are one step.
    gesture: String,
    saved: Options,
    /// The state that is shown in place of the edits.
    pub comparing: Option<Before>,
}

impl EditHistory {
    /// A document that begins with the options of a recipe file.
    pub fn new(edits: Options) -> Self {
        Self { saved: edits.clone(), edits, ..Self::default() }
    }

    /// Replaces the edits.
    pub fn edit(&mut self, edits: Options, gesture: String) {
        self.comparing = None;
        if edits == self.edits {
            return;
        }
        let before = std::mem::replace(&mut self.edits, edits);
        self.future.clear();
        if gesture.is_empty() || gesture != self.gesture {
            self.past.push_back(Step::new(before));
            self.forget();
        }
        self.gesture = gesture;
    }

    /// Forgets the oldest steps beyond the bounds; the last one stays.
    fn forget(&mut self) {
        let mut bytes: usize = self.past.iter().map(|step| step.bytes).sum();
        while self.past.len() > HISTORY || (bytes > HISTORY_BYTES && self.past.len() > 1) {
            bytes -= self.past.pop_front().map_or(0, |step| step.bytes);
        }
    }

    /// Goes back a step.
    pub fn undo(&mut self) {
        if let Some(before) = self.past.pop_back() {
            self.future.push(Step::new(std::mem::replace(&mut self.edits, before.edits)));
            self.gesture.clear();
        }
    }

    /// Goes forward a step.
    pub fn redo(&mut self) {
        if let Some(after) = self.future.pop() {
            self.past.push_back(Step::new(std::mem::replace(&mut self.edits, after.edits)));
            self.gesture.clear();
        }
    }

    /// The edits.
    pub fn edits(&self) -> &Options {
        &self.edits
    }

    /// The edits that are shown: earlier ones while comparing.
    pub fn shown(&self) -> &Options {
        match self.comparing {
            None => &self.edits,
            Some(Before::Step) => self.past.back().map_or(&self.edits, |step| &step.edits),
            Some(Before::Saved) => &self.saved,
        }
    }

    /// True if there is a step to go back.
    pub fn can_undo(&self) -> bool {
        !self.past.is_empty()
    }

    /// True if there is a step to go forward.
    pub fn can_redo(&self) -> bool {
        !self.future.is_empty()
    }

    /// True if the edits are not in a file.
    pub fn is_unsaved(&self) -> bool {
        self.edits != self.saved
    }

    /// Notes that `edits` are in a file.
    pub fn note_saved(&mut self, edits: Options) {
        self.saved = edits;
    }
}

/// About the memory of an entry.
fn entry_bytes((key, value): (&String, &Value)) -> usize {
    size_of::<String>() + text_bytes(key) + value_bytes(value)
}

/// About the memory of a value.
fn value_bytes(value: &Value) -> usize {
    size_of::<Value>()
        + match value {
            Value::String(text) => text_bytes(text),
            Value::Array(values) => values.iter().map(value_bytes).sum(),
            Value::Object(fields) => fields.iter().map(entry_bytes).sum(),
            _ => 0,
        }
}

/// The memory of a text, which an allocator rounds up.
fn text_bytes(text: &str) -> usize {
    text.len().next_multiple_of(16) + 16
}

/// The options of `layer` that differ from those of `weaker`.
pub fn changed(layer: &Options, weaker: &Options) -> Options {
    let mut out = Options::new();
    for (key, value) in layer {
        match (value, weaker.get(key)) {
            (Value::Object(fields), Some(Value::Object(weaker))) => {
                let rest = changed(fields, weaker);
                if !rest.is_empty() {
                    out.insert(key.clone(), Value::Object(rest));
                }
            }
            (value, weaker) if Some(value) != weaker => {
                out.insert(key.clone(), value.clone());
            }
            _ => {}
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn level(level: u32) -> Options {
        json!({"render": {"level": level}}).as_object().cloned().unwrap_or_default()
    }

    #[test]
    fn a_gesture_is_one_step() {
        let mut document = EditHistory::new(level(0));
        document.edit(level(1), "drag 1".into());
        document.edit(level(2), "drag 1".into());
        document.edit(level(3), "drag 2".into());
        document.undo();
        assert_eq!(document.edits(), &level(2));
        document.undo();
        assert_eq!((document.edits(), document.can_undo()), (&level(0), false));
        document.redo();
        assert_eq!(document.edits(), &level(2));
        document.edit(level(5), "drag 2".into());
        assert!(!document.can_redo(), "an edit ends what could be redone");
        document.undo();
        assert_eq!(document.edits(), &level(2), "a gesture does not go on after an undo");
    }

    #[test]
    fn an_earlier_state_is_shown_while_comparing() {
        let mut document = EditHistory::new(level(0));
        document.edit(level(1), String::new());
        document.edit(level(2), String::new());
        for (before, shown) in [(Before::Step, level(1)), (Before::Saved, level(0))] {
            document.comparing = Some(before);
            assert_eq!((document.shown(), document.edits()), (&shown, &level(2)));
        }
        document.edit(level(3), String::new());
        assert_eq!(document.shown(), &level(3), "an edit ends the comparison");
    }

    #[test]
    fn the_past_is_bounded() {
        let mut document = EditHistory::default();
        (0..5000).for_each(|i| document.edit(level(i), String::new()));
        (0..5000).for_each(|_| document.undo());
        assert_eq!(document.edits(), &level(5000 - 1 - HISTORY as u32));
    }

    #[test]
    fn the_memory_of_the_past_is_bounded() {
        let mut document = EditHistory::default();
        // As many numbers as fit into a message.
        let large = |i: usize| {
            let numbers: Vec<usize> = (0..150_000).map(|k| k ^ i).collect();
            json!({"seam": {"a": {"edges": numbers}}}).as_object().cloned().unwrap_or_default()
        };
        (0..30).for_each(|i| document.edit(large(i), String::new()));
        let bytes: usize = document.past.iter().map(|step| step.bytes).sum();
        assert!((HISTORY_BYTES / 2..=HISTORY_BYTES).contains(&bytes), "{bytes}");
        document.undo();
        assert_eq!(document.edits(), &large(28), "the newest steps stay");
        (0..30).for_each(|_| document.undo());
        assert!(!document.can_undo() && document.edits() != &large(0));
        (0..30).for_each(|_| document.redo());
        assert_eq!(document.edits(), &large(29));
    }

    #[test]
    fn options_that_a_weaker_layer_has_are_no_change() {
        let layer = json!({"sim": {"iterations": 3, "seed": 1}, "seam": {"a": {"width": 1.0}}});
        let weaker = json!({"sim": {"iterations": 3}, "seam": {"a": {"width": 1.0, "depth": 2.0}}});
        let [layer, weaker] = [layer, weaker].map(|v| v.as_object().cloned().unwrap_or_default());
        assert_eq!(Value::Object(changed(&layer, &weaker)), json!({"sim": {"seed": 1}}));
    }
}
