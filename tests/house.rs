//! The crates below `src`: each uses what `docs/architecture.md` draws, and keeps the budget of lines that its README names.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Folders of the crates, in the order of the drawing.
const CRATES: [&str; 6] = ["mesh", "tailor", "costume", "usd", "preview", "command"];

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()
}

/// The manifest of a crate. That of the command is the repository's.
fn manifest(folder: &str) -> String {
    let own = root().join("src").join(folder).join("Cargo.toml");
    let text = read(&if own.exists() { own } else { root().join("Cargo.toml") });
    let package = text.split_once("[package]").expect("a package").1;
    package.to_owned()
}

/// The crates that a manifest's tables of dependencies name.
fn dependencies(manifest: &str) -> BTreeSet<String> {
    let (mut found, mut is_table) = (BTreeSet::new(), false);
    for line in manifest.lines() {
        if line.starts_with('[') {
            is_table = line.ends_with("dependencies]") && !line.contains("dev-");
        } else if let Some((name, _)) = line.split_once(['.', ' ']).filter(|_| is_table && !line.starts_with('#')) {
            found.insert(name.to_owned());
        }
    }
    found
}

/// Those of this project.
fn uses(manifest: &str) -> BTreeSet<String> {
    dependencies(manifest).into_iter().filter(|name| name == "tailor" || name.starts_with("tailor-")).collect()
}

fn name(manifest: &str) -> String {
    let line = manifest.lines().find_map(|line| line.strip_prefix("name = \"")).expect("a name");
    line.trim_end_matches('"').to_owned()
}

#[test]
fn crates_use_what_the_page_draws() {
    let page = read(&root().join("docs/architecture.md"));
    let lines = page.lines().filter_map(|line| line.split_once(" -> "));
    let list = |to: &str| to.split(',').map(|name| name.trim().to_owned()).filter(|name| name != "-").collect();
    let drawn: BTreeMap<String, BTreeSet<String>> =
        lines.map(|(from, to)| (from.trim().to_owned(), list(to))).collect();
    let found: BTreeMap<String, BTreeSet<String>> =
        CRATES.iter().map(|folder| manifest(folder)).map(|text| (name(&text), uses(&text))).collect();
    assert_eq!(found, drawn, "docs/architecture.md draws other arrows than the manifests have");
}

#[test]
fn one_crate_knows_usd_and_the_paper_reads_no_files() {
    for folder in CRATES.into_iter().filter(|folder| *folder != "usd") {
        assert!(!dependencies(&manifest(folder)).contains("openusd"), "src/{folder} uses openusd");
    }
    let mut files = Vec::new();
    sources(&root().join("src/tailor"), &mut files);
    for file in files {
        let text = read(&file);
        let code: String = text.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
        for door in ["std::fs", "std::net", "tailor_mesh::files"] {
            assert!(!code.contains(door), "{} uses {door}", file.display());
        }
    }
}

/// Source files of a crate without tests.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() && !["tests", "examples", "page"].contains(&name.as_str()) {
            sources(&path, found);
        } else if name.ends_with(".rs") && name != "tests.rs" {
            found.push(path);
        }
    }
}

/// The number after some words in the README of a crate.
fn budget(folder: &Path, words: &str) -> usize {
    let readme = read(&folder.join("README.md"));
    let (_, after) = readme.split_once(words).unwrap_or_else(|| panic!("{} names no budget", folder.display()));
    after.split(' ').next().unwrap_or_default().replace(',', "").parse().expect("a number")
}

/// The lines of a file that are code: neither blank, nor comments, nor unit tests.
fn lines_of_code(text: &str) -> usize {
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    code.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//")).count()
}

#[test]
fn crates_keep_their_budgets() {
    for folder in CRATES {
        let folder = root().join("src").join(folder);
        let budget = budget(&folder, "**Budget**: ");
        let mut files = Vec::new();
        sources(&folder, &mut files);
        let lines: usize = files.iter().map(|file| lines_of_code(&read(file))).sum();
        assert!(
            lines <= budget,
            "{} has {lines} lines of code, and a budget of {budget}: make something smaller",
            folder.display()
        );
    }
}

/// Files below a folder that the page is made of.
fn of_page(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            of_page(&path, found);
        } else if path.extension().is_some_and(|ending| ["ts", "tsx", "css"].iter().any(|own| ending == *own)) {
            found.push(path);
        }
    }
}

#[test]
fn the_page_keeps_its_budget() {
    let folder = root().join("src/preview");
    let mut files = Vec::new();
    of_page(&folder.join("page/src"), &mut files);
    let lines: usize = files.iter().map(|file| read(file).lines().count()).sum();
    let budget = budget(&folder, "The page has at most ");
    assert!(lines <= budget, "the page has {lines} lines, and a budget of {budget}: make something smaller");
}

#[test]
fn the_page_of_security_counts_unsafe_blocks() {
    let mut files = Vec::new();
    ["src", "usd_plugin"].iter().for_each(|folder| sources(&root().join(folder), &mut files));
    let blocks: usize = files.iter().map(|file| read(file).matches("unsafe {").count()).sum();
    assert!(read(&root().join("SECURITY.md")).contains(&format!("has {blocks} unsafe blocks")), "{blocks} blocks");
}

/// The files of CONTRIBUTING.md that have to name each operator, which neither a compiler nor a generated file makes them do.
const PLACES: [&str; 4] = [
    "src/preview/page/src/server/options.ts",
    "python/blender/recipe.py",
    "python/blender/sets.py",
    "python/blender/panels.py",
];

#[test]
fn every_operator_is_in_all_its_places() {
    let contributing = read(&root().join("CONTRIBUTING.md"));
    for place in PLACES {
        assert!(contributing.contains(&format!("`{place}`")), "CONTRIBUTING.md lacks {place}");
        let text = read(&root().join(place));
        for group in tailor_costume::Recipe::OPERATORS {
            assert!(text.contains(&format!("\"{}\"", group.name)), "{place} lacks the operator {}", group.name);
        }
    }
}

#[test]
fn comments_blanks_and_unit_tests_are_no_code() {
    let text = "//! A page.\n\nuse a::b;\n/// A.\nfn a() {}\n\n#[cfg(test)]\nmod tests {\n    fn b() {}\n}\n";
    assert_eq!(lines_of_code(text), 2);
}
