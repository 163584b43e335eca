//! Unsaved edits outlive the program: a file in the user's folder for the state of programs keeps them.
//!
//! The page cannot keep them itself, as the next server has another address, for which a browser has another store.

use super::Hub;
use crate::document::Options;
use crate::messages::KeptEdits;
use crate::stage::Stage;
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use std::{env, fs, io, thread};
use tailor_mesh::error::{Error, plain};
use tailor_mesh::files;
use tailor_usd::session::Input;
use tailor_usd::write_whole;

/// Time between two writes.
const PERIOD: Duration = Duration::from_secs(1);

/// Edits that were not saved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    /// The last change. \[milliseconds since 1970\]
    pub time: u64,
    /// The checksum of the options below them, which may have changed since.
    pub upstream: String,
    /// The edits.
    pub edits: Options,
}

impl Kept {
    /// As it is offered over the options of a garment.
    pub fn offered(&self, upstream: &Options) -> KeptEdits {
        KeptEdits { time: self.time, is_current: self.upstream == checksum_of(upstream) }
    }
}

/// The checksum of the options below edits.
pub fn checksum_of(upstream: &Options) -> String {
    let text = serde_json::to_vec(upstream).unwrap_or_default();
    blake3::hash(&text).to_hex()[..16].to_owned()
}

/// The edits that were kept of one garment.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Content {
    /// The file of the garment, for people who look into the folder.
    garment: String,
    /// The path of the mesh.
    prim: String,
    /// Oldest first. The last one is of the server that runs.
    kept: Vec<Kept>,
}

/// The file that keeps the unsaved edits of one garment with one recipe.
pub struct Keeper {
    file: PathBuf,
    last: Mutex<Last>,
}

/// The revision and the content of the last write to the file.
struct Last {
    revision: u64,
    content: Content,
}

impl Keeper {
    /// The keeper of a garment in `folder`, and the edits that it has of earlier servers.
    pub fn new(folder: &Path, input: &Input, stage: &Stage) -> (Self, Vec<Kept>) {
        let name = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_path_buf()).display().to_string();
        let (garment, prim) = (name(stage.source.file()), stage.source.whole().to_owned());
        let recipe = input.recipe.as_deref().map(name).unwrap_or_default();
        let key = blake3::hash(format!("{garment}\0{}\0{recipe}\0{prim}", name(&input.file)).as_bytes());
        let file = folder.join(format!("{}.json", &key.to_hex()[..32]));
        let earlier: Option<Content> = files::text(&file).ok().and_then(|text| serde_json::from_str(&text).ok());
        let kept = earlier.unwrap_or_default().kept;
        let content = Content { garment, prim, kept: kept.clone() };
        (Self { file, last: Mutex::new(Last { revision: 0, content }) }, kept)
    }

    /// Writes the edits of a revision, unless the file has them, or those of a later one. Without edits, the file is removed.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub fn write(&self, revision: u64, kept: Vec<Kept>) -> io::Result<()> {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let same = |(a, b): (&Kept, &Kept)| a.edits == b.edits;
        let is_known = last.content.kept.len() == kept.len() && last.content.kept.iter().zip(&kept).all(same);
        if revision < last.revision || is_known {
            return Ok(());
        }
        last.revision = revision;
        last.content.kept = kept;
        if last.content.kept.is_empty() {
            return fs::remove_file(&self.file);
        }
        private_folder(self.file.parent().unwrap_or(Path::new("")))?;
        write_whole(&self.file, &serde_json::to_vec(&last.content)?, true)
    }
}

/// The user's folder for unsaved edits, by the rules of the system; none where there is no home.
pub fn state_folder() -> Option<PathBuf> {
    let folder = |name: &str| env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let home = || folder("HOME");
    let state = match env::consts::OS {
        "windows" => folder("LOCALAPPDATA"),
        "macos" => folder("XDG_STATE_HOME").or_else(|| Some(home()?.join("Library/Application Support"))),
        _ => folder("XDG_STATE_HOME").or_else(|| Some(home()?.join(".local/state"))),
    };
    Some(state?.join("usdtailor/unsaved"))
}

/// Makes a folder that is the user's alone.
fn private_folder(folder: &Path) -> io::Result<()> {
    let mut builder = fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(folder)
}

/// Starts the thread that writes the unsaved edits of a hub.
///
/// # Errors
/// A thread that cannot be started.
pub fn start(hub: &Arc<Hub>, keeper: &Arc<Keeper>) -> Result<(), Error> {
    let (hub, keeper) = (Arc::clone(hub), Arc::clone(keeper));
    let keep = move || {
        let (mut seen, mut has_failed) = (0, false);
        loop {
            let (revision, kept) = hub.next_unsaved(seen);
            seen = revision;
            if let Err(e) = keeper.write(revision, kept)
                && !std::mem::replace(&mut has_failed, true)
            {
                let folder = keeper.file.parent().unwrap_or(&keeper.file).display();
                let _ = writeln!(io::stderr(), "warning: unsaved edits are not kept in {folder}: {}", plain(&e));
            }
            thread::sleep(PERIOD);
        }
    };
    thread::Builder::new().name("keep".into()).spawn(keep).map(drop).map_err(Error::no_thread)
}
