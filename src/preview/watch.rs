//! Reads the stage again when one of its files changes.

use super::hub::Hub;
use crate::error::Error;
use notify::{Event, EventKind, RecommendedWatcher, RecursiveMode, Watcher};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// Programs write a file in several steps. It is read when nothing has changed for this long.
const QUIET: Duration = Duration::from_millis(80);
/// Events are not longer waited for after this many.
const EVENTS: usize = 64;

/// The watcher, which ends when it is dropped.
pub struct Following {
    _watcher: Arc<Mutex<RecommendedWatcher>>,
}

/// Follows the files of the stage.
///
/// # Errors
/// A system that cannot watch files.
pub fn follow(hub: &Arc<Hub>) -> Result<Following, Error> {
    let fault = |e: &dyn std::fmt::Display| Error::internal(format!("cannot watch files: {e}"));
    let (sender, events) = channel();
    let watcher = notify::recommended_watcher(move |event| drop(sender.send(event))).map_err(|e| fault(&e))?;
    let watcher = Arc::new(Mutex::new(watcher));
    let mut followed = WatchList { watcher: Arc::clone(&watcher), folders: BTreeSet::new(), files: BTreeSet::new() };
    followed.update(hub);
    let hub = Arc::clone(hub);
    let work = move || {
        while followed.wait(&events) {
            hub.reload();
            followed.update(&hub);
        }
    };
    thread::Builder::new().name("watch".into()).spawn(work).map_err(|e| fault(&e))?;
    Ok(Following { _watcher: watcher })
}

struct WatchList {
    watcher: Arc<Mutex<RecommendedWatcher>>,
    /// Folders are watched, as programs replace a file by renaming another one.
    folders: BTreeSet<PathBuf>,
    files: BTreeSet<PathBuf>,
}

impl WatchList {
    fn update(&mut self, hub: &Hub) {
        for file in hub.snapshot().stage.files() {
            // A link may be pointed at another version of its file.
            self.files.extend([std::path::absolute(&file).ok(), file.canonicalize().ok()].into_iter().flatten());
        }
        let folders: BTreeSet<PathBuf> =
            self.files.iter().filter_map(|file| file.parent().map(Path::to_owned)).collect();
        let mut watcher = self.watcher.lock().unwrap_or_else(PoisonError::into_inner);
        for folder in folders {
            if !self.folders.contains(&folder) && watcher.watch(&folder, RecursiveMode::NonRecursive).is_ok() {
                self.folders.insert(folder);
            }
        }
    }

    /// Waits until a file has changed; false when the watcher has ended.
    fn wait(&self, events: &Receiver<notify::Result<Event>>) -> bool {
        loop {
            match events.recv() {
                Ok(event) if self.concerns(&event) => break,
                Ok(_) => {}
                Err(_) => return false,
            }
        }
        for _ in 0..EVENTS {
            match events.recv_timeout(QUIET) {
                Ok(_) => {}
                Err(RecvTimeoutError::Timeout) => return true,
                Err(RecvTimeoutError::Disconnected) => return false,
            }
        }
        true
    }

    fn concerns(&self, event: &notify::Result<Event>) -> bool {
        let Ok(event) = event else { return true };
        !matches!(event.kind, EventKind::Access(_)) && event.paths.iter().any(|path| self.files.contains(path))
    }
}
