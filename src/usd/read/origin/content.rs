//! What was read of each file of a stage: a file that another program replaces meanwhile must not mix two versions.

use crate::files::{open, read};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::Metadata;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

/// Words of the error of a file with another content than before.
pub const CHANGED: &str = "it was written to while it was read";

/// The hash of the content of each file that was read. A stage that is opened again reads the same, or fails.
#[derive(Debug, Default)]
pub struct ReadFiles(Mutex<Known>);

#[derive(Debug, Default)]
struct Known {
    hashes: BTreeMap<PathBuf, blake3::Hash>,
    /// The state of packages, which are read in parts.
    packages: BTreeMap<PathBuf, (u64, Option<SystemTime>)>,
    changed: BTreeSet<PathBuf>,
}

impl ReadFiles {
    fn known(&self) -> MutexGuard<'_, Known> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The content of a file.
    ///
    /// # Errors
    /// A file that cannot be read, or that had another content before.
    pub fn read(&self, file: &Path) -> io::Result<Vec<u8>> {
        let bytes = read(file)?;
        self.note(file, blake3::hash(&bytes))?;
        Ok(bytes)
    }

    /// Notes a package. Its entries are read one by one, so its state stands for its content from the second time on.
    ///
    /// # Errors
    /// As [`ReadFiles::read`].
    pub fn package(&self, file: &Path) -> io::Result<()> {
        let opened = open(file)?;
        let state = state(&opened.metadata()?);
        match self.known().packages.get(file) {
            Some(known) if *known == state => return Ok(()),
            Some(_) => return Err(self.note_change(file)),
            None => {}
        }
        let mut hasher = blake3::Hasher::new();
        hasher.update_reader(opened)?;
        self.note(file, hasher.finalize())?;
        self.known().packages.insert(file.to_path_buf(), state);
        Ok(())
    }

    fn note(&self, file: &Path, hash: blake3::Hash) -> io::Result<()> {
        let before = *self.known().hashes.entry(file.to_path_buf()).or_insert(hash);
        if before == hash { Ok(()) } else { Err(self.note_change(file)) }
    }

    fn note_change(&self, file: &Path) -> io::Error {
        self.known().changed.insert(file.to_path_buf());
        io::Error::other(CHANGED)
    }

    /// The hash of what was read of a file, if it was.
    pub fn hash(&self, file: &Path) -> Option<String> {
        self.known().hashes.get(file).map(|hash| hash.to_hex().to_string())
    }

    /// The first file that had another content the second time.
    pub fn changed(&self) -> Option<PathBuf> {
        self.known().changed.first().cloned()
    }
}

fn state(metadata: &Metadata) -> (u64, Option<SystemTime>) {
    (metadata.len(), metadata.modified().ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_with_other_content_is_an_error() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("a.usda");
        let files = ReadFiles::default();
        std::fs::write(&file, "one").expect("a file");
        assert_eq!(files.read(&file).expect("readable"), b"one");
        let hash = files.hash(&file);
        std::fs::write(&file, "two").expect("a file");
        assert_eq!(files.read(&file).map_err(|e| e.to_string()), Err(CHANGED.to_owned()));
        assert_eq!((files.hash(&file), files.changed()), (hash, Some(file)));
    }
}
