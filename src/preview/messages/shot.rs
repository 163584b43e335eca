//! The message about the cache that is played.

use serde::Serialize;
use tailor_mesh::error::Fault;

/// The cache that is played, after it was opened and after each frame.
#[derive(Clone, Debug, Default, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct ShotMessage {
    /// The file.
    pub file: String,
    /// Its number of frames.
    pub frames: usize,
    /// Frames of a second.
    pub rate: f64,
    /// The frame that is shown; null for the meshes at bind.
    pub frame: Option<usize>,
    /// The time of that frame. \[time codes\]
    pub time: Option<f64>,
    /// Why it cannot be played.
    pub fault: Option<Fault>,
}
