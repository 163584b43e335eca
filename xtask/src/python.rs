//! The tests in Python: `tests/usd` with usd-core, `tests/newton` with a cloth solver.

use std::path::Path;
use std::process::Command;

use crate::cargo::Profile;
use crate::plugin;
use crate::process::{self, Outcome, this_program};
use crate::project::Project;
use crate::test::Run;
use crate::venv;

/// Makes the environment of `tests/usd`, and that of the oldest wheel, for which the plugin is built too.
pub fn environment(project: &Project) -> Outcome {
    venv::ensure(project)?;
    // A wheel that cannot be had is reported by the step that needs it.
    drop(venv::ensure_wheel(project, plugin::OLDEST));
    Ok(())
}

/// Runs `tests/usd`.
pub fn test(run: &Run<'_>) -> Outcome {
    process::run(&mut command(run)?)
}

/// Runs those tests of `tests/usd` that any garment passes, on the garments of a folder.
pub fn test_garments(run: &Run<'_>, folder: &Path) -> Outcome {
    let bodies = run.options.bodies.iter().map(|bodies| ("TAILOR_BODIES", bodies));
    process::run(command(run)?.env("TAILOR_GARMENTS", folder).envs(bodies))
}

fn command(run: &Run<'_>) -> Outcome<Command> {
    let project = run.project;
    let mut command = project.command(venv::ensure(project)?);
    // -rfEs lists failed tests, errors, and skipped tests with their reasons.
    command
        .args(["-m", "pytest", "tests/usd", "-q", "-rfEs", "-n", "auto", "--maxprocesses", "8", "--dist", "loadfile"])
        .args(run.extra)
        .envs(run.variables());
    command.env("USDTAILOR", Profile::Tested.program(project));
    command.env("USDTAILOR_PLUGIN", project.target.join("usd_plugin"));
    command.env("USDTAILOR_PLUGINS", plugin::tested(project)?);
    command.env("USDTAILOR_XTASK", this_program()?);
    Ok(command)
}

/// Makes the environment of [`newton`], unless it cannot be had, which that step tells.
pub fn prepare_newton(project: &Project) {
    drop(venv::ensure_newton(project));
}

/// Runs `tests/newton`. The tests are skipped where pip cannot get Newton: it has wheels for few platforms.
pub fn newton(run: &Run<'_>) -> Outcome {
    let python = match venv::ensure_newton(run.project) {
        Ok(python) => python,
        Err(failure) => {
            eprintln!("SKIPPED: Newton cannot be installed here, so cloth is NOT tested in a solver: {failure}");
            return Ok(());
        }
    };
    let mut command = run.project.command(python);
    command.args(["-m", "pytest", "tests/newton", "-q", "-rfEs"]).args(run.extra);
    command.env("USDTAILOR", Profile::Tested.program(run.project));
    process::run(&mut command)
}
