//! The garments that tests run on: the examples of this repository and, where they are, shared ones beside it.

use std::io::Write;
use std::path::{Path, PathBuf};

/// Every example and every shared garment; says so where the latter are absent.
pub fn garments() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut all = stages(&root.join("examples"));
    assert!(all.len() >= 3, "the examples are in the repository");
    let shared = stages(&root.join("../shared/garments"));
    if shared.is_empty() {
        // Past the capture of the test harness, so that it is seen.
        let _ = writeln!(std::io::stderr(), "NOTE: no ../shared/garments; these tests run on the examples alone");
    }
    all.extend(shared);
    all
}

/// USD files in a folder, by name.
fn stages(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let is_stage = |p: &PathBuf| p.extension().is_some_and(|e| e == "usda" || e == "usdc");
    let mut files: Vec<PathBuf> = entries.filter_map(|e| Some(e.ok()?.path())).filter(is_stage).collect();
    files.sort();
    files
}
