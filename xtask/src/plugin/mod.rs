//! `cargo xtask plugin`: the file format `.tailor` for one build of OpenUSD, with the schemas, as one folder.

mod build;
mod elf;
mod wheel;

use std::path::{Path, PathBuf};

use crate::process::{Failure, Outcome};
use crate::project::Project;
use crate::venv;
use build::Target;
use wheel::Wheel;

/// What to build for, and where to.
#[derive(Debug, Default, PartialEq)]
struct Options {
    python: Option<PathBuf>,
    sdk: Option<PathBuf>,
    out: Option<PathBuf>,
}

pub fn run(project: &Project, args: &[String]) -> Outcome {
    let options = Options::parse(args)?;
    let out = options.out.clone().unwrap_or_else(|| project.target.join("usd_plugin"));
    build_for_wheel(project, &options.python(project)?, &out)?;
    eprintln!("made {}\nto use it: export PXR_PLUGINPATH_NAME={0}", out.display());
    Ok(())
}

/// Builds for the wheel of an interpreter and returns the wheel's version.
pub fn build_for_wheel(project: &Project, python: &Path, out: &Path) -> Outcome<String> {
    let wheel = Wheel::find(project, python)?;
    let target = Target::of_wheel(project, &wheel)?;
    build::build(project, &target, out)?;
    Ok(wheel.version)
}

impl Options {
    fn parse(args: &[String]) -> Outcome<Self> {
        let mut options = Self::default();
        let mut rest = args.iter();
        while let Some(arg) = rest.next() {
            let place = match arg.as_str() {
                "--python" => &mut options.python,
                "--sdk" => &mut options.sdk,
                "--out" => &mut options.out,
                _ => return Err(Failure::new(format!("`plugin` does not take `{arg}`")).hint("cargo xtask --help")),
            };
            let value = rest.next().ok_or_else(|| Failure::new(format!("{arg} has no value")))?;
            *place = Some(PathBuf::from(value));
        }
        if options.python.is_some() && options.sdk.is_some() {
            return Err(
                Failure::new("--python and --sdk exclude each other").hint("a plugin is for one build of OpenUSD")
            );
        }
        Ok(options)
    }

    fn python(&self, project: &Project) -> Outcome<PathBuf> {
        self.python.clone().map_or_else(|| venv::ensure(project), Ok)
    }
}
