//! The message about the cache that is played.

use crate::error::Fault;
use serde::Serialize;

/// The cache that is played, after it was opened and after each frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ShotMessage {
    /// The file.
    pub file: String,
    /// Times of its frames. \[time codes\]
    pub times: Vec<f64>,
    /// Frames of a second.
    pub rate: f64,
    /// The frame that is shown; null for the meshes at bind.
    pub frame: Option<usize>,
    /// Why it cannot be played.
    pub fault: Option<Fault>,
}

impl ShotMessage {
    /// Of a cache that cannot be played.
    pub fn failed(fault: Option<Fault>) -> Self {
        Self { file: String::new(), times: Vec::new(), rate: 0.0, frame: None, fault }
    }
}
