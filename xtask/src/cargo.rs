//! What cargo does: builds, checks and tests of the Rust code.

use std::path::PathBuf;
use std::process::Command;

use crate::process::{self, Outcome};
use crate::project::Project;
use crate::test::Run;

/// How the program and the plugin are compiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    /// As tests are: optimised, with assertions, and without a second compilation of anything.
    Tested,
    /// As users get them.
    Release,
}

impl Profile {
    /// The folder of the profile below the target folder.
    fn folder(self) -> &'static str {
        match self {
            Self::Tested => "debug",
            Self::Release => "release",
        }
    }

    /// Flags of cargo.
    pub fn flags(self) -> &'static [&'static str] {
        match self {
            Self::Tested => &TESTED,
            Self::Release => &["--release"],
        }
    }

    /// The program `usdtailor`.
    pub fn program(self, project: &Project) -> PathBuf {
        self.built(project, &format!("usdtailor{}", std::env::consts::EXE_SUFFIX))
    }

    /// A file that cargo builds.
    pub fn built(self, project: &Project, name: &str) -> PathBuf {
        project.target.join(self.folder()).join(name)
    }
}

/// The packages of every build. Cargo unifies features over the packages of a command, so building the plugin alone would
/// recompile most dependencies.
pub const SHIPPED: [&str; 4] = ["--package", "usdtailor", "--package", "tailor-usd-plugin"];

/// The feature that a test of the preview needs. All builds for tests have it, or the engine would be compiled twice.
const TESTED: [&str; 2] = ["--features", "typescript"];

/// The crates below `src` that users get.
const PUBLISHED: [&str; 6] = ["tailor-mesh", "tailor", "tailor-costume", "tailor-usd", "tailor-preview", "usdtailor"];

/// A cargo command that ignores the later toolchain declared by the crate `openusd` (see .cargo/config.toml).
pub fn cargo(project: &Project, subcommand: &str) -> Command {
    let mut command = bare(project);
    command.args([subcommand, "--ignore-rust-version"]);
    command
}

fn bare(project: &Project) -> Command {
    project.command(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}

/// Checks the format of the code.
pub fn fmt(run: &Run<'_>) -> Outcome {
    process::run(bare(run.project).args(["fmt", "--all", "--check"]))
        .map_err(|failure| failure.hint("run cargo fmt --all"))
}

/// Clippy on all targets.
pub fn clippy(run: &Run<'_>) -> Outcome {
    let mut all = cargo(run.project, "clippy");
    process::run(all.args(["--workspace", "--all-targets"]).args(TESTED).args(["--", "-D", "warnings"]))
}

/// Draws the pages of the crates in `target/doc`; with `all` those of the plugin too, for which the library is checked again.
pub fn docs(project: &Project, all: bool) -> Outcome {
    let mut command = cargo(project, "doc");
    command.args(["--no-deps", "--package", "xtask"]).args(TESTED);
    command.args(PUBLISHED.map(|name| format!("--package={name}")));
    command.args(all.then_some("--package=tailor-usd-plugin"));
    process::run(command.env("RUSTDOCFLAGS", "-D warnings"))
}

/// Compiles all tests, and the program that they run.
pub fn compile(run: &Run<'_>) -> Outcome {
    process::run(cargo(run.project, "test").args(["--workspace", "--no-run"]).args(TESTED))
}

/// Runs the Rust tests.
pub fn test(run: &Run<'_>) -> Outcome {
    process::run(tests(run).args(run.extra))
}

/// The command that runs tests. Cargo recompiles the engine for any other selection of packages.
pub fn tests(run: &Run<'_>) -> Command {
    let mut command = cargo(run.project, "test");
    command.args(["--workspace", "--no-fail-fast"]).args(TESTED).envs(run.variables());
    command
}

/// Writes the declarations of the preview's messages for its page. The test that compares them makes them.
pub fn protocol(project: &Project) -> Outcome {
    let mut command = cargo(project, "test");
    command.args(["--package", "tailor-preview", "--lib", "the_page_knows_all_messages"]).args(TESTED);
    process::run(command.env("TAILOR_WRITE_PROTOCOL", "1"))
}

/// Builds the program.
pub fn build(project: &Project, profile: Profile) -> Outcome {
    process::run(cargo(project, "build").args(profile.flags()).args(SHIPPED).args(["--bin", "usdtailor"]))
}
