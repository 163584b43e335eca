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
use steps::{GARMENTS, STEPS, Step};

pub use steps::{Options, Run};

/// Steps that take arguments after `--`.
const TAKE_ARGUMENTS: [&str; 6] = ["rust", "python", "package", "newton", "blender", "browser"];

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
        let takes_extra = matches!(&self.steps[..], [name] if TAKE_ARGUMENTS.contains(&name.as_str()));
        if !self.extra.is_empty() && !takes_extra {
            return Err(Failure::new(format!("arguments after -- need one step of {}", TAKE_ARGUMENTS.join(", "))));
        }
        let (options, names_it) = (&self.options, self.steps.iter().any(|name| name == GARMENTS));
        if options.folder.is_none() && (names_it || options.bodies.is_some()) {
            return Err(Failure::new("no folder of garments").hint("add --folder FOLDER, with stages of garments"));
        }
        if options.folder.is_some() && !names_it && !self.steps.is_empty() {
            return Err(Failure::new(format!("only the step `{GARMENTS}` takes --folder")));
        }
        Ok(())
    }

    /// The named steps and, unless they run alone, their prerequisites; all steps if none is named. The garments of a folder are
    /// a step where a folder is named.
    fn selected(&self) -> Vec<&'static Step> {
        let is_had = |step: &Step| step.name != GARMENTS || self.options.folder.is_some();
        let is_named =
            |step: &Step| is_had(step) && (self.steps.is_empty() || self.steps.iter().any(|n| n == step.name));
        let needed = |name: &str| !self.alone && STEPS.iter().any(|step| is_named(step) && step.needs.contains(&name));
        STEPS.iter().filter(|step| is_named(step) || needed(step.name)).collect()
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
        assert_eq!(names(&[GARMENTS, "--folder", here]), ["page", "venv", "build", "plugin", GARMENTS]);
        assert_eq!(names(&["--folder", here]).len(), STEPS.len());
        assert!(!names(&[]).contains(&GARMENTS));
        assert!(parse(&[GARMENTS]).is_err() && parse(&["rust", "--folder", here]).is_err());
        assert!(parse(&[GARMENTS, "--folder", "no such folder"]).is_err());
    }

    #[test]
    fn each_step_understands_the_options_of_the_run() {
        let here = env!("CARGO_MANIFEST_DIR");
        let command = parse(&["--all", "--install", "--folder", here, "--bodies", here]).unwrap();
        for step in command.selected() {
            let words = command.options.words(step.name);
            let mut again: Vec<String> = words.iter().map(|word| word.to_string_lossy().into()).collect();
            again.push(step.name.to_owned());
            let options = Command::parse(&again).unwrap().options;
            assert!(options.all && options.install, "{}", step.name);
            assert!(step.name != GARMENTS || options == command.options);
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
