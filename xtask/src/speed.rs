//! Instructions of two builds and of their remeshing, counted by Valgrind, against stored figures: speed watched without a clock.
//!
//! Counts are those of the program as tests run it, on one thread. They repeat for one compiler, so the figures name theirs.

use std::fmt::Write as _;
use std::fs;

use crate::apt;
use crate::cargo::Profile;
use crate::process::{self, Failure, Outcome};
use crate::project::Project;
use crate::test::Run;

/// The stored figures: a line that names the compiler, then a garment, the count of its build and that of its remeshing on each.
const FILE: &str = "tests/golden/instructions.txt";

/// The garments that are built: an example, and a large one.
const GARMENTS: [&str; 2] = ["examples/sewn/coat.usda", "tests/garments/layered_suit.usdc"];

/// The function that remeshes. On one thread, all that it does is in its own calls.
const REMESHER: &str = "tailor::sim::product::simulate";

/// Largest difference from a stored count, and from the stored ratio of a build to its remeshing, as a share of it.
const TOLERANCE: f64 = 0.05;

/// Instructions of a build.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Counts {
    build: u64,
    remesh: u64,
}

impl Counts {
    /// A build, as a multiple of its remeshing.
    fn ratio(self) -> f64 {
        self.build as f64 / self.remesh as f64
    }

    fn in_words(self) -> String {
        format!("{:.2} billion instructions, {:.2} times the remeshing", self.build as f64 / 1e9, self.ratio())
    }
}

/// Counts, and writes [`FILE`].
pub fn write(project: &Project) -> Outcome {
    let mut text = format!("{}\n", compiler(project)?);
    for garment in GARMENTS {
        let counts = instructions(project, garment)?;
        let _ = writeln!(text, "{garment} {} {}", counts.build, counts.remesh);
        eprintln!("{garment}: {}", counts.in_words());
    }
    fs::write(project.root.join(FILE), text).map_err(|error| Failure::new(format!("cannot write {FILE}: {error}")))
}

/// Installs Valgrind on request.
pub fn prepare(run: &Run<'_>) -> Outcome {
    if run.options.install && apt::on_path(&["valgrind"]).is_none() {
        apt::install(run.project, "valgrind")
    } else {
        Ok(())
    }
}

/// Compares counts with [`FILE`].
pub fn check(project: &Project) -> Outcome {
    let text = project.read(FILE)?;
    let (stored_with, rows) = text.split_once('\n').unwrap_or((&text, ""));
    let used = compiler(project)?;
    if used != stored_with {
        eprintln!("SKIPPED: instructions are NOT counted: {FILE} is of {stored_with}, and this is {used}");
        return Ok(());
    }
    if apt::on_path(&["valgrind"]).is_none() {
        eprintln!("SKIPPED: instructions are NOT counted: no valgrind is on the path (cargo xtask test --install)");
        return Ok(());
    }
    for line in rows.lines() {
        let unread = || Failure::new(format!("{FILE} has a line that is not a garment with two counts: {line}"));
        let (garment, stored) = row(line).ok_or_else(unread)?;
        let counts = instructions(project, garment)?;
        let share = counts.build as f64 / stored.build as f64 - 1.0;
        eprintln!("{garment}: {}; {:+.1} %", counts.in_words(), 100.0 * share);
        let hint =
            "find what the change costs; if it is worth that, or a gain, run cargo xtask speed and commit the figures";
        if share.abs() > TOLERANCE {
            return Err(Failure::new(format!(
                "a build of {garment} takes {:+.1} % instructions; {FILE} allows {:.0} %",
                100.0 * share,
                100.0 * TOLERANCE
            ))
            .hint(hint));
        }
        if counts.ratio() > (1.0 + TOLERANCE) * stored.ratio() {
            let problem = format!(
                "a build of {garment} takes {:.2} times its remeshing; {FILE} has {:.2}",
                counts.ratio(),
                stored.ratio()
            );
            return Err(Failure::new(problem).hint(hint));
        }
    }
    Ok(())
}

fn row(line: &str) -> Option<(&str, Counts)> {
    let mut words = line.split(' ');
    let (garment, build, remesh) = (words.next()?, words.next()?, words.next()?);
    Some((garment, Counts { build: build.parse().ok()?, remesh: remesh.parse().ok()? }))
}

/// The version of the compiler.
fn compiler(project: &Project) -> Outcome<String> {
    let program = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let (outcome, text) = process::run_and_keep(project.command(program).arg("--version"))?;
    outcome.map(|()| text.trim().to_owned())
}

/// Counts the instructions of one build and of its remeshing.
fn instructions(project: &Project, garment: &str) -> Outcome<Counts> {
    let folder = project.scratch("speed")?;
    let profile = folder.join("callgrind.out");
    let mut command = project.command("valgrind");
    command.arg("--tool=callgrind").arg(format!("--callgrind-out-file={}", profile.display()));
    command.arg(Profile::Tested.program(project));
    command.args(["build", garment, "--threads", "1", "-o"]).arg(folder.join("built.usdc"));
    let (outcome, text) = process::run_and_keep(&mut command)?;
    outcome.map_err(|failure| failure.hint(text.clone()))?;
    let profile =
        fs::read_to_string(&profile).map_err(|error| Failure::new(format!("valgrind left no profile: {error}")))?;
    counted(&profile).ok_or_else(|| Failure::new(format!("valgrind counted no remeshing of {garment}")))
}

/// The counts in a profile of Callgrind: `summary: 12` for all, and the second number below `calls=` for a call. A function has its name
/// where it is first met, and a number that it is called by: `cfn=(7) name`, then `cfn=(7)`.
fn counted(profile: &str) -> Option<Counts> {
    let mut counts = Counts { build: 0, remesh: 0 };
    let (mut remesher, mut is_call) = (None, false);
    let mut lines = profile.lines();
    while let Some(line) = lines.next() {
        if let Some(count) = line.strip_prefix("summary: ").or_else(|| line.strip_prefix("totals: ")) {
            counts.build = count.trim().parse().ok()?;
        } else if let Some((kind, function)) = line.split_once("fn=(") {
            let (number, name) = function.split_once(')')?;
            if name.trim_start().starts_with(REMESHER) {
                remesher = Some(number.to_owned());
            }
            is_call = kind == "c" && remesher.as_deref() == Some(number);
        } else if line.starts_with("calls=") && std::mem::take(&mut is_call) {
            counts.remesh += lines.next()?.split(' ').nth(1)?.parse::<u64>().ok()?;
        }
    }
    (counts.build > 0 && counts.remesh > 0).then_some(counts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_read() {
        let counts = Counts { build: 12, remesh: 4 };
        assert_eq!(row("examples/sewn/coat.usda 12 4"), Some(("examples/sewn/coat.usda", counts)));
        assert_eq!(row("rustc"), None);
        let called = format!(
            "fn=(1) main\ncfn=(2) {REMESHER}\ncalls=1 0\n0 3\ncfn=(3) other\ncalls=2 0\n0 8\ncfn=(2)\ncalls=1 0\n0 1\n"
        );
        assert_eq!(counted(&format!("{called}totals: 12\n")), Some(counts));
        assert_eq!(counted(&called), None);
    }
}
