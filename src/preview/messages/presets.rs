//! The messages of presets.

use super::super::document::Options;
use serde::Serialize;
use tailor_mesh::error::Fault;

/// The presets of seams and folds. Sent at first, and again each time their file has changed.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct PresetsMessage<'a> {
    /// The file beside the garment.
    pub file: String,
    /// Built-in presets: for each kind of operator, values by name. Lengths are in mesh units.
    #[cfg_attr(feature = "typescript", ts(type = "Presets"))]
    pub built_in: &'a Options,
    /// Presets of the file.
    #[cfg_attr(feature = "typescript", ts(type = "Presets"))]
    pub saved: &'a Options,
}

/// The answer to `preset`.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct PresetSavedMessage {
    /// The name of the preset.
    pub name: String,
    /// The file.
    pub file: String,
    /// True if it was to be taken out.
    pub removed: bool,
    /// The reason of a refusal.
    pub fault: Option<Fault>,
}
