//! Creates the Python environments of the tests: `target/venv` with usd-core, numpy and pytest, and one per older
//! wheel.

use std::fs;
use std::path::{Path, PathBuf};

use crate::process::{self, Failure, Outcome};
use crate::project::Project;

const REQUIREMENTS: &str = "tests/usd/requirements.txt";
const SITE: &str = "xtask/site/requirements.txt";
const PACKAGING: &str = "python/requirements.txt";
const NEWTON: &str = "tests/newton/requirements.txt";

/// Creates `target/venv`, or recreates it if its requirements have changed, and returns its interpreter.
pub fn ensure(project: &Project) -> Outcome<PathBuf> {
    let wanted = project.read(REQUIREMENTS)?;
    ensure_with(project, "venv", &wanted, &["--requirement", REQUIREMENTS])
}

/// Like [`ensure`], for the solver that the tests of cloth run.
pub fn ensure_newton(project: &Project) -> Outcome<PathBuf> {
    let wanted = project.read(NEWTON)?;
    ensure_with(project, "venv-newton", &wanted, &["--requirement", NEWTON])
}

/// Like [`ensure`], for the program that draws the documents.
pub fn ensure_site(project: &Project) -> Outcome<PathBuf> {
    let wanted = project.read(SITE)?;
    ensure_with(project, "venv-site", &wanted, &["--requirement", SITE])
}

/// Like [`ensure`], for the programs that make the Python package.
pub fn ensure_packaging(project: &Project) -> Outcome<PathBuf> {
    let wanted = project.read(PACKAGING)?;
    ensure_with(project, "venv-packaging", &wanted, &["--requirement", PACKAGING])
}

/// A new environment with the Python package, and what its tests need.
pub fn with_package(project: &Project, wheel: &Path) -> Outcome<PathBuf> {
    let folder = project.target.join("venv-package");
    create(project, &folder)?;
    let python = interpreter(&folder);
    let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--requirement", REQUIREMENTS];
    process::run(project.command(&python).args(pip).arg(wheel))?;
    Ok(python)
}

/// Like [`ensure`], for an environment with only one version of usd-core.
pub fn ensure_wheel(project: &Project, version: &str) -> Outcome<PathBuf> {
    ensure_package(project, &format!("venv-{version}"), &format!("usd-core=={version}"))
}

/// Like [`ensure`], for an environment `name` with only one package.
pub fn ensure_package(project: &Project, name: &str, package: &str) -> Outcome<PathBuf> {
    ensure_with(project, name, package, &["--only-binary", ":all:", package])
}

fn ensure_with(project: &Project, name: &str, wanted: &str, what: &[&str]) -> Outcome<PathBuf> {
    let folder = project.target.join(name);
    let python = interpreter(&folder);
    // Written last, so that an interrupted installation is repeated.
    let installed = folder.join("installed-requirements.txt");
    if python.exists() && fs::read_to_string(&installed).is_ok_and(|text| text == wanted) {
        return Ok(python);
    }
    create(project, &folder)?;
    eprintln!("installing {}", what.last().unwrap_or(&name));
    let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
    process::run(project.command(&python).args(pip).args(what))?;
    fs::write(&installed, wanted)
        .map_err(|error| Failure::new(format!("cannot write {}: {error}", installed.display())))?;
    Ok(python)
}

fn create(project: &Project, folder: &Path) -> Outcome {
    if folder.is_symlink() {
        return Err(
            Failure::new(format!("{} is a link, and would be emptied", folder.display())).hint("remove the link")
        );
    }
    let base = std::env::var("PYTHON").unwrap_or_else(|_| "python3".into());
    eprintln!("creating {}", folder.display());
    process::run(project.command(base).args(["-m", "venv", "--clear"]).arg(folder)).map_err(|failure| {
        failure.hint("install Python 3.10 or later with its venv module (Debian and Ubuntu: apt install python3-venv), or name an interpreter in PYTHON")
    })
}

fn interpreter(folder: &Path) -> PathBuf {
    if cfg!(windows) { folder.join("Scripts/python.exe") } else { folder.join("bin/python") }
}
