//! `cargo xtask plugin`: builds the OpenUSD plugin for the file format `.tailor`, with the schemas, as one folder.
//!
//! ```text
//! cargo xtask plugin [--python PYTHON | --sdk DIR] [--out DIR]
//! cargo xtask plugin verify [--python PYTHON] [--headers DIR] [--define NAME]...
//! ```
//!
//! `verify` only compares the minimal headers with a wheel. Two options provoke mismatches for the tests: `--headers`
//! uses the generated header of another wheel, and `--define` changes a declaration.

mod build;
pub mod elf;
mod sdk;
mod tested;
mod verify;
mod wheel;

use std::path::{Path, PathBuf};

use crate::cargo::Profile;
use crate::process::{self, Failure, Outcome};
use crate::project::Project;
use crate::venv;
use build::Target;
use wheel::Wheel;

pub use build::check_compiler;
pub use tested::{OLDER, OLDEST, build_tested, older, tested};

/// The options of the command line.
#[derive(Debug, Default, PartialEq)]
struct Options {
    python: Option<PathBuf>,
    sdk: Option<PathBuf>,
    out: Option<PathBuf>,
    headers: Option<PathBuf>,
    defines: Vec<String>,
}

pub fn run(project: &Project, args: &[String]) -> Outcome {
    check_compiler(project)?;
    match args.split_first() {
        Some((first, rest)) if first == "verify" => verify_only(project, &Options::parse(rest)?),
        _ => make(project, &Options::parse(args)?),
    }
}

fn make(project: &Project, options: &Options) -> Outcome {
    if options.headers.is_some() || !options.defines.is_empty() {
        return Err(Failure::new("--headers and --define are for `plugin verify`"));
    }
    let out = options.out.clone().unwrap_or_else(|| project.target.join("usd_plugin"));
    // --python is stronger than the environment.
    let sdk = options.sdk.clone().or_else(|| sdk::from_environment().filter(|_| options.python.is_none()));
    match sdk {
        Some(root) => build_for_sdk(project, &root, &out)?,
        None => drop(build_for_wheel(project, Profile::Release, &options.python(project)?, &out)?),
    }
    eprintln!("built {}\nto use it: export PXR_PLUGINPATH_NAME={0}", out.display());
    Ok(())
}

fn build_for_sdk(project: &Project, root: &Path, out: &Path) -> Outcome {
    if !cfg!(target_os = "linux") {
        return Err(
            Failure::new("the plugin can be built on Linux only").hint("usdtailor itself runs on all platforms")
        );
    }
    let target = Target::of_sdk(project, root)?;
    let library = build::compile(project, Profile::Release, &target)?;
    build::assemble(project, &library, out)
}

/// Builds for the wheel of an interpreter and returns the wheel's version.
fn build_for_wheel(project: &Project, profile: Profile, python: &Path, out: &Path) -> Outcome<String> {
    let wheel = Wheel::find(project, python)?;
    let target = Target::of_wheel(project, &wheel)?;
    verify::headers(project, &wheel, &target, &[])?;
    let library = build::compile(project, profile, &target)?;
    verify::library(&wheel, &library)?;
    let trial = target.folder.join("trial");
    build::assemble(project, &library, &trial)?;
    try_out(project, &wheel, python, &trial)?;
    build::assemble(project, &library, out)?;
    Ok(wheel.version)
}

/// Builds the C++ of the plugin for the wheel of an interpreter, against a core, into a folder named by its version. `linker`
/// compiles its loader.
pub fn build_for_package(project: &Project, python: &Path, core: &Path, linker: &Path, folder: &Path) -> Outcome {
    check_compiler(project)?;
    let wheel = Wheel::find(project, python)?;
    let target = Target::of_wheel(project, &wheel)?;
    verify::headers(project, &wheel, &target, &[])?;
    let format = build::compile_format(project, &target, core)?;
    verify::library(&wheel, &format)?;
    let (year, month) = wheel::numbers(&wheel.version).unwrap_or_default();
    let out = folder.join(format!("{year}.{month}"));
    build::assemble_with_loader(project, &format, &out, linker)?;
    try_out(project, &wheel, python, &out)
}

/// Runs the plugin once, since some declarations of the headers cannot be compared with a library.
fn try_out(project: &Project, wheel: &Wheel, python: &Path, plugin: &Path) -> Outcome {
    let mut command = project.command(python);
    command.arg("usd_plugin/trial.py").env("PXR_PLUGINPATH_NAME", plugin);
    process::run_quietly(&mut command).map_err(|failure| {
        failure
            .within(&format!("trial with usd-core {}", wheel.version))
            .hint("please report it, and use another version")
    })
}

fn verify_only(project: &Project, options: &Options) -> Outcome {
    let wheel = Wheel::find(project, &options.python(project)?)?;
    let mut target = Target::of_wheel(project, &wheel)?;
    if let Some(headers) = &options.headers {
        target.includes[1].clone_from(headers);
    }
    verify::headers(project, &wheel, &target, &options.defines)?;
    eprintln!("usd-core {} matches the headers", wheel.version);
    Ok(())
}

impl Options {
    fn parse(args: &[String]) -> Outcome<Self> {
        let mut options = Self::default();
        let mut rest = args.iter();
        while let Some(arg) = rest.next() {
            let mut value = || rest.next().ok_or_else(|| Failure::new(format!("{arg} has no value")));
            match arg.as_str() {
                "--python" => options.python = Some(value()?.into()),
                "--sdk" => options.sdk = Some(value()?.into()),
                "--out" => options.out = Some(absolute(value()?)?),
                "--headers" => options.headers = Some(absolute(value()?)?),
                "--define" => options.defines.push(value()?.clone()),
                _ => return Err(Failure::new(format!("`plugin` does not take `{arg}`")).hint("cargo xtask --help")),
            }
        }
        if options.python.is_some() && options.sdk.is_some() {
            let hint = "a plugin is for one build of OpenUSD";
            return Err(Failure::new("--python and --sdk exclude each other").hint(hint));
        }
        Ok(options)
    }

    fn python(&self, project: &Project) -> Outcome<PathBuf> {
        self.python.clone().map_or_else(|| venv::ensure(project), Ok)
    }
}

/// An absolute path, as commands run in the project's root.
fn absolute(path: &str) -> Outcome<PathBuf> {
    std::path::absolute(path).map_err(|error| Failure::new(format!("{path} is not a valid path: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(args: &[&str]) -> Outcome<Options> {
        Options::parse(&args.iter().map(ToString::to_string).collect::<Vec<_>>())
    }

    #[test]
    fn options_are_read_and_others_refused() {
        let options = parse(&["--python", "py", "--out", "/x"]).unwrap();
        assert_eq!((options.python, options.out), (Some("py".into()), Some("/x".into())));
        for args in [&["--python"][..], &["--wheel", "x"], &["--python", "py", "--sdk", "/usd"]] {
            assert!(parse(args).is_err(), "{args:?}");
        }
    }
}
