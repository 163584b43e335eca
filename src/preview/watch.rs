//! Reads the stage again when one of its files changes, and the presets when theirs does.

use super::hub::Hub;
use super::save::presets;
use notify::{Event, EventKind, RecommendedWatcher, RecursiveMode, Watcher};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;
use tailor_mesh::error::Error;

/// Programs write a file in several steps. It is read when nothing has changed for this long.
const QUIET: Duration = Duration::from_millis(80);
/// Events are not longer waited for after this many.
const EVENTS: usize = 64;

/// Follows the files of the stage until the watcher is dropped.
///
/// # Errors
/// A system that cannot watch files.
pub fn follow(hub: &Arc<Hub>) -> Result<impl Sized, Error> {
    let fault = |e: &dyn std::fmt::Display| Error::internal(format!("cannot watch files: {e}"));
    let (sender, events) = channel();
    let watcher = notify::recommended_watcher(move |event| drop(sender.send(event))).map_err(|e| fault(&e))?;
    let watcher = Arc::new(Mutex::new(watcher));
    let mut followed = WatchList {
        watcher: Arc::clone(&watcher),
        folders: BTreeSet::new(),
        files: BTreeSet::new(),
        presets: BTreeSet::new(),
    };
    followed.update(hub);
    let hub = Arc::clone(hub);
    let work = move || {
        while let Some(changed) = followed.wait(&events) {
            if changed.stage {
                hub.reload();
                followed.update(&hub);
            }
            // A garment in another unit has presets of other numbers.
            presets::read(&hub);
        }
    };
    thread::Builder::new().name("watch".into()).spawn(work).map_err(|e| fault(&e))?;
    Ok(watcher)
}

struct WatchList {
    watcher: Arc<Mutex<RecommendedWatcher>>,
    /// Folders are watched, as programs replace a file by renaming another one.
    folders: BTreeSet<PathBuf>,
    files: BTreeSet<PathBuf>,
    /// The paths of the file of presets.
    presets: BTreeSet<PathBuf>,
}

/// The files that have changed.
#[derive(Clone, Copy, Default)]
struct Changed {
    stage: bool,
    presets: bool,
}

/// The paths by which the system may name a file. A link may be pointed at another version of its file.
fn paths(file: &Path) -> impl Iterator<Item = PathBuf> {
    [std::path::absolute(file).ok(), file.canonicalize().ok()].into_iter().flatten()
}

impl WatchList {
    fn update(&mut self, hub: &Hub) {
        let stage = hub.snapshot().stage;
        self.files.extend(stage.files.iter().flat_map(|file| paths(file)));
        self.presets.extend(paths(&presets::file_of(&stage)));
        let folders: BTreeSet<PathBuf> =
            self.files.iter().chain(&self.presets).filter_map(|file| file.parent().map(Path::to_owned)).collect();
        let mut watcher = self.watcher.lock().unwrap_or_else(PoisonError::into_inner);
        for folder in folders {
            if !self.folders.contains(&folder) && watcher.watch(&folder, RecursiveMode::NonRecursive).is_ok() {
                self.folders.insert(folder);
            }
        }
    }

    /// Waits until files have changed; none when the watcher has ended.
    fn wait(&self, events: &Receiver<notify::Result<Event>>) -> Option<Changed> {
        let mut changed = Changed::default();
        while !changed.stage && !changed.presets {
            self.note(&events.recv().ok()?, &mut changed);
        }
        for _ in 0..EVENTS {
            match events.recv_timeout(QUIET) {
                Ok(event) => self.note(&event, &mut changed),
                Err(RecvTimeoutError::Timeout) => return Some(changed),
                Err(RecvTimeoutError::Disconnected) => return None,
            }
        }
        Some(changed)
    }

    fn note(&self, event: &notify::Result<Event>, changed: &mut Changed) {
        let Ok(event) = event else { return changed.stage = true };
        if matches!(event.kind, EventKind::Access(_)) {
            return;
        }
        changed.stage |= event.paths.iter().any(|path| self.files.contains(path));
        changed.presets |= event.paths.iter().any(|path| self.presets.contains(path));
    }
}
