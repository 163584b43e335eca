//! Bundles the page of the preview, from `src/preview/page` into its folder `dist`, from where the program embeds it.

use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

use crate::node;
use crate::process::{self, Failure, Outcome};
use crate::project::Project;

const SOURCE: &str = "src/preview/page";
const FILES: [&str; 3] = ["index.html", "page.js", "page.css"];
const PARTS: [&str; 6] = ["package.json", "package-lock.json", "tsconfig.json", "build.mjs", "index.html", "src"];

/// Bundles the page, unless it was bundled from the same files.
pub fn ensure(project: &Project) -> Outcome {
    let source = project.root.join(SOURCE);
    let is_there = FILES.iter().all(|name| source.join("dist").join(name).is_file());
    let is_made = is_there && fs::read_to_string(stamp(project)).is_ok_and(|made| made == state(&source));
    if is_made {
        return Ok(());
    }
    eprintln!("making the page of the preview, which takes up to a minute");
    build(project)
}

/// The file with the state of the files from which the page was bundled.
fn stamp(project: &Project) -> PathBuf {
    project.target.join("page/made-from")
}

/// A hash of all files of the page.
fn state(source: &Path) -> String {
    let mut hasher = DefaultHasher::new();
    PARTS.iter().for_each(|name| add(&source.join(name), &mut hasher));
    format!("{:016x}", hasher.finish())
}

fn add(path: &Path, hasher: &mut DefaultHasher) {
    path.hash(hasher);
    if let Ok(entries) = fs::read_dir(path) {
        let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        paths.sort();
        paths.iter().for_each(|path| add(path, hasher));
    } else {
        fs::read(path).unwrap_or_default().hash(hasher);
    }
}

/// Checks the types and bundles. Packages are installed below the target folder.
pub fn build(project: &Project) -> Outcome {
    let source = project.root.join(SOURCE);
    let work = project.target.join("page");
    let made_from = state(&source);
    for name in PARTS {
        replace(&source.join(name), &work.join(name))?;
    }
    node::install(project, &work)?;
    process::run_quietly(node::command(project, "npm", &work)?.args(["run", "check"]))?;
    process::run_quietly(node::command(project, "npm", &work)?.args(["run", "build"]))?;
    fs::create_dir_all(source.join("dist"))
        .map_err(|error| Failure::new(format!("cannot make {SOURCE}/dist: {error}")))?;
    FILES.iter().try_for_each(|name| copy_if_new(&work.join("dist").join(name), &source.join("dist").join(name)))?;
    let stamp = stamp(project);
    fs::write(&stamp, made_from).map_err(|error| Failure::new(format!("cannot write {}: {error}", stamp.display())))
}

/// Replaces a file or a folder by a copy.
pub fn replace(from: &Path, to: &Path) -> Outcome {
    let fault = |error| Failure::new(format!("cannot copy {}: {error}", from.display()));
    if !from.is_dir() {
        fs::create_dir_all(to.parent().unwrap_or(to)).map_err(fault)?;
        return fs::copy(from, to).map(drop).map_err(fault);
    }
    if to.exists() {
        fs::remove_dir_all(to).map_err(fault)?;
    }
    fs::create_dir_all(to).map_err(fault)?;
    for entry in fs::read_dir(from).map_err(fault)? {
        let name = entry.map_err(fault)?.file_name();
        replace(&from.join(&name), &to.join(&name))?;
    }
    Ok(())
}

/// A newer file of the same content would have the program compiled again.
fn copy_if_new(from: &Path, to: &Path) -> Outcome {
    let fault = |error| Failure::new(format!("cannot copy {}: {error}", from.display()));
    let content = fs::read(from).map_err(fault)?;
    if fs::read(to).is_ok_and(|known| known == content) {
        return Ok(());
    }
    fs::write(to, content).map_err(fault)
}
