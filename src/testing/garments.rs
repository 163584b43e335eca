//! The garments that tests run on: the examples and those of `tests/garments`, or those of a folder that `TAILOR_GARMENTS` names.
//!
//! Tests over [`garments()`] have the word `garments` in their paths, and hold for any garment.

use std::path::{Path, PathBuf};

/// The folders of the project's garments.
const FOLDERS: [&str; 2] = ["examples", "tests/garments"];

/// Every garment of the project, or every one of the folder that `TAILOR_GARMENTS` names.
pub fn garments() -> Vec<PathBuf> {
    match std::env::var_os("TAILOR_GARMENTS").map(PathBuf::from) {
        None => FOLDERS.into_iter().flat_map(of_project).collect(),
        Some(folder) => {
            let all = stages(&folder);
            assert!(!all.is_empty(), "TAILOR_GARMENTS: no .usda or .usdc file is in the folder `{}`", folder.display());
            all
        }
    }
}

/// A garment of the project, by the name of its file.
pub fn named(name: &str) -> PathBuf {
    let mut all = FOLDERS.into_iter().flat_map(of_project);
    all.find(|file| file.ends_with(name)).unwrap_or_else(|| panic!("no garment of the project is `{name}`"))
}

fn of_project(folder: &str) -> Vec<PathBuf> {
    let all = stages(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(folder));
    assert!(all.len() >= 3, "`{folder}` has {} garments", all.len());
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
