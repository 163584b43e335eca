//! The documents as a site, with MkDocs Material.

use crate::process::{self, Outcome};
use crate::project::Project;
use crate::{links, venv};

/// Makes the environment of [`build`].
pub fn prepare(project: &Project) -> Outcome {
    venv::ensure_site(project).map(drop)
}

/// Checks the links of the documents, and draws them in `target/site`. A warning of MkDocs is a failure.
pub fn build(project: &Project) -> Outcome {
    links::check(project)?;
    let python = venv::ensure_site(project)?;
    let mut command = project.command(python);
    // Not --quiet, which hides warnings from --strict. Material for MkDocs prints an advertisement otherwise.
    command.env("NO_MKDOCS_2_WARNING", "1");
    command.args(["-m", "mkdocs", "build", "--strict", "-f", "xtask/site/mkdocs.yml", "--site-dir"]);
    process::run(command.arg(project.target.join("site")))
}
