//! `cargo xtask blender`: the extension for Blender, with the Python package in it.
//!
//! ```text
//! usd_tailor-0.1.0-linux-x64.zip
//!   __init__.py, ...        python/blender
//!   blender_manifest.toml   with version, platform and wheel filled in
//!   LICENSE, README.md
//!   wheels/usd_tailor-...   the package of `cargo xtask wheel`, unmodified
//! ```

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use crate::package;
use crate::page;
use crate::process::{self, Failure, Outcome};
use crate::project::Project;
use crate::test::Run;
use crate::venv::{self, Blender};

const SOURCE: &str = "python/blender";
const MANIFEST: &str = "blender_manifest.toml";

/// Blender's name of the platform of the package.
const PLATFORM: &str = if cfg!(target_os = "macos") {
    "macos-arm64"
} else if cfg!(windows) {
    "windows-x64"
} else {
    "linux-x64"
};

/// 1 January 2026, as time of all files: the same files give the same zip.
const TIME: Duration = Duration::from_secs(1_767_225_600);

/// Makes the extension with the package for all releases of usd-core, or with `--tested` for those that the tests use.
pub fn run(project: &Project, args: &[String]) -> Outcome {
    let wheel = package::released(project, args)?;
    let extension = pack(project, &wheel)?;
    eprintln!("built {}", extension.display());
    Ok(())
}

/// The test step `blender`: installs the extension in each tested Blender, and runs `tests/blender` there. The tests are skipped
/// with a version that cannot be had: each needs one version of Python.
pub fn test(run: &Run<'_>) -> Outcome {
    let project = run.project;
    let Some(wheel) = package::tested(project)? else {
        eprintln!("SKIPPED: the extension for Blender is NOT tested: its package is tested on x86-64 Linux only");
        return Ok(());
    };
    let extension = pack(project, &wheel)?;
    let mut outcome = Ok(());
    for blender in blenders(project, run.options.all)? {
        let version = &blender.version;
        let usable = venv::ensure_blender(project, &blender).and_then(|python| {
            process::run_quietly(project.command(&python).args(["-c", "import bpy"]))?;
            Ok(python)
        });
        match usable {
            // The other versions run after a failure too.
            Ok(python) => outcome = outcome.and(test_with(run, &python, &extension)),
            Err(failure) => {
                eprintln!(
                    "SKIPPED: the extension is NOT tested with Blender {version}, which does not run here: {failure}"
                );
            }
        }
    }
    outcome
}

/// Makes the environments of the step `blender`, unless they cannot be had, which that step reports.
pub fn prepare(run: &Run<'_>) -> Outcome {
    for blender in blenders(run.project, run.options.all)? {
        drop(venv::ensure_blender(run.project, &blender));
    }
    Ok(())
}

fn test_with(run: &Run<'_>, python: &Path, extension: &Path) -> Outcome {
    let mut command = run.project.command(python);
    command.args(["-m", "pytest", "tests/blender", "-q", "-rfEs", "-p", "no:cacheprovider"]).args(run.extra);
    command.env("USDTAILOR_EXTENSION", extension).envs(run.variables());
    process::run(&mut command)
}

/// The versions of a run: the first that is pinned, or with `--all` the others too.
fn blenders(project: &Project, all: bool) -> Outcome<Vec<Blender>> {
    let pinned = venv::blenders(project)?;
    Ok(pinned.into_iter().take(if all { usize::MAX } else { 1 }).collect())
}

/// Makes the zip that Blender installs.
fn pack(project: &Project, wheel: &Path) -> Outcome<PathBuf> {
    let staged = project.scratch("blender")?;
    stage(&project.root.join(SOURCE), &staged)?;
    let name = wheel.file_name().unwrap_or_default().to_string_lossy();
    page::replace(wheel, &staged.join("wheels").join(&*name))?;
    let manifest = fill(&project.read(&format!("{SOURCE}/{MANIFEST}"))?, &name)?;
    fs::write(staged.join(MANIFEST), manifest)
        .map_err(|error| Failure::new(format!("cannot write the manifest: {error}")))?;
    set_times(&staged)?;

    let folder = project.target.join("blender");
    fs::create_dir_all(&folder)
        .map_err(|error| Failure::new(format!("cannot create {}: {error}", folder.display())))?;
    let extension = folder.join(format!("usd_tailor-{}-{PLATFORM}.zip", env!("CARGO_PKG_VERSION")));
    let python = venv::ensure_packaging(project, false)?;
    // The module compresses, and takes the files of a folder in the order of their names.
    let mut command = project.command(python);
    command.args(["-m", "zipfile", "-c"]).arg(&extension).arg(".").current_dir(&staged);
    process::run_quietly(&mut command)?;
    Ok(extension)
}

/// Copies what belongs to the extension from a folder and the folders in it.
fn stage(from: &Path, to: &Path) -> Outcome {
    let entries =
        fs::read_dir(from).map_err(|error| Failure::new(format!("cannot read {}: {error}", from.display())))?;
    for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
        let target = to.join(path.file_name().unwrap_or_default());
        if path.is_dir() {
            stage(&path, &target)?;
        } else if path.extension().is_some_and(|extension| extension == "py" || extension == "md")
            || path.file_name().is_some_and(|name| name == "LICENSE")
        {
            page::replace(&path, &target)?;
        }
    }
    Ok(())
}

/// The manifest with its version, its platform and its package.
fn fill(manifest: &str, wheel: &str) -> Outcome<String> {
    let values = [
        ("version", format!("\"{}\"", env!("CARGO_PKG_VERSION"))),
        ("platforms", format!("[\"{PLATFORM}\"]")),
        ("wheels", format!("[\"./wheels/{wheel}\"]")),
    ];
    let mut lines: Vec<String> = manifest.lines().map(str::to_owned).collect();
    for (key, value) in values {
        let start = format!("{key} = ");
        let mut found = lines.iter_mut().filter(|line| line.starts_with(&start));
        match (found.next(), found.next()) {
            (Some(line), None) => *line = start + &value,
            _ => return Err(Failure::new(format!("{SOURCE}/{MANIFEST} needs one line that begins with `{start}`"))),
        }
    }
    Ok(lines.join("\n") + "\n")
}

fn set_times(folder: &Path) -> Outcome {
    let fault = |error| Failure::new(format!("cannot change the time of files in {}: {error}", folder.display()));
    for entry in fs::read_dir(folder).map_err(fault)? {
        let path = entry.map_err(fault)?.path();
        if path.is_dir() {
            set_times(&path)?;
            // Windows opens no folder so.
            if cfg!(windows) {
                continue;
            }
        }
        let file = File::options().read(true).append(path.is_file()).open(&path).map_err(fault)?;
        file.set_modified(SystemTime::UNIX_EPOCH + TIME).map_err(fault)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_manifest_gets_its_values_and_keeps_the_rest() {
        let text = "id = \"x\"\nversion = \"0\"\nblender_version_min = \"4.5.0\"\nplatforms = []\nwheels = []\n[permissions]\n";
        let filled = fill(text, "a-1-py3-none-any.whl").unwrap();
        let lines: Vec<&str> = filled.lines().collect();
        assert_eq!(lines[1], concat!("version = \"", env!("CARGO_PKG_VERSION"), "\""));
        assert_eq!(lines[4], "wheels = [\"./wheels/a-1-py3-none-any.whl\"]");
        assert_eq!([lines[0], lines[2], lines[5]], ["id = \"x\"", "blender_version_min = \"4.5.0\"", "[permissions]"]);
        assert!(fill("version = \"0\"\n", "a.whl").is_err());
    }
}
