//! Runs the steps of two lanes side by side, and prints the time of each.
//!
//! The steps beside run as programs of their own, whose output appears whole when they end, so that the lines of two steps do not
//! mix.

use std::process::Command as Program;
use std::sync::{Condvar, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use super::{Command, Lane, Run, Step};
use crate::process::{self, Outcome};
use crate::project::Project;

/// What became of a step, and its time.
struct Done {
    name: &'static str,
    time: Duration,
    passed: bool,
}

/// The steps that have ended, for those that wait.
#[derive(Default)]
struct Board {
    done: Mutex<Vec<Done>>,
    changed: Condvar,
}

impl Board {
    /// Waits until the steps have ended; false if one of all steps has failed, after which nothing new begins.
    fn wait_for(&self, steps: &[&str]) -> bool {
        let is_waiting = |done: &mut Vec<Done>| {
            done.iter().all(|d| d.passed) && !steps.iter().all(|name| done.iter().any(|d| d.name == *name))
        };
        let done = self.done.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let done = self.changed.wait_while(done, is_waiting).unwrap_or_else(std::sync::PoisonError::into_inner);
        done.iter().all(|d| d.passed)
    }

    fn add(&self, done: Done) {
        self.done.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push(done);
        self.changed.notify_all();
    }
}

/// Runs the selected steps, and stops at the first failure of each lane.
pub fn run(project: &Project, command: &Command) -> Outcome {
    let selected = command.selected();
    let board = Board::default();
    let start = Instant::now();
    // One step alone needs no lane.
    let lane_of = |step: &Step| if selected.len() == 1 { Lane::Main } else { step.lane };
    let run_lane = |lane: Lane| {
        let steps = selected.iter().filter(|step| lane_of(step) == lane);
        steps.map(|step| run_step(project, command, step, lane, &board, &selected)).find(Outcome::is_err)
    };
    let (main, beside) = thread::scope(|scope| {
        let beside = scope.spawn(|| run_lane(Lane::Beside));
        (run_lane(Lane::Main), beside.join())
    });
    print_table(&board.done.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner), start.elapsed());
    let beside = beside.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
    main.or(beside).unwrap_or(Ok(()))
}

fn run_step(
    project: &Project,
    command: &Command,
    step: &'static Step,
    lane: Lane,
    board: &Board,
    selected: &[&'static Step],
) -> Outcome {
    let runs = |name: &&&str| selected.iter().any(|other| other.name == **name);
    let before: Vec<&str> = step.needs.iter().chain(step.after).filter(runs).copied().collect();
    if !board.wait_for(&before) {
        return Ok(());
    }
    // Extra arguments go to the named step only, not to its prerequisites.
    let extra = if command.steps.iter().any(|name| name == step.name) { &command.extra[..] } else { &[] };
    let start = Instant::now();
    let outcome = match lane {
        Lane::Main => {
            eprintln!("\n== {}: {}", step.name, step.about);
            (step.run)(&Run { project, extra, all: command.all })
        }
        Lane::Beside => run_apart(project, step, extra, command.all),
    };
    let outcome = outcome.map_err(|failure| failure.within(step.name));
    let done = Done { name: step.name, time: start.elapsed(), passed: outcome.is_ok() };
    // A program of its own has said so.
    if lane == Lane::Main {
        eprintln!("== {}: {} in {:.1} s", done.name, verdict(&done), done.time.as_secs_f64());
    }
    board.add(done);
    outcome
}

/// Runs a step as a program of its own, and prints its output when it ends.
fn run_apart(project: &Project, step: &Step, extra: &[String], all: bool) -> Outcome {
    let mut program: Program = project.command(process::this_program()?);
    program.args(["test", "--alone", step.name]).args(all.then_some("--all"));
    if !extra.is_empty() {
        program.arg("--").args(extra);
    }
    let (outcome, output) = process::run_and_keep(&mut program)?;
    eprintln!("\n{}", output.trim_end());
    outcome
}

fn verdict(done: &Done) -> &'static str {
    if done.passed { "passed" } else { "FAILED" }
}

fn print_table(steps: &[Done], total: Duration) {
    if steps.len() < 2 {
        return;
    }
    eprintln!("\nstep       time [s]");
    for done in steps {
        eprintln!("{:<8} {:>10.1}  {}", done.name, done.time.as_secs_f64(), verdict(done));
    }
    eprintln!("{:<8} {:>10.1}", "total", total.as_secs_f64());
}
