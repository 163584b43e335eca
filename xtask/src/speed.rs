//! Instructions of two builds, counted by Valgrind, against stored figures: speed watched without a clock.
//!
//! Counts are those of the program as tests run it, on one thread. They repeat for one compiler, so the figures name theirs.

use std::fmt::Write as _;
use std::fs;

use crate::apt;
use crate::cargo::Profile;
use crate::process::{self, Failure, Outcome};
use crate::project::Project;
use crate::test::Run;

/// The stored figures: a line that names the compiler, then a garment and its count on each.
const FILE: &str = "tests/golden/instructions.txt";

/// The garments that are built: an example, and a large one.
const GARMENTS: [&str; 2] = ["examples/sewn/coat.usda", "tests/garments/layered_suit.usdc"];

/// Largest difference from a stored count, as a share of it.
const TOLERANCE: f64 = 0.05;

/// Counts, and writes [`FILE`].
pub fn write(project: &Project) -> Outcome {
    let mut text = format!("{}\n", compiler(project)?);
    for garment in GARMENTS {
        let count = instructions(project, garment)?;
        let _ = writeln!(text, "{garment} {count}");
        eprintln!("{garment}: {:.2} billion instructions", count as f64 / 1e9);
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
    for (garment, stored) in rows.lines().filter_map(row) {
        let count = instructions(project, garment)?;
        let share = count as f64 / stored as f64 - 1.0;
        eprintln!("{garment}: {:.2} billion instructions, {:+.1} %", count as f64 / 1e9, 100.0 * share);
        if share.abs() > TOLERANCE {
            return Err(Failure::new(format!(
                "a build of {garment} takes {:+.1} % instructions; {FILE} allows {:.0} %",
                100.0 * share,
                100.0 * TOLERANCE
            ))
            .hint("find what the change costs; if it is worth that, or a gain, run cargo xtask speed and commit the figures"));
        }
    }
    Ok(())
}

fn row(line: &str) -> Option<(&str, u64)> {
    let (garment, count) = line.split_once(' ')?;
    Some((garment, count.parse().ok()?))
}

/// The version of the compiler.
fn compiler(project: &Project) -> Outcome<String> {
    let program = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let (outcome, text) = process::run_and_keep(project.command(program).arg("--version"))?;
    outcome.map(|()| text.trim().to_owned())
}

/// Counts the instructions of one build.
fn instructions(project: &Project, garment: &str) -> Outcome<u64> {
    let folder = project.scratch("speed")?;
    let mut command = project.command("valgrind");
    // Without a simulated cache, Cachegrind takes less than half of Callgrind's time.
    command.args(["--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null"]);
    command.arg(Profile::Tested.program(project));
    command.args(["build", garment, "--threads", "1", "-o"]).arg(folder.join("built.usdc"));
    let (outcome, text) = process::run_and_keep(&mut command)?;
    outcome.map_err(|failure| failure.hint(text.clone()))?;
    counted(&text).ok_or_else(|| Failure::new(format!("valgrind printed no count for {garment}")))
}

/// The count in the output of Cachegrind: `==7== I   refs:      1,234,567`.
fn counted(text: &str) -> Option<u64> {
    let (_, after) = text.rsplit_once("refs:")?;
    after.split_whitespace().next()?.replace(',', "").parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_read() {
        assert_eq!(row("examples/sewn/coat.usda 12"), Some(("examples/sewn/coat.usda", 12)));
        assert_eq!(row("rustc"), None);
        assert_eq!(counted("==1== \n==1== I   refs:      1,234,567\n"), Some(1_234_567));
        assert_eq!(counted("==1== killed"), None);
    }
}
