//! `cargo xtask test`: runs the test steps in order and prints the time of each.

use std::fmt::Write as _;
use std::process::Command;
use std::time::{Duration, Instant};

use crate::process::{self, Failure, Outcome};
use crate::project::Project;
use crate::{api, browser, package, page, plugin, schemas, site, venv};

struct Step {
    name: &'static str,
    about: &'static str,
    /// Steps that must run before this one.
    needs: &'static [&'static str],
    run: fn(&Project, &[String]) -> Outcome,
}

/// All steps in the order of a full run. Quick steps that fail often come first.
///
/// Clippy and docs are adjacent, as they share the metadata of the dependencies. Tests and the binary use different
/// profiles.
const STEPS: [Step; 14] = [
    // Before all that compiles the program, which embeds the page.
    Step {
        name: "page",
        about: "the page of the preview: types and bundle",
        needs: &[],
        run: |project, _| page::build(project),
    },
    Step { name: "fmt", about: "cargo fmt --check", needs: &[], run: |project, _| fmt(project) },
    Step {
        name: "clippy",
        about: "clippy on all targets and the bare library, warnings denied",
        needs: &[],
        run: |project, _| clippy(project),
    },
    Step {
        name: "docs",
        about: "rustdoc, warnings denied, and the public API against docs/api.txt",
        needs: &[],
        run: |project, _| docs(project).and_then(|()| api::check(project)),
    },
    Step { name: "rust", about: "cargo test --workspace", needs: &[], run: rust },
    Step { name: "build", about: "the release binary", needs: &[], run: |project, _| build(project) },
    Step {
        name: "site",
        about: "the documents: options against the program, links, and the site",
        needs: &["page", "build"],
        run: |project, _| site::build(project),
    },
    Step {
        name: "venv",
        about: "the Python environment target/venv",
        needs: &[],
        run: |project, _| venv::ensure(project).map(|_| ()),
    },
    Step {
        name: "schemas",
        about: "generated schema files against schema.usda",
        needs: &["venv"],
        run: |project, _| schemas::check(project),
    },
    Step {
        name: "plugin",
        about: "the OpenUSD plugin, for several wheels",
        needs: &[],
        run: |project, _| plugin::build_tested(project),
    },
    Step {
        name: "python",
        about: "pytest tests/usd, with the release binary and the plugins",
        needs: &["page", "build", "venv", "plugin"],
        run: python,
    },
    Step {
        name: "package",
        about: "the Python package in environments of its own, and the README's tutorial with it",
        needs: &["page", "venv", "plugin"],
        run: package::test,
    },
    Step {
        name: "newton",
        about: "cloth in the solver Newton, in an environment of its own",
        needs: &["page", "build"],
        run: newton,
    },
    Step {
        name: "browser",
        about: "the preview in Chromium, with the release binary",
        needs: &["page", "build"],
        run: browser::test,
    },
];

/// Steps that take arguments after `--`.
const TAKE_ARGUMENTS: [&str; 5] = ["rust", "python", "package", "newton", "browser"];

/// The help text of the steps.
pub fn help() -> String {
    let mut text = "Steps of test:\n".to_owned();
    for step in &STEPS {
        let _ = write!(text, "  {:<8} {}", step.name, step.about);
        if !step.needs.is_empty() {
            let _ = write!(text, " (needs {})", step.needs.join(", "));
        }
        text.push('\n');
    }
    text
}

pub fn test(project: &Project, args: &[String]) -> Outcome {
    let (names, extra) = match args.iter().position(|arg| arg == "--") {
        Some(at) => (&args[..at], &args[at + 1..]),
        None => (args, &[][..]),
    };
    if !extra.is_empty() && !matches!(names, [name] if TAKE_ARGUMENTS.contains(&name.as_str())) {
        return Err(Failure::new(
            "arguments after -- need one step, `rust`, `python`, `package`, `newton` or `browser`",
        ));
    }
    let mut times = Vec::new();
    let outcome = selected(names)?.into_iter().try_for_each(|step| {
        eprintln!("\n== {}: {}", step.name, step.about);
        let start = Instant::now();
        // Extra arguments go to the named step only, not to its prerequisites.
        let extra = if names.iter().any(|name| name == step.name) { extra } else { &[] };
        let outcome = (step.run)(project, extra).map_err(|failure| failure.within(step.name));
        let time = start.elapsed();
        eprintln!("== {}: {} in {:.1} s", step.name, verdict(&outcome), time.as_secs_f64());
        times.push((step.name, time, verdict(&outcome)));
        outcome
    });
    print_table(&times);
    outcome
}

fn verdict(outcome: &Outcome) -> &'static str {
    if outcome.is_ok() { "passed" } else { "FAILED" }
}

fn print_table(times: &[(&str, Duration, &str)]) {
    eprintln!("\nstep       time [s]");
    for (name, time, verdict) in times {
        eprintln!("{name:<8} {:>10.1}  {verdict}", time.as_secs_f64());
    }
    let total: Duration = times.iter().map(|(_, time, _)| *time).sum();
    eprintln!("{:<8} {:>10.1}", "total", total.as_secs_f64());
}

/// The named steps and their prerequisites, in order; all steps if none is named.
fn selected(names: &[String]) -> Outcome<Vec<&'static Step>> {
    if let Some(unknown) = names.iter().find(|name| STEPS.iter().all(|step| step.name != **name)) {
        return Err(Failure::new(format!("no step `{unknown}`")).hint("cargo xtask --help lists them"));
    }
    let named = |step: &Step| names.is_empty() || names.iter().any(|name| name == step.name);
    let needed = |name: &str| STEPS.iter().any(|step| named(step) && step.needs.contains(&name));
    Ok(STEPS.iter().filter(|step| named(step) || needed(step.name)).collect())
}

/// A cargo command that ignores the later toolchain declared by the crate `openusd` (see .cargo/config.toml).
pub fn cargo(project: &Project, subcommand: &str) -> Command {
    let program = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = project.command(program);
    command.args([subcommand, "--ignore-rust-version"]);
    command
}

fn fmt(project: &Project) -> Outcome {
    let program = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    process::run(project.command(program).args(["fmt", "--all", "--check"]))
        .map_err(|failure| failure.hint("run cargo fmt --all"))
}

fn clippy(project: &Project) -> Outcome {
    process::run(cargo(project, "clippy").args(["--workspace", "--all-targets", "--", "-D", "warnings"]))?;
    // The library alone, as other programs use it.
    process::run(cargo(project, "clippy").args(["--lib", "--no-default-features", "--", "-D", "warnings"]))
}

/// Draws the pages of the crate in `target/doc`.
pub fn docs(project: &Project) -> Outcome {
    process::run(cargo(project, "doc").args(["--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings"))
}

fn rust(project: &Project, extra: &[String]) -> Outcome {
    process::run(cargo(project, "test").arg("--workspace").args(extra))
}

/// The packages of every release build. Cargo unifies features over the packages of a command, so building the plugin
/// alone would recompile most dependencies.
pub const SHIPPED: [&str; 4] = ["--package", "tailor", "--package", "tailor-usd-plugin"];

/// Builds the release binary.
pub fn build(project: &Project) -> Outcome {
    process::run(cargo(project, "build").arg("--release").args(SHIPPED).args(["--bin", "usdtailor"]))
}

fn python(project: &Project, extra: &[String]) -> Outcome {
    let python = venv::ensure(project)?;
    // -rs lists skipped tests with their reasons.
    let mut command = project.command(python);
    command
        .args(["-m", "pytest", "tests/usd", "-q", "-rs", "-n", "auto", "--maxprocesses", "8", "--dist", "loadfile"])
        .args(extra);
    command.env("USDTAILOR", project.binary());
    command.env("USDTAILOR_PLUGIN", project.target.join("usd_plugin"));
    command.env("USDTAILOR_PLUGINS", plugin::tested(project)?);
    command.env("USDTAILOR_XTASK", std::env::current_exe().unwrap_or_default());
    process::run(&mut command)
}

/// The tests with Newton. They are skipped where pip cannot get it: it has wheels for few platforms.
fn newton(project: &Project, extra: &[String]) -> Outcome {
    let python = match venv::ensure_newton(project) {
        Ok(python) => python,
        Err(failure) => {
            eprintln!("SKIPPED: Newton cannot be installed here, so cloth is NOT tested in a solver: {failure}");
            return Ok(());
        }
    };
    let mut command = project.command(python);
    command.args(["-m", "pytest", "tests/newton", "-q", "-rs"]).args(extra);
    command.env("USDTAILOR", project.binary());
    process::run(&mut command)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(selection: &[&str]) -> Vec<&'static str> {
        let selection: Vec<String> = selection.iter().map(ToString::to_string).collect();
        selected(&selection).unwrap().into_iter().map(|step| step.name).collect()
    }

    #[test]
    fn a_step_brings_what_it_needs_and_keeps_the_order() {
        assert_eq!(names(&["python"]), ["page", "build", "venv", "plugin", "python"]);
        assert_eq!(names(&["rust", "fmt"]), ["fmt", "rust"]);
        assert_eq!(names(&[]).len(), STEPS.len());
    }

    #[test]
    fn needs_come_before_the_step_and_need_nothing_themselves() {
        for (at, step) in STEPS.iter().enumerate() {
            for need in step.needs {
                let found = STEPS[..at].iter().find(|other| other.name == *need).expect("a step before this one");
                assert!(found.needs.is_empty());
            }
        }
    }

    #[test]
    fn an_unknown_step_is_refused() {
        let failure = selected(&["rusty".into()]).err().expect("no such step");
        assert!(failure.to_string().contains("no step `rusty`"));
    }
}
