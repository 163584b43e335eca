//! `cargo xtask wheel`: the Python package, with the command and the OpenUSD plugins of several versions of usd-core.
//!
//! ```text
//! usd_tailor/_native/usdtailor                   the command: a launcher
//! usd_tailor/_native/libusdtailor_core.so        all of the Rust code, once
//! usd_tailor/plugin/26.11/libusdTailor.so        finds the libraries of OpenUSD, and loads the format
//! usd_tailor/plugin/26.11/libusdTailorFormat.so  the C++ of the plugin, once for each version of usd-core
//! ```
//!
//! The C++ calls the Rust code through the functions of `cxx`, which the core exports. On macOS and Windows the package has the
//! command alone, as the plugin is for Linux.

mod native;

use std::fs;
use std::path::{Path, PathBuf};

use crate::cargo::{self, Profile};
use crate::links;
use crate::page;
use crate::plugin;
use crate::process::{self, Failure, Outcome};
use crate::project::Project;
use crate::test::Run;
use crate::venv;
use native::System;

/// The versions of usd-core that a released package has plugins for.
const RELEASES: [&str; 9] = ["24.8", "24.11", "25.2.post1", "25.5.1", "25.8", "25.11", "26.3", "26.5", "26.8"];

/// The name of the platform, for pip: glibc 2.28 is that of RHEL 8, macOS 11 that of the first arm64.
const PLATFORM: Option<&str> = if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
    Some("manylinux_2_28_x86_64")
} else if cfg!(all(target_os = "macos", target_arch = "aarch64")) {
    Some("macosx_11_0_arm64")
} else if cfg!(all(target_os = "windows", target_arch = "x86_64")) {
    Some("win_amd64")
} else {
    None
};

/// Whether the package is tested here.
const IS_TESTED: bool = cfg!(all(target_os = "linux", target_arch = "x86_64"));

/// Makes the package for release, and prints its path.
pub fn run(project: &Project, args: &[String]) -> Outcome {
    let wheel = released(project, args)?;
    eprintln!("built {}", wheel.display());
    Ok(())
}

/// Makes the package for all releases, or with `--tested` for those that the tests use, and returns its path.
pub fn released(project: &Project, args: &[String]) -> Outcome<PathBuf> {
    let versions: &[&str] = match args {
        [] => &RELEASES,
        [flag] if flag == "--tested" => &plugin::OLDER,
        _ => return Err(Failure::new("the task takes only --tested").hint("cargo xtask --help")),
    };
    page::build(project)?;
    make(project, Profile::Release, System::Oldest, versions)
}

/// The test step `wheel`: makes the package that other steps test.
pub fn make_tested(run: &Run<'_>) -> Outcome {
    if !IS_TESTED {
        eprintln!("SKIPPED: the Python package is NOT made for tests: they run on x86-64 Linux only");
        return Ok(());
    }
    let wheel = make(run.project, Profile::Tested, System::of_test(run.options.all), plugin::older(run.options.all))?;
    let list = list(run.project);
    fs::write(&list, wheel.to_string_lossy().as_bytes())
        .map_err(|error| Failure::new(format!("cannot write {}: {error}", list.display())))
}

/// The package that the step `wheel` made last, on the platform that tests it.
pub fn tested(project: &Project) -> Outcome<Option<PathBuf>> {
    let path = list(project);
    let read = || fs::read_to_string(&path).map_err(|error| format!("cannot read {}: {error}", path.display()));
    let fault = |text: String| Failure::new(text).hint("cargo xtask test wheel");
    if IS_TESTED { read().map(|text| Some(text.into())).map_err(fault) } else { Ok(None) }
}

fn list(project: &Project) -> PathBuf {
    project.target.join("wheels").join("tested.txt")
}

/// The test step `package`: installs the package in an environment that has nothing else of this project, and runs its tests and
/// the README's tutorial there.
pub fn test(run: &Run<'_>) -> Outcome {
    let project = run.project;
    let Some(wheel) = tested(project)? else {
        eprintln!("SKIPPED: the Python package is NOT tested: it is tested on x86-64 Linux only");
        return Ok(());
    };
    let python = venv::with_package(project, &wheel)?;
    let mut command = project.command(&python);
    command.args(["-m", "pytest", "tests/wheel", "tests/usd/test_readme.py", "-q", "-rfEs", "-p", "no:cacheprovider"]);
    command.env("USDTAILOR_WHEEL", &wheel).env("USDTAILOR_PLUGINS", plugin::tested(project)?);
    command.env("USDTAILOR", python.with_file_name("usdtailor")).args(run.extra);
    process::run(&mut command)
}

/// Makes the environments of the steps `wheel` and `package`.
pub fn prepare(run: &Run<'_>) -> Outcome {
    venv::ensure_packaging(run.project, System::of_test(run.options.all) == System::Oldest)?;
    venv::ensure_package_tests(run.project).map(drop)
}

/// Makes the package for some versions of usd-core, besides that of `target/venv`.
fn make(project: &Project, profile: Profile, system: System, versions: &[&str]) -> Outcome<PathBuf> {
    let platform = PLATFORM.ok_or_else(|| {
        Failure::new("the package is made on x86-64 Linux and Windows and on arm64 macOS only")
            .hint("build the command from source: cargo usdtailor --help")
    })?;
    let tools = venv::ensure_packaging(project, system == System::Oldest)?;
    let staged = stage(project)?;
    let package = staged.join("usd_tailor");
    if cfg!(target_os = "linux") {
        let linker = native::linker(project, system, &tools)?;
        let core = native::core(project, profile, &linker, &package.join("_native"))?;
        for python in pythons(project, versions)? {
            plugin::build_for_package(project, &python, &core, &linker, &package.join("plugin"))?;
        }
        if system == System::Oldest {
            native::check_floor(&package)?;
        }
    } else {
        cargo::build(project, profile)?;
        let program = profile.program(project);
        page::replace(&program, &package.join("_native").join(program.file_name().unwrap_or_default()))?;
    }
    pack(project, &tools, &staged, platform)
}

/// Interpreters with the usd-core of each version, and that of `target/venv`.
fn pythons(project: &Project, versions: &[&str]) -> Outcome<Vec<PathBuf>> {
    let older = versions.iter().map(|version| venv::ensure_wheel(project, version));
    older.chain([venv::ensure(project)]).collect()
}

/// Copies what the package consists of beside the native files, into an empty folder.
fn stage(project: &Project) -> Outcome<PathBuf> {
    let staged = project.scratch("wheel")?;
    for name in ["pyproject.toml", "hatch_build.py", "usd_tailor"] {
        page::replace(&project.root.join("python").join(name), &staged.join(name))?;
    }
    for name in ["Cargo.toml", "LICENSE-APACHE", "LICENSE-MIT"] {
        page::replace(&project.root.join(name), &staged.join(name))?;
    }
    let readme = links::without_files(&project.read("README.md")?);
    fs::write(staged.join("README.md"), readme)
        .map_err(|error| Failure::new(format!("cannot write the README of the package: {error}")))?;
    let cached = staged.join("usd_tailor/__pycache__");
    if cached.exists() {
        fs::remove_dir_all(&cached).map_err(|error| Failure::new(format!("cannot empty the package: {error}")))?;
    }
    Ok(staged)
}

fn pack(project: &Project, tools: &Path, staged: &Path, platform: &str) -> Outcome<PathBuf> {
    let out = project.scratch("wheels")?;
    let mut command = project.command(tools);
    command.args(["-m", "hatchling", "build", "-t", "wheel", "-d"]).arg(&out);
    process::run_quietly(command.current_dir(staged).env("USDTAILOR_PLATFORM", platform))?;
    let mut files =
        fs::read_dir(&out).map_err(|error| Failure::new(format!("cannot read {}: {error}", out.display())))?;
    let built =
        files.find_map(|file| Some(file.ok()?.path())).ok_or_else(|| Failure::new("hatchling wrote no wheel"))?;
    let name = built.file_name().unwrap_or_default();
    let wheels = project.target.join("wheels");
    fs::create_dir_all(&wheels)
        .and_then(|()| fs::copy(&built, wheels.join(name)))
        .map_err(|error| Failure::new(format!("cannot copy {}: {error}", built.display())))?;
    Ok(wheels.join(name))
}
