//! From a recipe and a composed source to a layer, through the one [`Session`] of the process.

use crate::ffi::{Argument, Generated};
use std::collections::HashSet;
use std::path::Path;
use std::str;
use std::sync::{LazyLock, Mutex, PoisonError};
use tailor::error::{Error, Warnings};
use tailor::recipe;
use tailor::session::Session;

/// Memory for results, where `USDTAILOR_CACHE_MB` says nothing. \[megabytes\]
const CACHE: usize = 512;

/// Texts of warnings that are remembered, so that each is told once and not with every edit.
const MOST_TOLD: usize = 10_000;

static SESSION: LazyLock<Result<Session, String>> = LazyLock::new(|| {
    let megabytes = number("USDTAILOR_CACHE_MB").and_then(|n| usize::try_from(n).ok()).unwrap_or(CACHE);
    Session::new(megabytes.saturating_mul(1 << 20), threads()).map_err(|e| e.to_string())
});

static TOLD: LazyLock<Mutex<HashSet<String>>> = LazyLock::new(Mutex::default);

/// A `.tailor` file with the arguments it was opened with.
#[derive(Debug)]
pub struct Document {
    path: String,
    document: recipe::Document,
}

impl Document {
    pub fn read(path: &str, text: &[u8], arguments: &[Argument]) -> Result<Self, String> {
        let text = str::from_utf8(text).map_err(|_| "it is not text\n  hint: a recipe is JSON".to_owned())?;
        let arguments = arguments.iter().map(|a| (a.key.as_str(), a.value.as_str()));
        let document = recipe::Document::new(Path::new(path), text, arguments).map_err(|e| e.to_string())?;
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
        let mut warnings = Warnings::default();
        let layer = session.layer(&self.document, flattened, metadata_only, &mut warnings);
        let layer = layer.map_err(|e: Error| e.to_string())?;
        Ok(Generated { layer, warnings: self.untold(&warnings) })
    }

    /// The warnings that were not told before of this file.
    fn untold(&self, warnings: &Warnings) -> Vec<String> {
        let mut told = TOLD.lock().unwrap_or_else(PoisonError::into_inner);
        if told.len() > MOST_TOLD {
            told.clear();
        }
        let texts = warnings.iter().map(ToString::to_string);
        texts.filter(|text| told.insert(format!("{}\n{text}", self.path))).collect()
    }
}

/// As many threads as OpenUSD takes by `PXR_WORK_THREAD_LIMIT`: all when it is not set or 0, and all but so many when
/// it is negative.
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
