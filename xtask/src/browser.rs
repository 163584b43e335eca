//! Tests of the preview in a real browser: Playwright drives a Chromium that is on the path, or that a package of npm carries.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::apt;
use crate::cargo::Profile;
use crate::node;
use crate::page::replace;
use crate::process::{self, Failure, Outcome};
use crate::project::Project;
use crate::test::Run;

const TESTS: &str = "tests/page";
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];
/// Carries a headless Chromium for Linux.
const CARRIER: &str = "@sparticuz/chromium@153.0.0";

/// Tests that run with `--all` alone.
const LONG: [&str; 8] = [
    "finding.test.mjs",
    "flat.test.mjs",
    "haste.test.mjs",
    "keyboard.test.mjs",
    "look.test.mjs",
    "tabs.test.mjs",
    "variants.test.mjs",
    "views.test.mjs",
];

/// Runs the tests.
pub fn test(run: &Run<'_>) -> Outcome {
    let mut command = node_with_browser(run.project, Profile::Tested)?;
    command.args(["--test", "--test-reporter=spec", "--test-concurrency=1", "--test-timeout=300000"]).args(run.extra);
    // Files that are named after -- replace these.
    if !run.extra.iter().any(|word| word.ends_with(".mjs")) {
        command.args(files(run.project, run.options.all)?);
    }
    process::run(&mut command)
}

/// The names of the test files.
fn files(project: &Project, all: bool) -> Outcome<Vec<String>> {
    let mut names = entries(&project.root.join(TESTS))?;
    names.retain(|name| name.ends_with(".test.mjs") && (all || !LONG.contains(&name.as_str())));
    Ok(names)
}

/// Installs what the tests need.
pub fn prepare(project: &Project) -> Outcome {
    node_with_browser(project, Profile::Tested).map(drop)
}

/// Draws the pictures of `docs/preview`.
pub fn pictures(project: &Project) -> Outcome {
    let mut command = node_with_browser(project, Profile::Release)?;
    process::run(command.arg("pictures.mjs").arg(project.root.join("docs/preview")))
}

/// Prints times of edits and the memory of the server. Any argument leaves the memory out.
pub fn figures(project: &Project, args: &[String]) -> Outcome {
    process::run(node_with_browser(project, Profile::Release)?.arg("figures.mjs").args(args))
}

/// Node.js in a copy of the tests, with what they need.
fn node_with_browser(project: &Project, profile: Profile) -> Outcome<Command> {
    let tests = project.target.join("page-tests");
    renew(&project.root.join(TESTS), &tests)?;
    node::install(project, &tests)?;
    let mut command = node::command(project, "node", &tests)?;
    command.env("USDTAILOR", profile.program(project));
    command.env("USDTAILOR_ROOT", &project.root);
    command.env("CHROMIUM", chromium(project)?);
    Ok(command)
}

/// Replaces all that a copy of a folder holds, but the packages that npm has installed there.
fn renew(from: &Path, to: &Path) -> Outcome {
    let fault = |error| Failure::new(format!("cannot write {}: {error}", to.display()));
    fs::create_dir_all(to).map_err(fault)?;
    for name in entries(to)?.into_iter().filter(|name| name != "node_modules") {
        let old = to.join(name);
        if old.is_dir() { fs::remove_dir_all(old) } else { fs::remove_file(old) }.map_err(fault)?;
    }
    entries(from)?.iter().try_for_each(|name| replace(&from.join(name), &to.join(name)))
}

/// The names in a folder, in order.
fn entries(folder: &Path) -> Outcome<Vec<String>> {
    let fault = |error| Failure::new(format!("cannot read {}: {error}", folder.display()));
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).map_err(fault)? {
        names.push(entry.map_err(fault)?.file_name().to_string_lossy().into_owned());
    }
    names.sort();
    Ok(names)
}

/// Fails where no browser starts, before anything compiles.
pub fn check(run: &Run<'_>) -> Outcome {
    if run.options.install && env::var_os("CHROMIUM").is_none() && apt::on_path(&NAMES).is_none() {
        apt::install(run.project, "chromium")?;
    }
    chromium(run.project).and_then(|browser| process::run_quietly(Command::new(browser).arg("--version"))).map_err(
        |failure| {
            failure.hint(
                "install Chromium (Debian: apt install chromium, or cargo xtask test --install), or name one in CHROMIUM",
            )
        },
    )
}

/// A Chromium: that of the environment, one on the path, or else the one that a package of npm carries.
fn chromium(project: &Project) -> Outcome<PathBuf> {
    match env::var_os("CHROMIUM") {
        Some(named) => Ok(named.into()),
        None => apt::on_path(&NAMES).map_or_else(|| carried(project), Ok),
    }
}

/// The Chromium of a package of npm, unpacked below the target folder.
fn carried(project: &Project) -> Outcome<PathBuf> {
    if !cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        return Err(Failure::new("no Chromium is on the path"));
    }
    let folder = project.target.join("chromium");
    let unpacked = folder.join("chromium");
    let made_from = folder.join("made-from");
    if unpacked.is_file() && fs::read_to_string(&made_from).is_ok_and(|carrier| carrier == CARRIER) {
        return Ok(unpacked);
    }
    let fault = |error| Failure::new(format!("cannot write in {}: {error}", folder.display()));
    if folder.exists() {
        fs::remove_dir_all(&folder).map_err(fault)?;
    }
    fs::create_dir_all(&folder).map_err(fault)?;
    let install = ["install", "--no-audit", "--no-fund", "--no-save", "--loglevel=error", CARRIER];
    process::run_quietly(node::command(project, "npm", &folder)?.args(install))?;
    let mut command = node::command(project, "node", &folder)?;
    command.args([
        "--input-type=module",
        "--eval",
        "await (await import('@sparticuz/chromium')).default.executablePath()",
    ]);
    // It unpacks into the folder of temporary files.
    process::run_quietly(command.env("TMPDIR", &folder))?;
    if !unpacked.is_file() {
        return Err(Failure::new(format!("{CARRIER} unpacks no Chromium")));
    }
    fs::write(made_from, CARRIER).map_err(fault)?;
    Ok(unpacked)
}
