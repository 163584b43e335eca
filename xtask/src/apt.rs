//! Programs on the path, and those that Debian or Ubuntu installs on request.

use std::env;
use std::path::PathBuf;

use crate::process::{self, Outcome};
use crate::project::Project;

/// The first of some programs on the path.
pub fn on_path(names: &[&str]) -> Option<PathBuf> {
    let folders: Vec<PathBuf> = env::split_paths(&env::var_os("PATH")?).collect();
    names.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name))).find(|path| path.is_file())
}

/// Installs a package for the whole system, which needs the rights to do so. The list of packages is renewed if the known one
/// does not do.
pub fn install(project: &Project, package: &str) -> Outcome {
    let run = |arguments: &[&str]| {
        let mut command = project.command("apt-get");
        process::run_quietly(command.args(arguments).env("DEBIAN_FRONTEND", "noninteractive"))
    };
    eprintln!("installing {package} for the whole system, as --install asks");
    let arguments = ["install", "--yes", "--no-install-recommends", package];
    run(&arguments).or_else(|_| run(&["update"]).and_then(|()| run(&arguments)))
}
