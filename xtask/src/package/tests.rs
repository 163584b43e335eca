//! The test step `package`: the package in environments that have nothing else of this project.

use crate::plugin;
use crate::process::{self, Outcome};
use crate::project::Project;
use crate::venv;

/// Makes the package, installs it, and runs its tests and the README's tutorial.
pub fn test(project: &Project, extra: &[String]) -> Outcome {
    if !cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        eprintln!("SKIPPED: the Python package is NOT tested: it is made on x86-64 Linux only");
        return Ok(());
    }
    let wheel = super::make(project, &plugin::OLDER)?;
    let python = venv::with_package(project, &wheel)?;
    let mut command = project.command(&python);
    command.args(["-m", "pytest", "tests/wheel", "tests/usd/test_readme.py", "-q", "-rs", "-p", "no:cacheprovider"]);
    command.env("USDTAILOR_WHEEL", &wheel).env("USDTAILOR_PLUGINS", plugin::tested(project)?);
    command.env("USDTAILOR", python.with_file_name("usdtailor")).args(extra);
    process::run(&mut command)
}
