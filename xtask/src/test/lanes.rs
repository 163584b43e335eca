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

/// The outcome of a step.
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

/// The steps by how far they are.
#[derive(Default)]
struct Board {
    waiting: Vec<&'static Step>,
    running: Vec<&'static Step>,
    done: Vec<Done>,
    /// The number of steps that have begun.
    begun: usize,
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

    /// Drops the prerequisites of steps that cannot run.
    fn drop_unneeded(&mut self, command: &Command) {
        let needed: Vec<&str> =
            self.waiting.iter().filter(|s| command.wants(s)).flat_map(|s| s.needs).copied().collect();
        self.waiting.retain(|step| command.wants(step) || needed.contains(&step.name));
    }

    /// Begins the first step of a lane with no predecessor ahead of it, and returns it with its number.
    fn take(&mut self, lane: Lane) -> Option<(&'static Step, usize)> {
        let is_ahead = |name: &&str| self.waiting.iter().chain(&self.running).any(|step| step.name == *name);
        let is_ready = |step: &Step| !step.needs.iter().chain(step.after).any(is_ahead);
        let at = self.waiting.iter().position(|step| step.lane == lane && is_ready(step))?;
        let step = self.waiting.remove(at);
        self.running.push(step);
        self.begun += 1;
        Some((step, self.begun))
    }

    /// Notes the outcome of a step, and ends those that need it if it failed.
    fn end(&mut self, name: &'static str, time: Duration, end: End) {
        self.waiting.retain(|step| step.name != name);
        self.running.retain(|step| step.name != name);
        self.done.push(Done { name, time, end });
        self.drop_hopeless();
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
    let board = Board { waiting: selected.clone(), ..Board::default() };
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
        self.board().end(name, time, end);
        self.changed.notify_all();
    }

    /// Fails steps for which the machine lacks something, before the others compile for minutes.
    fn check_machine(&self) {
        for step in &self.selected {
            let run = Run { project: self.project, extra: &[], options: &self.command.options };
            if let Err(failure) = (step.check)(&run) {
                eprintln!("\n== {}: FAILED before it began\n{failure}", step.name);
                self.end(step.name, Duration::ZERO, End::Failed(vec![failure.message().to_owned()]));
                self.board().drop_unneeded(self.command);
            }
        }
    }

    /// The next step of a lane; none once all of them have begun or cannot.
    fn next(&self, lane: Lane) -> Option<(&'static Step, usize)> {
        let mut board = self.board();
        while board.waiting.iter().any(|step| step.lane == lane) {
            if let Some(begun) = board.take(lane) {
                return Some(begun);
            }
            board = self.changed.wait(board).unwrap_or_else(PoisonError::into_inner);
        }
        None
    }

    fn run_lane(&self, lane: Lane) {
        while let Some((step, number)) = self.next(lane) {
            let start = Instant::now();
            // A fault of this program ends its step alone, as others wait for that.
            let end =
                self.run_step(step, number).unwrap_or_else(|failure| End::Failed(vec![failure.message().to_owned()]));
            let (name, time) = (step.name, start.elapsed());
            eprintln!("== {name}: {} in {:.1} s", table::verdict(&end), time.as_secs_f64());
            self.end(name, time, end);
        }
    }

    /// Runs a step as a program of its own.
    fn run_step(&self, step: &'static Step, number: usize) -> Outcome<End> {
        let command = self.command;
        let mut program: Program = self.project.command(process::this_program()?);
        program.args(["test", "--alone", step.name]).args(command.options.words(step));
        // Extra arguments go to the named step only, not to its prerequisites.
        if !command.extra.is_empty() && command.steps.iter().any(|name| name == step.name) {
            program.arg("--").args(&command.extra);
        }
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

    /// A board on which some steps have passed.
    fn board(steps: impl Iterator<Item = &'static Step>, passed: &[&'static str]) -> Board {
        let mut board = Board { waiting: steps.collect(), ..Board::default() };
        passed.iter().for_each(|name| board.end(name, Duration::ZERO, End::Passed));
        board
    }

    fn next(board: &mut Board, lane: Lane) -> Option<&'static str> {
        board.take(lane).map(|(step, _)| step.name)
    }

    #[test]
    fn a_failed_step_ends_those_that_need_it_and_no_others() {
        let mut board = board(STEPS.iter(), &["page", "venv", "tools", "fmt", "docs", "plugin"]);
        board.end("clippy", Duration::ZERO, End::Failed(Vec::new()));
        assert_eq!(next(&mut board, Lane::Main), Some("build"), "clippy is needed by none");
        board.end("build", Duration::ZERO, End::Failed(Vec::new()));
        for step in &STEPS {
            let is_dropped = board.end_of(step.name) == Some(&End::NotRun("build"));
            assert_eq!(is_dropped, step.needs.contains(&"build"), "{}", step.name);
        }
        assert!(board.waiting.iter().any(|step| step.name == "wheel"), "the package needs no tests");
    }

    #[test]
    fn a_lane_takes_what_is_ready_and_does_not_wait_in_order() {
        let passed = ["page", "fmt", "clippy", "docs", "build", "prose"];
        let mut whole = board(STEPS.iter(), &passed);
        // The plugin waits for the environment of Python, and the browser for the tools.
        assert_eq!(next(&mut whole, Lane::Main), Some("rust"));
        assert_eq!(
            ["venv", "tools", "speed"].map(|_| next(&mut whole, Lane::Beside)),
            ["venv", "tools", "speed"].map(Some)
        );
        assert_eq!(whole.begun, 4);
        whole.end("tools", Duration::ZERO, End::Passed);
        assert_eq!(next(&mut whole, Lane::Main), Some("browser"), "a step that runs is ahead until it ends");
        // A step that is not part of the run is not waited for.
        let mut few = board(STEPS.iter().filter(|step| step.name != "tools"), &passed);
        assert_eq!(["venv", "site"].map(|_| next(&mut few, Lane::Beside)), ["venv", "site"].map(Some));
    }

    #[test]
    fn prerequisites_of_a_step_that_cannot_run_are_dropped() {
        let words = ["browser", "clippy"].map(str::to_owned);
        let command = Command::parse(&words).unwrap();
        let mut board = board(command.selected().into_iter(), &[]);
        board.end("browser", Duration::ZERO, End::Failed(Vec::new()));
        board.drop_unneeded(&command);
        assert_eq!(board.waiting.iter().map(|step| step.name).collect::<Vec<_>>(), ["clippy"]);
        assert_eq!(next(&mut board, Lane::Main), Some("clippy"), "the page is dropped, and no longer ahead");
    }
}
