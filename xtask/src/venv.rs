//! Creates the Python environments of the tests: `target/venv` with usd-core, numpy and pytest, and one per older
//! wheel. One environment has pip and installs into all others, as making pip itself takes longer than most installations.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::process::{self, Failure, Outcome};
use crate::project::Project;

const REQUIREMENTS: &str = "tests/usd/requirements.txt";
const SITE: &str = "xtask/site/requirements.txt";
const PACKAGING: &str = "python/requirements.txt";
const NEWTON: &str = "tests/newton/requirements.txt";
const PACKAGE: &str = "tests/wheel/requirements.txt";

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

/// Like [`ensure`], for the programs that make the Python package: all of them, or that which packs it.
pub fn ensure_packaging(project: &Project, links: bool) -> Outcome<PathBuf> {
    let wanted = project.read(PACKAGING)?;
    if links {
        return ensure_with(project, "venv-packaging", &wanted, &["--requirement", PACKAGING]);
    }
    let packer = wanted.lines().find(|line| line.starts_with("hatchling"));
    let packer = packer.ok_or_else(|| Failure::new(format!("{PACKAGING} names no hatchling")))?;
    ensure_package(project, "venv-packing", packer)
}

/// Like [`ensure`], for the tests of the Python package.
pub fn ensure_package_tests(project: &Project) -> Outcome<PathBuf> {
    let wanted = project.read(PACKAGE)?;
    ensure_with(project, "venv-package", &wanted, &["--requirement", PACKAGE])
}

/// The environment of [`ensure_package_tests`], with the Python package.
pub fn with_package(project: &Project, wheel: &Path) -> Outcome<PathBuf> {
    let python = ensure_package_tests(project)?;
    process::run(pip(project, &python)?.args(["--no-index", "--no-deps", "--force-reinstall"]).arg(wheel))?;
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
    create(project, &folder, &["--without-pip"])?;
    eprintln!("installing {}", what.last().unwrap_or(&name));
    process::run(pip(project, &python)?.args(what))?;
    fs::write(&installed, wanted)
        .map_err(|error| Failure::new(format!("cannot write {}: {error}", installed.display())))?;
    Ok(python)
}

/// A command that installs into the environment of an interpreter.
fn pip(project: &Project, python: &Path) -> Outcome<Command> {
    let folder = project.target.join("venv-pip");
    let own = interpreter(&folder);
    // Made last of that environment.
    if !folder.join("bin/pip").exists() && !folder.join("Scripts/pip.exe").exists() {
        create(project, &folder, &[])?;
    }
    let mut command = project.command(own);
    command.args(["-m", "pip", "--python"]).arg(python);
    command.args(["install", "--quiet", "--disable-pip-version-check"]);
    Ok(command)
}

fn create(project: &Project, folder: &Path, options: &[&str]) -> Outcome {
    if folder.is_symlink() {
        return Err(
            Failure::new(format!("{} is a link, and would be emptied", folder.display())).hint("remove the link")
        );
    }
    let base = std::env::var("PYTHON").unwrap_or_else(|_| "python3".into());
    eprintln!("creating {}", folder.display());
    process::run(project.command(base).args(["-m", "venv", "--clear"]).args(options).arg(folder)).map_err(|failure| {
        failure.hint("install Python 3.10 or later with its venv module (Debian and Ubuntu: apt install python3-venv), or name an interpreter in PYTHON")
    })
}

fn interpreter(folder: &Path) -> PathBuf {
    if cfg!(windows) { folder.join("Scripts/python.exe") } else { folder.join("bin/python") }
}
