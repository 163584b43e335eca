//! `cargo xtask test`: runs the test steps that a command line names, or all of them.

mod faults;
mod lanes;
mod steps;
mod table;
mod times;

use std::fmt::Write as _;
use std::path::PathBuf;

use crate::process::{Failure, Outcome};
use crate::project::Project;
use steps::{STEPS, Step};

pub use steps::{Options, Run};

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
    options: Options,
    alone: bool,
}

impl Command {
    fn parse(args: &[String]) -> Outcome<Self> {
        let (words, extra) = match args.iter().position(|arg| arg == "--") {
            Some(at) => (&args[..at], &args[at + 1..]),
            None => (args, &[][..]),
        };
        let mut command = Self { extra: extra.to_vec(), ..Self::default() };
        let mut rest = words.iter();
        while let Some(word) = rest.next() {
            match word.as_str() {
                "--all" => command.options.all = true,
                "--alone" => command.alone = true,
                "--install" => command.options.install = true,
                "--folder" => command.options.folder = Some(folder(word, rest.next())?),
                "--bodies" => command.options.bodies = Some(folder(word, rest.next())?),
                _ if word.starts_with('-') => {
                    return Err(Failure::new(format!("no flag `{word}`")).hint("cargo xtask --help lists them"));
                }
                _ => command.steps.push(word.clone()),
            }
        }
        command.check()?;
        Ok(command)
    }

    fn check(&self) -> Outcome {
        if let Some(unknown) = self.steps.iter().find(|name| STEPS.iter().all(|step| step.name != name.as_str())) {
            return Err(Failure::new(format!("no step `{unknown}`")).hint("cargo xtask --help lists them"));
        }
        let named = || STEPS.iter().filter(|step| self.names(step));
        let takes_extra = self.steps.len() == 1 && named().all(|step| step.takes_arguments);
        if !self.extra.is_empty() && !takes_extra {
            let all: Vec<&str> = STEPS.iter().filter(|step| step.takes_arguments).map(|step| step.name).collect();
            return Err(Failure::new(format!("arguments after -- need one step of {}", all.join(", "))));
        }
        let takes_folder = named().any(|step| step.takes_folder);
        if self.options.folder.is_none() && (takes_folder || self.options.bodies.is_some()) {
            return Err(Failure::new("no folder of garments").hint("add --folder FOLDER, with stages of garments"));
        }
        if self.options.folder.is_some() && !takes_folder && !self.steps.is_empty() {
            return Err(Failure::new("no named step takes --folder").hint("cargo xtask test garments --folder FOLDER"));
        }
        Ok(())
    }

    fn names(&self, step: &Step) -> bool {
        self.steps.iter().any(|name| name == step.name)
    }

    /// Whether a step runs for its own sake. A command line without names means all steps that need no folder, or have one.
    fn wants(&self, step: &Step) -> bool {
        self.names(step) || self.steps.is_empty() && (!step.takes_folder || self.options.folder.is_some())
    }

    /// The wanted steps and, unless they run alone, their prerequisites.
    fn selected(&self) -> Vec<&'static Step> {
        let needed = |name: &str| !self.alone && STEPS.iter().any(|s| self.wants(s) && s.needs.contains(&name));
        STEPS.iter().filter(|step| self.wants(step) || needed(step.name)).collect()
    }
}

/// The folder that follows a flag. Steps run in the project's root, so that it becomes absolute.
fn folder(flag: &str, value: Option<&String>) -> Outcome<PathBuf> {
    let named = value.ok_or_else(|| Failure::new(format!("{flag} has no folder")))?;
    let found = std::path::absolute(named).ok().filter(|path| path.is_dir());
    found.ok_or_else(|| Failure::new(format!("{flag}: no folder `{named}`")))
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
        assert_eq!(names(&["--all"]).len(), STEPS.len() - 1);
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
    fn garments_of_a_folder_are_a_step_where_a_folder_is_named() {
        let here = env!("CARGO_MANIFEST_DIR");
        assert_eq!(names(&["garments", "--folder", here]), ["page", "venv", "build", "plugin", "garments"]);
        assert_eq!(names(&["--folder", here]).len(), STEPS.len());
        assert!(!names(&[]).contains(&"garments"));
        assert!(parse(&["garments"]).is_err() && parse(&["rust", "--folder", here]).is_err());
        assert!(parse(&["garments", "--folder", "no such folder"]).is_err());
    }

    #[test]
    fn each_step_understands_the_options_of_the_run() {
        let here = env!("CARGO_MANIFEST_DIR");
        let command = parse(&["--all", "--install", "--folder", here, "--bodies", here]).unwrap();
        for step in command.selected() {
            let words = command.options.words(step);
            let mut again: Vec<String> = words.iter().map(|word| word.to_string_lossy().into()).collect();
            again.push(step.name.to_owned());
            let options = Command::parse(&again).unwrap().options;
            assert!(options.all && options.install, "{}", step.name);
            assert!(!step.takes_folder || options == command.options);
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
