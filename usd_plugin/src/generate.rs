//! Generates a layer from a recipe and a composed source, with one [`Session`] for the process.

use crate::ffi::{Argument, Generated};
use std::collections::HashSet;
use std::path::Path;
use std::str;
use std::sync::{LazyLock, Mutex, PoisonError};
use tailor::error::{Error, Warnings};
use tailor::session::{self, Session};

/// Memory for cached results, unless `USDTAILOR_CACHE_MB` sets it. \[megabytes\]
const CACHE: usize = 512;

/// Number of remembered warnings, above which the memory is cleared.
const MAX_REPORTED: usize = 10_000;

static SESSION: LazyLock<Result<Session, String>> = LazyLock::new(|| {
    let megabytes = number("USDTAILOR_CACHE_MB").and_then(|n| usize::try_from(n).ok()).unwrap_or(CACHE);
    Session::new(megabytes.saturating_mul(1 << 20), threads()).map_err(|e| e.to_string())
});

/// The warnings reported so far, each with its file: an edit reports only new ones.
static REPORTED: LazyLock<Mutex<HashSet<String>>> = LazyLock::new(Mutex::default);

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
        let document = session::PayloadRecipe::new(Path::new(path), text, arguments).map_err(|e| e.to_string())?;
        Ok(Self { path: path.into(), document })
    }

    pub fn path(&self) -> &str {
        &self.path
    }

    pub fn source(&self) -> &str {
        self.document.source()
    }

    pub fn generate(&self, flattened: &[u8], metadata_only: bool) -> Result<Generated, String> {
        let session = SESSION.as_ref().map_err(String::clone)?;
        let built = session.layer(&self.document, flattened, metadata_only);
        let (layer, warnings) = built.map_err(|e: Error| e.to_string())?;
        Ok(Generated { layer, warnings: self.new_warnings(&warnings) })
    }

    /// The warnings that have not been reported for this file before.
    fn new_warnings(&self, warnings: &Warnings) -> Vec<String> {
        let mut reported = REPORTED.lock().unwrap_or_else(PoisonError::into_inner);
        if reported.len() > MAX_REPORTED {
            reported.clear();
        }
        let texts = warnings.iter().map(ToString::to_string);
        texts.filter(|text| reported.insert(format!("{}\n{text}", self.path))).collect()
    }
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
