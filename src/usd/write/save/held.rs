//! Outputs that are complete, and get their names once something else is written.

use super::OutputFile;
use super::unfinished::Unfinished;
use std::sync::{Arc, Mutex, PoisonError};
use tailor_mesh::error::Error;
use tempfile::NamedTempFile;

/// A complete output, and its file under a temporary name.
type Waiting = (OutputFile, Unfinished<NamedTempFile>);

/// Where a complete output waits for its name. It is removed if it gets none.
#[derive(Clone, Debug, Default)]
pub struct HeldOutput(Arc<Mutex<Option<Waiting>>>);

impl HeldOutput {
    pub(super) fn put(&self, file: OutputFile, temporary: Unfinished<NamedTempFile>) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some((file, temporary));
    }

    /// Gives the output its name, if one waits.
    ///
    /// # Errors
    /// A full disk; a file that has this name in the meantime, unless it may be replaced.
    pub fn release(&self) -> Result<(), Error> {
        let waiting = self.0.lock().unwrap_or_else(PoisonError::into_inner).take();
        waiting.map_or(Ok(()), |(file, temporary)| file.keep(temporary))
    }
}
