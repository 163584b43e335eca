//! Runs the steps of two lanes side by side. Each lane takes its first step that has what it needs.
//!
//! Each step is a program of its own. Output of the main lane appears as it comes, that of a step beside whole when the step ends,
//! so that the lines of two steps do not mix.

use std::collections::BTreeMap;
use std::process::Command as Program;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use super::faults;
use super::steps::{Lane, Run, Step};
use super::times::Times;
use super::{Command, table};
use crate::process::{self, Failure, Outcome};
use crate::project::Project;

/// What became of a step.
#[derive(Debug, PartialEq, Eq)]
pub enum End {
    Passed,
    /// With the names of tests or a message, a line each.
    Failed(Vec<String>),
    /// A step that it needs did not pass.
    NotRun(&'static str),
}

/// A step that has ended.
pub struct Done {
    pub name: &'static str,
    pub time: Duration,
    pub end: End,
}

/// The steps that have not begun and those that have ended.
struct Board {
    waiting: Vec<&'static Step>,
    done: Vec<Done>,
}

impl Board {
    fn end_of(&self, name: &str) -> Option<&End> {
        self.done.iter().find(|done| done.name == name).map(|done| &done.end)
    }

    /// Ends all steps that need one which has not passed. Needs of needs are among the needs.
    fn drop_hopeless(&mut self) {
        let failed = |name: &&&str| self.end_of(name).is_some_and(|end| *end != End::Passed);
        let missing = |step: &Step| step.needs.iter().find(failed).copied();
        let hopeless: Vec<_> = self.waiting.iter().filter_map(|step| Some((step.name, missing(step)?))).collect();
        for (name, need) in hopeless {
            self.waiting.retain(|step| step.name != name);
            self.done.push(Done { name, time: Duration::ZERO, end: End::NotRun(need) });
        }
    }

    /// Takes the first step of a lane whose predecessors have ended.
    fn take(&mut self, lane: Lane, selected: &[&'static Step]) -> Option<&'static Step> {
        let has_ended = |name: &&str| self.end_of(name).is_some() || selected.iter().all(|step| step.name != *name);
        let is_ready = |step: &Step| step.needs.iter().chain(step.after).all(&has_ended);
        let at = self.waiting.iter().position(|step| step.lane == lane && is_ready(step))?;
        Some(self.waiting.remove(at))
    }
}

/// One run of `cargo xtask test`.
struct Session<'a> {
    project: &'a Project,
    command: &'a Command,
    selected: Vec<&'static Step>,
    times: Times,
    board: Mutex<Board>,
    changed: Condvar,
}

/// Runs the selected steps. A step that fails ends those that need it, and no others.
pub fn run(project: &Project, command: &Command) -> Outcome {
    let selected = command.selected();
    if let [step] = selected[..] {
        let run = Run { project, extra: &command.extra, options: &command.options };
        return (step.check)(&run).and_then(|()| (step.run)(&run)).map_err(|failure| failure.within(step.name));
    }
    let start = Instant::now();
    let times = Times::read(project)?;
    table::announce(project, &selected, &times);
    let board = Board { waiting: selected.clone(), done: Vec::new() };
    let session = Session { project, command, selected, times, board: Mutex::new(board), changed: Condvar::new() };
    session.check_machine();
    thread::scope(|scope| {
        scope.spawn(|| session.run_lane(Lane::Beside));
        session.run_lane(Lane::Main);
    });
    let done = session.board.into_inner().unwrap_or_else(PoisonError::into_inner).done;
    let measured: BTreeMap<&str, f64> =
        done.iter().filter(|done| done.end == End::Passed).map(|done| (done.name, done.time.as_secs_f64())).collect();
    session.times.write(project, &measured)?;
    table::print(&done, start.elapsed());
    let failed: Vec<&str> = done.iter().filter(|done| done.end != End::Passed).map(|done| done.name).collect();
    if failed.is_empty() {
        return Ok(());
    }
    let (count, all) = (failed.len(), done.len());
    Err(Failure::new(format!("{count} of {all} steps did not pass: {}", failed.join(", "))))
}

impl Session<'_> {
    fn board(&self) -> MutexGuard<'_, Board> {
        self.board.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn end(&self, name: &'static str, time: Duration, end: End) {
        let mut board = self.board();
        board.done.push(Done { name, time, end });
        board.drop_hopeless();
        self.changed.notify_all();
    }

    /// Fails steps for which the machine lacks something, before the others compile for minutes.
    fn check_machine(&self) {
        for step in &self.selected {
            let run = Run { project: self.project, extra: &[], options: &self.command.options };
            if let Err(failure) = (step.check)(&run) {
                eprintln!("\n== {}: FAILED before it began\n{failure}", step.name);
                self.board().waiting.retain(|waiting| waiting.name != step.name);
                self.end(step.name, Duration::ZERO, End::Failed(vec![failure.message().to_owned()]));
            }
        }
    }

    /// The next step of a lane; none once all of them have begun or cannot.
    fn next(&self, lane: Lane) -> Option<&'static Step> {
        let mut board = self.board();
        while board.waiting.iter().any(|step| step.lane == lane) {
            if let Some(step) = board.take(lane, &self.selected) {
                return Some(step);
            }
            board = self.changed.wait(board).unwrap_or_else(PoisonError::into_inner);
        }
        None
    }

    fn run_lane(&self, lane: Lane) {
        while let Some(step) = self.next(lane) {
            let start = Instant::now();
            // A fault of this program ends its step alone, as others wait for that.
            let end = self.run_step(step).unwrap_or_else(|failure| End::Failed(vec![failure.message().to_owned()]));
            let (name, time) = (step.name, start.elapsed());
            eprintln!("== {name}: {} in {:.1} s", table::verdict(&end), time.as_secs_f64());
            self.end(name, time, end);
        }
    }

    /// Runs a step as a program of its own.
    fn run_step(&self, step: &'static Step) -> Outcome<End> {
        let command = self.command;
        let mut program: Program = self.project.command(process::this_program()?);
        program.args(["test", "--alone", step.name]).args(command.options.words(step.name));
        // Extra arguments go to the named step only, not to its prerequisites.
        if !command.extra.is_empty() && command.steps.iter().any(|name| name == step.name) {
            program.arg("--").args(&command.extra);
        }
        let number = self.selected.iter().position(|other| other.name == step.name).unwrap_or(0) + 1;
        let last = self.times.told(step.name);
        let heading = format!("== step {number} of {}, {}: {}{last}", self.selected.len(), step.name, step.about);
        let (outcome, output) = if step.lane == Lane::Main {
            eprintln!("\n{heading}");
            process::run_and_show(&mut program)?
        } else {
            let ended = process::run_and_keep(&mut program)?;
            eprintln!("\n{heading}\n{}", ended.1.trim_end());
            ended
        };
        Ok(if outcome.is_ok() { End::Passed } else { End::Failed(faults::of(&output)) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test::steps::STEPS;

    /// Ends a step of a board, and all that need it.
    fn end(board: &mut Board, name: &'static str, end: End) {
        board.waiting.retain(|step| step.name != name);
        board.done.push(Done { name, time: Duration::ZERO, end });
        board.drop_hopeless();
    }

    #[test]
    fn a_failed_step_ends_those_that_need_it_and_no_others() {
        let all: Vec<&'static Step> = STEPS.iter().collect();
        let mut board = Board { waiting: all.clone(), done: Vec::new() };
        for step in ["page", "venv", "tools", "fmt", "clippy", "docs", "plugin"] {
            end(&mut board, step, if step == "clippy" { End::Failed(Vec::new()) } else { End::Passed });
        }
        assert_eq!(board.take(Lane::Main, &all).map(|step| step.name), Some("build"), "clippy is needed by none");
        end(&mut board, "build", End::Failed(Vec::new()));
        for step in &STEPS {
            let is_dropped = board.end_of(step.name) == Some(&End::NotRun("build"));
            assert_eq!(is_dropped, step.needs.contains(&"build"), "{}", step.name);
        }
        assert!(board.waiting.iter().any(|step| step.name == "wheel"), "the package needs no tests");
    }

    #[test]
    fn a_lane_takes_what_is_ready_and_does_not_wait_in_order() {
        let all: Vec<&'static Step> = STEPS.iter().collect();
        let mut board = Board { waiting: all.clone(), done: Vec::new() };
        for step in ["page", "fmt", "clippy", "docs", "build", "prose"] {
            end(&mut board, step, End::Passed);
        }
        // The plugin waits for the environment of Python.
        assert_eq!(board.take(Lane::Main, &all).map(|step| step.name), Some("rust"));
        assert_eq!(board.take(Lane::Beside, &all).map(|step| step.name), Some("venv"));
        assert_eq!(board.take(Lane::Beside, &all).map(|step| step.name), Some("tools"));
        assert_eq!(board.take(Lane::Beside, &all).map(|step| step.name), Some("speed"));
        // A step that is not part of the run is not waited for.
        let few: Vec<&'static Step> = all.iter().copied().filter(|step| step.name != "tools").collect();
        let mut board = Board { waiting: few.clone(), done: Vec::new() };
        assert_eq!(board.take(Lane::Beside, &few).map(|step| step.name), Some("venv"));
        assert_eq!(board.take(Lane::Beside, &few).map(|step| step.name), Some("prose"));
        assert_eq!(board.take(Lane::Beside, &few).map(|step| step.name), Some("site"));
    }
}
