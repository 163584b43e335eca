//! `cargo xtask test`: the test steps, and which of them a command line names.

mod lanes;

use std::fmt::Write as _;

use crate::process::{Failure, Outcome};
use crate::project::Project;
use crate::{api, blender, browser, cargo, options, package, page, plugin, prose, python, site, speed};

/// One run of a step.
pub struct Run<'a> {
    pub project: &'a Project,
    /// Arguments after `--`.
    pub extra: &'a [String],
    /// Whether the long tests run too.
    pub all: bool,
}

impl Run<'_> {
    /// Environment variables of the programs that run tests: long tests look at this one.
    pub fn variables(&self) -> Option<(&'static str, &'static str)> {
        self.all.then_some(("TAILOR_TEST_ALL", "1"))
    }
}

/// The steps of a lane run one after another, beside those of the other lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lane {
    /// Steps that compile, or use all processors.
    Main,
    /// Steps that wait for a network or use one processor.
    Beside,
}

struct Step {
    name: &'static str,
    about: &'static str,
    lane: Lane,
    /// Steps that must run before this one, named or not.
    needs: &'static [&'static str],
    /// Steps that must run before this one if they run at all.
    after: &'static [&'static str],
    run: fn(&Run<'_>) -> Outcome,
}

/// A step of [`Lane::Main`] that nothing precedes.
const MAIN: Step = Step { name: "", about: "", lane: Lane::Main, needs: &[], after: &[], run: |_| Ok(()) };
const BESIDE: Step = Step { lane: Lane::Beside, ..MAIN };

/// All steps. In a full run each lane takes its steps in this order; quick steps that fail often come first.
const STEPS: [Step; 19] = [
    // Before all that compiles the program, which embeds the page.
    Step {
        name: "page",
        about: "the page of the preview: types and bundle",
        run: |run| page::build(run.project),
        ..MAIN
    },
    Step {
        name: "venv",
        about: "the Python environment target/venv",
        run: |run| python::environment(run.project),
        ..BESIDE
    },
    Step {
        name: "tools",
        about: "other environments of Python, packages of npm, Chromium",
        after: &["page"],
        run: tools,
        ..BESIDE
    },
    Step { name: "fmt", about: "cargo fmt --check", run: cargo::fmt, ..MAIN },
    Step {
        name: "prose",
        about: "documents, messages and comments against a list of phrases, and the length of sentences",
        run: |run| prose::check(run.project),
        ..BESIDE
    },
    Step {
        name: "clippy",
        about: "clippy on all targets, and the bare library, warnings denied",
        after: &["page"],
        run: cargo::clippy,
        ..MAIN
    },
    Step {
        name: "docs",
        about: "rustdoc, warnings denied, and the public API against docs/api.txt",
        after: &["page"],
        run: |run| cargo::docs(run.project, run.all).and_then(|()| api::check(run.project)),
        ..MAIN
    },
    Step {
        name: "build",
        about: "the program as tests run it, and the Rust tests",
        needs: &["page"],
        run: cargo::compile,
        ..MAIN
    },
    Step {
        name: "plugin",
        about: "the OpenUSD plugin, for the oldest and the newest wheel",
        needs: &["page", "venv"],
        run: plugin::build_tested,
        ..MAIN
    },
    Step {
        name: "options",
        about: "the schemas and docs/recipe.md against the program's table of options",
        needs: &["page", "build", "venv"],
        run: |run| options::check(run.project),
        ..BESIDE
    },
    Step {
        name: "site",
        about: "the documents: links, and the site",
        after: &["tools"],
        run: |run| site::build(run.project),
        ..BESIDE
    },
    Step {
        name: "newton",
        about: "cloth in the solver Newton, in an environment of its own",
        needs: &["page", "build"],
        after: &["tools"],
        run: python::newton,
        ..BESIDE
    },
    Step {
        name: "speed",
        about: "instructions of two builds against stored figures",
        needs: &["page", "build"],
        run: |run| speed::check(run.project),
        ..BESIDE
    },
    Step {
        name: "wheel",
        about: "the Python package, as tests use it",
        needs: &["page", "venv"],
        // Both write the headers of the plugin.
        after: &["tools", "plugin"],
        run: package::make_tested,
        ..BESIDE
    },
    Step {
        name: "package",
        about: "the Python package in environments of its own, and the README's tutorial with it",
        needs: &["page", "venv", "plugin", "wheel"],
        run: package::test,
        ..BESIDE
    },
    Step {
        name: "blender",
        about: "the extension in Blender, in environments of its own",
        needs: &["page", "venv", "wheel"],
        run: blender::test,
        ..BESIDE
    },
    Step { name: "rust", about: "the Rust tests", needs: &["page", "build"], run: cargo::test, ..MAIN },
    Step {
        name: "python",
        about: "pytest tests/usd, with the program and the plugins",
        needs: &["page", "build", "venv", "plugin"],
        // Both write the headers of the plugin.
        after: &["wheel"],
        run: python::test,
        ..MAIN
    },
    Step {
        name: "browser",
        about: "the preview in Chromium, with the program",
        needs: &["page", "build"],
        after: &["tools"],
        run: browser::test,
        ..MAIN
    },
];

/// Steps that take arguments after `--`.
const TAKE_ARGUMENTS: [&str; 6] = ["rust", "python", "package", "newton", "blender", "browser"];

/// The environments that steps after this one would make themselves.
fn tools(run: &Run<'_>) -> Outcome {
    package::prepare(run)?;
    site::prepare(run.project)?;
    python::prepare_newton(run.project);
    blender::prepare(run)?;
    browser::prepare(run.project)
}

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

/// A command line of `cargo xtask test`.
#[derive(Debug, Default, PartialEq)]
struct Command {
    steps: Vec<String>,
    extra: Vec<String>,
    all: bool,
    alone: bool,
}

impl Command {
    fn parse(args: &[String]) -> Outcome<Self> {
        let (words, extra) = match args.iter().position(|arg| arg == "--") {
            Some(at) => (&args[..at], &args[at + 1..]),
            None => (args, &[][..]),
        };
        let (flags, steps): (Vec<&String>, Vec<&String>) = words.iter().partition(|word| word.starts_with('-'));
        let mut command = Self { extra: extra.to_vec(), ..Self::default() };
        for flag in flags {
            match flag.as_str() {
                "--all" => command.all = true,
                "--alone" => command.alone = true,
                _ => return Err(Failure::new(format!("no flag `{flag}`")).hint("cargo xtask --help lists them")),
            }
        }
        if let Some(unknown) = steps.iter().find(|name| STEPS.iter().all(|step| step.name != name.as_str())) {
            return Err(Failure::new(format!("no step `{unknown}`")).hint("cargo xtask --help lists them"));
        }
        command.steps = steps.into_iter().cloned().collect();
        let takes_extra = matches!(&command.steps[..], [name] if TAKE_ARGUMENTS.contains(&name.as_str()));
        if !extra.is_empty() && !takes_extra {
            return Err(Failure::new(format!("arguments after -- need one step of {}", TAKE_ARGUMENTS.join(", "))));
        }
        Ok(command)
    }

    /// The named steps and, unless they run alone, their prerequisites; all steps if none is named.
    fn selected(&self) -> Vec<&'static Step> {
        let named = |step: &Step| self.steps.is_empty() || self.steps.iter().any(|name| name == step.name);
        let needed = |name: &str| !self.alone && STEPS.iter().any(|step| named(step) && step.needs.contains(&name));
        STEPS.iter().filter(|step| named(step) || needed(step.name)).collect()
    }
}

pub fn test(project: &Project, args: &[String]) -> Outcome {
    let command = Command::parse(args)?;
    lanes::run(project, &command)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(words: &[&str]) -> Outcome<Command> {
        Command::parse(&words.iter().map(ToString::to_string).collect::<Vec<_>>())
    }

    fn names(words: &[&str]) -> Vec<&'static str> {
        parse(words).unwrap().selected().into_iter().map(|step| step.name).collect()
    }

    #[test]
    fn a_step_brings_what_it_needs_and_keeps_the_order() {
        assert_eq!(names(&["python"]), ["page", "venv", "build", "plugin", "python"]);
        assert_eq!(names(&["options", "fmt"]), ["page", "venv", "fmt", "build", "options"]);
        assert_eq!(names(&["--alone", "python"]), ["python"]);
        assert_eq!(names(&["--all"]).len(), STEPS.len());
    }

    #[test]
    fn needs_come_before_the_step_and_bring_their_own() {
        for (at, step) in STEPS.iter().enumerate() {
            for need in step.needs.iter().chain(step.after) {
                let found = STEPS[..at].iter().find(|other| other.name == *need).expect("a step before this one");
                assert!(found.needs.iter().all(|name| step.needs.contains(name)), "{} needs {need}", step.name);
            }
        }
    }

    #[test]
    fn slips_are_refused() {
        assert!(parse(&["rusty"]).expect_err("no such step").to_string().contains("no step `rusty`"));
        assert!(parse(&["--al"]).expect_err("no such flag").to_string().contains("no flag `--al`"));
        assert!(parse(&["fmt", "--", "-q"]).is_err());
        assert_eq!(parse(&["rust", "--all", "--", "--all"]).unwrap().extra, ["--all"]);
    }
}
