//! The message of a page's selection.

use serde::Serialize;
use tailor_mesh::connectivity::Elements;
use tailor_mesh::error::Fault;

/// The answer to `select`.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct SelectionMessage {
    /// The selection as an expression; empty where nothing is selected.
    pub expression: String,
    /// Its elements.
    pub elements: Option<Elements>,
    /// Its length \[m\] or area \[m²\]; null for points.
    pub size: Option<f64>,
    /// True for a closed loop of edges.
    pub is_closed: bool,
    /// The reason of a refusal; the selection stays.
    pub fault: Option<Fault>,
}
