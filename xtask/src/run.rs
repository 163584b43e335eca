//! `cargo usdtailor`: the program, built from source with the page of its preview.

use std::process::Command;

use crate::cargo::{self, Profile};
use crate::exec;
use crate::page;
use crate::process::{self, Failure, Outcome};
use crate::project::Project;

/// Makes the page where it is missing, builds the program, and runs it in the folder of the caller. Only `preview` needs the page.
pub fn run(project: &Project, args: &[String]) -> Outcome {
    if let Err(failure) = page::ensure(project) {
        if args.first().is_some_and(|command| command == "preview") {
            return Err(failure);
        }
        eprintln!("warning: `usdtailor preview` has no page.\n{failure}\n");
    }
    process::run(cargo::cargo(project, "build").args(Profile::Release.flags()).args(["--bin", "usdtailor"]))?;
    let program = Profile::Release.program(project);
    let mut command = Command::new(&program);
    command.args(args);
    Err(Failure::new(format!("cannot start {}: {}", program.display(), exec::become_it(&mut command))))
}
