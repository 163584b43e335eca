//! Bundles the page of the preview, from `src/preview/page` into its folder `dist`, from where the program embeds it.

use std::fs;
use std::path::Path;

use crate::node;
use crate::process::{self, Failure, Outcome};
use crate::project::Project;

const SOURCE: &str = "src/preview/page";
const FILES: [&str; 3] = ["index.html", "page.js", "page.css"];

/// Checks the types and bundles. Packages are installed below the target folder.
pub fn build(project: &Project) -> Outcome {
    let source = project.root.join(SOURCE);
    let work = project.target.join("page");
    for name in ["package.json", "package-lock.json", "tsconfig.json", "build.mjs", "index.html", "src"] {
        replace(&source.join(name), &work.join(name))?;
    }
    node::install(project, &work)?;
    process::run_quietly(node::command(project, "npm", &work)?.args(["run", "check"]))?;
    process::run_quietly(node::command(project, "npm", &work)?.args(["run", "build"]))?;
    FILES.iter().try_for_each(|name| copy_if_new(&work.join("dist").join(name), &source.join("dist").join(name)))
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
