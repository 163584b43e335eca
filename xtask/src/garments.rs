//! The test step `garments`: what holds for any garment, on those of a folder that is not the project's.

use std::path::Path;
use std::process::Command;

use crate::cargo;
use crate::process::{self, Failure, Outcome};
use crate::python;
use crate::test::Run;

/// The tests that run on garments have this in their names.
const TESTS: &str = "garments";
/// The table of time and quality. The tests print one of crossings.
const TABLE: &str = "peers::quality::table";

/// Runs the tests in Rust and in Python, and prints the tables, whichever of them fails.
pub fn test(run: &Run<'_>) -> Outcome {
    let folder = run.options.folder.as_deref().ok_or_else(|| Failure::new("no folder of garments"))?;
    let mut rust = tests(run, folder);
    rust.args(["--", "--show-output", TESTS]);
    let mut table = tests(run, folder);
    table.args(["--test", "meshes", "--", "--ignored", "--nocapture", "--exact", TABLE]);
    let ended = [process::run_all(&mut [rust, table]), python::test_garments(run, folder)];
    ended.into_iter().collect()
}

fn tests(run: &Run<'_>, folder: &Path) -> Command {
    let mut command = cargo::tests(run);
    command.env("TAILOR_GARMENTS", folder);
    command
}
