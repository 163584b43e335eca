//! Programs that Debian or Ubuntu installs.

use std::env;
use std::path::PathBuf;
use std::process::Command;

use crate::process;
use crate::project::Project;

/// The first of some programs on the path.
pub fn on_path(names: &[&str]) -> Option<PathBuf> {
    let folders: Vec<PathBuf> = env::split_paths(&env::var_os("PATH")?).collect();
    names.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name))).find(|path| path.is_file())
}

/// True if a program is on the path, or could be installed from the package of its name.
pub fn has(project: &Project, program: &str) -> bool {
    on_path(&[program]).is_some() || install(project, program)
}

/// True if Debian's package manager is here, may be used, and has installed a package.
pub fn install(project: &Project, package: &str) -> bool {
    let is_root = Command::new("id").arg("-u").output().is_ok_and(|output| output.stdout.trim_ascii() == b"0");
    let runs = |arguments: &[&str]| {
        let mut command = project.command("apt-get");
        command.args(arguments).env("DEBIAN_FRONTEND", "noninteractive");
        process::run_quietly(&mut command).is_ok()
    };
    if !is_root {
        return false;
    }
    eprintln!("installing {package}");
    let arguments = ["install", "--yes", "--no-install-recommends", package];
    runs(&arguments) || (runs(&["update"]) && runs(&arguments))
}
