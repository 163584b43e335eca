//! Folders for outputs.

use std::fs;
use std::path::{Path, PathBuf};
use tailor_mesh::error::{Error, plain};

/// Whether `-o` is a folder for so many outputs.
pub fn is_folder(out: &Path, outputs: usize) -> bool {
    outputs > 1 || out.is_dir() || out.to_string_lossy().ends_with(std::path::is_separator)
}

/// Folders that a run has made. Those in which nothing is go again with it.
pub struct MadeFolders(Vec<PathBuf>);

impl MadeFolders {
    /// Makes a folder and those above it, where they are missing.
    ///
    /// # Errors
    /// A path that cannot be a folder.
    pub fn new(folder: &Path) -> Result<Self, Error> {
        let is_missing = |path: &&Path| !path.as_os_str().is_empty() && !path.exists();
        let made = Self(folder.ancestors().take_while(is_missing).map(Path::to_path_buf).collect());
        fs::create_dir_all(folder).map_err(|e| {
            let fault = Error::usd(format!("cannot make the folder {}: {}", folder.display(), plain(&e)));
            fault.code(tailor_usd::codes::OUTPUT_PATH).remedy("name a folder by -o that you may write to").caused_by(e)
        })?;
        Ok(made)
    }
}

impl Drop for MadeFolders {
    fn drop(&mut self) {
        for folder in &self.0 {
            // A folder that holds something is not removed.
            let _ = fs::remove_dir(folder);
        }
    }
}
