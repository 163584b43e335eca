//! The message about a build that a page started.

use serde::Serialize;

/// The state of a build.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum BuildStatus {
    /// It runs.
    Running,
    /// The output is written.
    Built,
    /// Nothing is written.
    Failed,
}

/// A build that a page started.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct BuildMessage {
    /// The output.
    pub output: String,
    /// Its state.
    pub status: BuildStatus,
    /// All that the command printed.
    pub text: String,
}
