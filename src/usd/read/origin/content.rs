//! The content of each file of a stage, as it was first read: a file that another program replaces must not mix two versions.

use super::converted::{Converted, has_converter};
use super::resolver::package_file;
use crate::assets::same_file;
use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;
use tailor_mesh::error::Warning;
use tailor_mesh::files::{metadata, read};

/// Words of the error of a file with another content than before.
pub const CHANGED: &str = "it was written to while it was read";

/// The hash of the content of each file that was read. A stage that is opened again reads the same, or fails.
#[derive(Debug, Default)]
pub struct ReadFiles(Mutex<Known>);

#[derive(Debug, Default)]
struct Known {
    /// The bytes and the hash of each file.
    contents: BTreeMap<PathBuf, (u64, blake3::Hash)>,
    /// The state of packages, which are read in parts.
    packages: BTreeMap<PathBuf, State>,
    changed: BTreeSet<PathBuf>,
    /// The metadata that were left out of each layer.
    left_out: BTreeMap<PathBuf, Vec<&'static str>>,
    /// Each layer as converted, or none for a layer that the library reads; or the stage alone, by its file. Unset before conversion begins.
    converted: Option<BTreeMap<PathBuf, Option<Converted>>>,
    /// Whether the stage was flattened, or tried to be.
    flattens: bool,
}

impl Known {
    /// The converted layers, or the flattened stage, each with its file.
    fn all(&self) -> impl Iterator<Item = (&PathBuf, &Converted)> {
        self.converted.iter().flatten().filter_map(|(place, converted)| Some((place, converted.as_ref()?)))
    }

    /// Why another program was ended, if one was.
    fn ended(&self) -> Option<String> {
        self.all().find_map(|(_, converted)| converted.result.as_ref().err().cloned())
    }
}

/// Bytes and time of a file.
type State = (u64, Option<SystemTime>);

impl ReadFiles {
    fn known(&self) -> MutexGuard<'_, Known> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The content of a file.
    ///
    /// # Errors
    /// A file that cannot be read, or that had another content before.
    pub fn read(&self, file: &Path) -> io::Result<Vec<u8>> {
        self.keep(file, read(file)?)
    }

    /// The content of a file that has just been read.
    ///
    /// # Errors
    /// A file that had another content before.
    pub fn keep(&self, file: &Path, bytes: Vec<u8>) -> io::Result<Vec<u8>> {
        let content = (bytes.len() as u64, blake3::hash(&bytes));
        let before = *self.known().contents.entry(file.to_path_buf()).or_insert(content);
        if before == content { Ok(bytes) } else { Err(self.note_change(file)) }
    }

    /// Notes a package, whose entries are read one by one.
    ///
    /// # Errors
    /// A file that cannot be read, or that was in another state before.
    pub fn package(&self, file: &Path) -> io::Result<()> {
        let state = state(file)?;
        let before = *self.known().packages.entry(file.to_path_buf()).or_insert(state);
        if before == state { Ok(()) } else { Err(self.note_change(file)) }
    }

    /// Notes metadata that were left out of a layer.
    pub fn leave_out(&self, layer: &Path, mut fields: Vec<&'static str>) {
        fields.sort_unstable();
        fields.dedup();
        if !fields.is_empty() {
            self.known().left_out.insert(layer.to_path_buf(), fields);
        }
    }

    /// Has layers converted from now on, if something can. If they are already, has the stage of `file` flattened, which the library
    /// cannot read for this reason. Whether that is new.
    pub fn convert(&self, file: &str, fault: String) -> bool {
        let mut known = self.known();
        if !has_converter() || known.flattens || known.ended().is_some() {
            return false;
        }
        let Some(layers) = &mut known.converted else {
            known.converted = Some(BTreeMap::new());
            return true;
        };
        let stage = Converted::of(file, true, fault);
        let is_new = stage.as_ref().is_some_and(|stage| stage.result.is_ok());
        if is_new {
            layers.clear();
        }
        layers.insert(file.into(), stage);
        known.flattens = true;
        is_new
    }

    /// The flattened content of the stage, if this is its file or an entry of its package.
    pub fn flattened(&self, layer: &Path) -> Option<Arc<[u8]>> {
        let known = self.known();
        let (file, stage) = known.all().find(|(_, converted)| converted.is_stage)?;
        let content = &stage.result.as_ref().ok()?.content;
        same_file(&package_file(layer), file).then(|| Arc::clone(content))
    }

    /// The content of a layer that is converted.
    pub fn converted(&self, layer: &Path) -> Option<Arc<[u8]>> {
        if let Some(flattened) = self.flattened(layer) {
            return Some(flattened);
        }
        let content = |known: &Option<Converted>| Some(Arc::clone(&known.as_ref()?.result.as_ref().ok()?.content));
        if let Some(known) = self.known().converted.as_ref()?.get(layer) {
            return content(known);
        }
        let converted = layer.to_str().filter(|_| self.ended().is_none()).and_then(Converted::of_layer);
        content(self.known().converted.get_or_insert_default().entry(layer.to_path_buf()).or_insert(converted))
    }

    /// The files of the layers of a stage that was flattened.
    pub fn flattened_files(&self) -> Vec<PathBuf> {
        self.known().all().filter_map(|(_, one)| one.result.as_ref().ok()).flat_map(|one| one.files.clone()).collect()
    }

    /// The notes about layers that were converted, or about the stage that was flattened.
    pub fn notes(&self) -> Vec<Warning> {
        self.known().all().map(|(place, converted)| converted.note(place)).collect()
    }

    /// Why another program was ended before it had converted something.
    pub fn ended(&self) -> Option<String> {
        self.known().ended()
    }

    /// The warnings of what was left out, and the notes about layers that were converted.
    pub fn warnings(&self) -> Vec<Warning> {
        let warning = |(layer, fields): (&PathBuf, &Vec<&str>)| {
            Warning::not_carried(layer.display(), format!("{}: flattened outputs are without them", fields.join(", ")))
        };
        let mut all: Vec<Warning> = self.known().left_out.iter().map(warning).collect();
        all.extend(self.notes());
        all
    }

    fn note_change(&self, file: &Path) -> io::Error {
        self.known().changed.insert(file.to_path_buf());
        io::Error::other(CHANGED)
    }

    /// The bytes and the hash of a file; none of a package.
    pub fn content(&self, file: &Path) -> Option<(u64, String)> {
        self.known().contents.get(file).map(|(bytes, hash)| (*bytes, hash.to_hex().to_string()))
    }

    /// The first file that had another content the second time, or package that is in another state now.
    pub fn changed(&self) -> Option<PathBuf> {
        let known = self.known();
        let is_other = |(file, before): &(&PathBuf, &State)| state(file).is_ok_and(|now| now != **before);
        known.changed.first().or_else(|| known.packages.iter().find(is_other).map(|(file, _)| file)).cloned()
    }
}

fn state(file: &Path) -> io::Result<State> {
    let metadata = metadata(file)?;
    Ok((metadata.len(), metadata.modified().ok()))
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
        let content = files.content(&file);
        std::fs::write(&file, "two").expect("a file");
        assert_eq!(files.read(&file).map_err(|e| e.to_string()), Err(CHANGED.to_owned()));
        assert_eq!((files.content(&file), files.changed()), (content, Some(file)));
    }
}
