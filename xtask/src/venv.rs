//! The Python environment of the tests: usd-core, numpy, pytest, in `target/venv`.

use std::fs;
use std::path::{Path, PathBuf};

use crate::process::{self, Failure, Outcome};
use crate::project::Project;

const REQUIREMENTS: &str = "tests/usd/requirements.txt";

/// Makes the environment, or brings it up to date when its requirements have changed; returns its interpreter.
pub fn ensure(project: &Project) -> Outcome<PathBuf> {
    let folder = project.target.join("venv");
    let python = interpreter(&folder);
    let wanted = project.read(REQUIREMENTS)?;
    // Written last, so that an interrupted installation is done again.
    let installed = folder.join("installed-requirements.txt");
    if python.exists() && fs::read_to_string(&installed).is_ok_and(|text| text == wanted) {
        return Ok(python);
    }
    create(project, &folder)?;
    eprintln!("installing {REQUIREMENTS}");
    let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--requirement", REQUIREMENTS];
    process::run(project.command(&python).args(pip))?;
    fs::write(&installed, wanted)
        .map_err(|error| Failure::new(format!("cannot write {}: {error}", installed.display())))?;
    Ok(python)
}

fn create(project: &Project, folder: &Path) -> Outcome {
    let base = std::env::var("PYTHON").unwrap_or_else(|_| "python3".into());
    eprintln!("making {}", folder.display());
    process::run(project.command(base).args(["-m", "venv", "--clear"]).arg(folder)).map_err(|failure| {
        failure.hint("Python 3.10 or later with its venv module is needed (Debian and Ubuntu: apt install python3-venv); PYTHON names another interpreter")
    })
}

fn interpreter(folder: &Path) -> PathBuf {
    if cfg!(windows) { folder.join("Scripts/python.exe") } else { folder.join("bin/python") }
}
