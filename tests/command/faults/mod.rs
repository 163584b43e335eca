//! Every fault of a user, with what is said of it. Whatever the fault, nothing is written.

mod files;
mod mesh;
mod options;
mod recipe;
mod targets;

use crate::folder::{Folder, Run};

/// One fault: how it is made, how it is met, what is said.
pub struct Fault {
    /// The arguments, separated by blanks.
    args: &'static str,
    /// Makes the files.
    make: Box<dyn Fn(&Folder)>,
    /// Parts of what is said: where, what, remedy.
    says: &'static [&'static str],
}

/// A fault that the arguments meet in what `make` makes.
fn fault(args: &'static str, make: impl Fn(&Folder) + 'static, says: &'static [&'static str]) -> Fault {
    Fault { args, make: Box::new(make), says }
}

/// Checks that each fault ends in exit code 1, is reported as the table says, and leaves every file as it was. All rows are
/// looked at before the first wrong one fails the test.
#[track_caller]
fn each_is_told(faults: &[Fault]) {
    let mut complaints = Vec::new();
    for fault in faults {
        let folder = Folder::new();
        (fault.make)(&folder);
        let before = folder.snapshot();
        let run = folder.run(fault.args);
        complaints.extend(complaint(&run, fault.says));
        if folder.snapshot() != before {
            complaints.push(format!("something was written by {run}"));
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n=====\n"));
}

/// Checks what a fault of the user's looks like.
#[track_caller]
fn check(run: &Run, says: &[&str]) {
    if let Some(complaint) = complaint(run, says) {
        panic!("{complaint}");
    }
}

/// What is wrong with the way in which a fault of the user's is reported, if anything.
fn complaint(run: &Run, says: &[&str]) -> Option<String> {
    let said = &run.stderr;
    let mut wrong = Vec::new();
    // The command line has an exit code of its own, whoever reads it.
    let starts = [
        "error: ",
        "error[command-line]",
        "error[no-input]",
        "error[unknown-option]: --set",
        "error[option-value]: --set",
    ];
    let is_usage = starts.iter().any(|start| said.starts_with(start));
    let code = if is_usage { 2 } else { 1 };
    if run.code != Some(code) {
        wrong.push(format!("the exit code is not {code}"));
    }
    if !run.stdout.is_empty() {
        wrong.push("standard output is for results".into());
    }
    wrong.extend(says.iter().filter(|part| !said.contains(**part)).map(|part| format!("{part:?} is not said")));
    let starting = |with: &str| said.lines().filter(|line| line.starts_with(with)).count();
    // The parser of the command line has its own words; all other faults have a code, and a mesh may have several.
    if !matches!((starting("error: "), starting("error[")), (1, 0) | (0, 1..)) {
        wrong.push("there is not one error".into());
    }
    if !said.contains("\n  hint: ") && !said.contains("try '--help'") {
        wrong.push("there is no remedy".into());
    }
    let ours = ["panicked", "internal", "os error", "f32", "u32", "src/"];
    wrong.extend(ours.iter().filter(|part| said.contains(**part)).map(|part| format!("{part:?} is nothing for users")));
    (!wrong.is_empty()).then(|| format!("{}: {run}", wrong.join(", ")))
}
