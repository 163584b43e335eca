//! Tests of the preview in a real browser: Playwright drives a Chromium that is on the path, that Debian or Ubuntu
//! installs, or that a package of npm carries.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::node;
use crate::process::{self, Failure, Outcome};
use crate::project::Project;

const TESTS: &str = "tests/page";
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];
/// Carries a headless Chromium for Linux.
const CARRIER: &str = "@sparticuz/chromium@153.0.0";

/// Runs the tests with the release binary.
pub fn test(project: &Project, extra: &[String]) -> Outcome {
    let mut command = node_with_browser(project)?;
    command.args(["--test", "--test-concurrency=1", "--test-timeout=180000"]).args(extra);
    process::run(&mut command)
}

/// Draws the pictures of `docs/preview`.
pub fn pictures(project: &Project) -> Outcome {
    let mut command = node_with_browser(project)?;
    process::run(command.arg("pictures.mjs").arg(project.root.join("docs/preview")))
}

/// Prints times of edits and the memory of the server. Any argument leaves the memory out.
pub fn figures(project: &Project, args: &[String]) -> Outcome {
    process::run(node_with_browser(project)?.arg("figures.mjs").args(args))
}

/// Node.js in a copy of the tests, with what they need.
fn node_with_browser(project: &Project) -> Outcome<Command> {
    let tests = project.target.join("page-tests");
    crate::page::replace(&project.root.join(TESTS), &tests)?;
    node::install(project, &tests)?;
    let mut command = node::command(project, "node", &tests)?;
    command.env("USDTAILOR", project.binary());
    command.env("USDTAILOR_ROOT", &project.root);
    command.env("CHROMIUM", chromium(project)?);
    Ok(command)
}

fn chromium(project: &Project) -> Outcome<PathBuf> {
    if let Some(named) = env::var_os("CHROMIUM") {
        return Ok(named.into());
    }
    if let Some(found) = on_path() {
        return Ok(found);
    }
    if install_by_apt()
        && let Some(found) = on_path()
    {
        return Ok(found);
    }
    carried(project).map_err(|failure| failure.hint("install Chromium, or name one in CHROMIUM"))
}

fn on_path() -> Option<PathBuf> {
    let folders: Vec<PathBuf> = env::split_paths(&env::var_os("PATH")?).collect();
    NAMES.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name))).find(|path| path.is_file())
}

/// True if Debian's package manager is here, may be used, and has installed Chromium.
fn install_by_apt() -> bool {
    let is_root = Command::new("id").arg("-u").output().is_ok_and(|output| output.stdout.trim_ascii() == b"0");
    let runs = |arguments: &[&str]| {
        let mut command = Command::new("apt-get");
        command.args(arguments).env("DEBIAN_FRONTEND", "noninteractive");
        process::run_quietly(&mut command).is_ok()
    };
    if !is_root {
        return false;
    }
    eprintln!("installing chromium");
    let arguments = ["install", "--yes", "--no-install-recommends", "chromium"];
    runs(&arguments) || (runs(&["update"]) && runs(&arguments))
}

/// The Chromium of a package of npm, unpacked below the target folder.
fn carried(project: &Project) -> Outcome<PathBuf> {
    let folder = project.target.join("chromium");
    std::fs::create_dir_all(&folder)
        .map_err(|error| Failure::new(format!("cannot create {}: {error}", folder.display())))?;
    let install = ["install", "--no-audit", "--no-fund", "--no-save", CARRIER];
    process::run_quietly(node::command(project, "npm", &folder)?.args(install))?;
    let print = "import c from '@sparticuz/chromium'; console.log(await c.executablePath())";
    let mut command = node::command(project, "node", &folder)?;
    let output = command.args(["--input-type=module", "--eval", print]).output();
    let output = output.map_err(|error| Failure::new(format!("cannot unpack Chromium: {error}")))?;
    let path = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    if Path::new(&path).is_file() { Ok(path.into()) } else { Err(Failure::new("cannot unpack Chromium")) }
}
