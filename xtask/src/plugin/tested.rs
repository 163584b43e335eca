//! Builds the plugin for each OpenUSD version that the tests use.

use std::fs;
use std::path::PathBuf;

use super::build::write;
use super::build_for_wheel;
use crate::cargo::Profile;
use crate::process::{Failure, Outcome};
use crate::project::Project;
use crate::test::Run;
use crate::venv;

/// The oldest wheel that the plugin is for.
pub const OLDEST: &str = "24.8";

/// Wheels tested besides that of `target/venv`.
///
/// They cover all known variants: the string ABI, the signature of `SetFactory`, and one library or many. Wheels of one
/// ABI are adjacent, as they share a build of `cxx`.
pub const OLDER: [&str; 4] = [OLDEST, "24.11", "25.5", "25.11"];

/// The wheels of a run besides that of `target/venv`: the oldest, or with `--all` those in between too.
pub fn older(all: bool) -> &'static [&'static str] {
    if all { &OLDER } else { &[OLDEST] }
}

/// Builds the plugin for the tested wheels. An older wheel that cannot be installed is skipped with a message.
pub fn build_tested(run: &Run<'_>) -> Outcome {
    let project = run.project;
    let mut lines = Vec::new();
    if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        for version in older(run.options.all) {
            match venv::ensure_wheel(project, version) {
                Ok(python) => lines.push(build(project, python, &format!("usd_plugin-{version}"))?),
                Err(failure) => eprintln!("SKIPPED: the plugin is NOT tested with usd-core {version}\n{failure}"),
            }
        }
        lines.push(build(project, venv::ensure(project)?, "usd_plugin")?);
    } else {
        eprintln!("SKIPPED: the plugin is NOT tested: it can be built for wheels on x86-64 Linux only");
    }
    write(&list(project), &lines.join(";"))
}

/// The plugins built last, for the tests: `version=interpreter=folder`, separated by semicolons.
pub fn tested(project: &Project) -> Outcome<String> {
    let path = list(project);
    fs::read_to_string(&path).map_err(|error| Failure::new(format!("cannot read {}: {error}", path.display())))
}

fn list(project: &Project) -> PathBuf {
    project.target.join("usd_plugin-build").join("tested.txt")
}

fn build(project: &Project, python: PathBuf, folder: &str) -> Outcome<String> {
    let out = project.target.join(folder);
    let version = build_for_wheel(project, Profile::Tested, &python, &out)?;
    eprintln!("usd-core {version}: {}", out.display());
    Ok(format!("{version}={}={}", python.display(), out.display()))
}
