//! Generates a layer from a recipe and a composed source, with one [`Session`] for each process.

use crate::ffi::{Argument, Generated};
use std::collections::HashSet;
use std::path::Path;
use std::ptr;
use std::str;
use std::sync::atomic::{AtomicPtr, Ordering};
use std::sync::{Mutex, PoisonError};
use tailor_mesh::error::{Error, ErrorKind, Fault, Warnings};
use tailor_usd::session::{self, Session};

/// Memory for cached results, unless `USDTAILOR_CACHE_MB` sets it. \[megabytes\]
const CACHE: usize = 512;

/// Number of remembered warnings, above which the memory is cleared.
const MAX_REPORTED: usize = 10_000;

/// What a process keeps between layers.
struct Process {
    id: u32,
    session: Result<Session, String>,
    /// The warnings reported so far, each with its file: an edit reports only new ones.
    reported: Mutex<HashSet<String>>,
}

static PROCESS: AtomicPtr<Process> = AtomicPtr::new(ptr::null_mut());

impl Process {
    fn new() -> Self {
        let megabytes = number("USDTAILOR_CACHE_MB").and_then(|n| usize::try_from(n).ok()).unwrap_or(CACHE);
        let session = Session::new(megabytes.saturating_mul(1 << 20), threads()).map_err(|e| e.to_string());
        Self { id: std::process::id(), session, reported: Mutex::default() }
    }

    /// That of this process. A forked child has no thread of its parent's pool, and would wait for it: it makes its own, without
    /// a lock that a thread of the parent may have held.
    fn own() -> &'static Self {
        let mut known = PROCESS.load(Ordering::Acquire);
        loop {
            // SAFETY: a pointer in `PROCESS` comes from a box that is never freed.
            match unsafe { known.as_ref() } {
                Some(process) if process.id == std::process::id() => return process,
                _ => {}
            }
            let new = Box::into_raw(Box::new(Self::new()));
            match PROCESS.compare_exchange(known, new, Ordering::AcqRel, Ordering::Acquire) {
                Ok(_) => known = new,
                Err(other) => {
                    // SAFETY: no one else has the pointer.
                    drop(unsafe { Box::from_raw(new) });
                    known = other;
                }
            }
        }
    }
}

/// A `.tailor` file and the arguments that it was opened with.
#[derive(Debug)]
pub struct Document {
    path: String,
    document: session::PayloadRecipe,
}

impl Document {
    pub fn read(path: &str, text: &[u8], arguments: &[Argument]) -> Result<Self, String> {
        let text = str::from_utf8(text).map_err(|_| "it is not UTF-8 text\n  hint: a recipe is JSON".to_owned())?;
        let arguments = arguments.iter().map(|a| (a.key.as_str(), a.value.as_str()));
        let document = session::PayloadRecipe::new(Path::new(path), text, arguments).map_err(|e| coded(&e, path))?;
        Ok(Self { path: path.into(), document })
    }

    pub fn path(&self) -> &str {
        &self.path
    }

    pub fn source(&self) -> &str {
        self.document.source()
    }

    pub fn generate(&self, flattened: &[u8], metadata_only: bool) -> Result<Generated, String> {
        let session = Process::own().session.as_ref().map_err(String::clone)?;
        let built = session.layer(&self.document, flattened, metadata_only);
        let (layer, warnings) = built.map_err(|e| coded(&e, &self.path))?;
        Ok(Generated { layer, warnings: self.new_warnings(&warnings) })
    }

    /// The warnings that have not been reported for this file before, the worst first.
    fn new_warnings(&self, warnings: &Warnings) -> Vec<String> {
        let mut reported = Process::own().reported.lock().unwrap_or_else(PoisonError::into_inner);
        if reported.len() > MAX_REPORTED {
            reported.clear();
        }
        let texts = warnings.worst_first().into_iter().map(|warning| format!("[{}] {warning}", warning.code));
        texts.filter(|text| reported.insert(format!("{}\n{text}", self.path))).collect()
    }
}

/// The faults of an error with their codes, which `usdtailor explain` takes. Each message of the file `path` begins with its name.
fn coded(error: &Error, path: &str) -> String {
    if error.kind == ErrorKind::Internal {
        return error.to_string();
    }
    let line = |fault: &Fault| {
        let place = if fault.place == path { String::new() } else { fault.place.clone() };
        format!("[{}] {}", fault.code, Fault { place, ..fault.clone() })
    };
    let mut lines: Vec<String> = error.faults.iter().map(line).collect();
    lines.extend((error.more > 0).then(|| format!("and {} more", error.more)));
    lines.join("\n")
}

/// The number of threads by OpenUSD's `PXR_WORK_THREAD_LIMIT`: all if it is unset or 0, and all but `n` if it is `-n`.
fn threads() -> Option<usize> {
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    match number("PXR_WORK_THREAD_LIMIT")? {
        0 => None,
        limit if limit > 0 => Some(usize::try_from(limit).map_or(all, |limit| limit.min(all))),
        left => Some(all.saturating_sub(usize::try_from(left.unsigned_abs()).unwrap_or(all)).max(1)),
    }
}

fn number(variable: &str) -> Option<i64> {
    std::env::var(variable).ok()?.trim().parse().ok()
}
