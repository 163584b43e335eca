//! Runs other programs and reports their failures.

use std::fmt;
use std::io::{self, IsTerminal, Read, Write};
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// The result of a task.
pub type Outcome<T = ()> = Result<T, Failure>;

/// The reason that a task stopped, with a remedy.
#[derive(Debug)]
pub struct Failure {
    message: String,
    hint: Option<String>,
}

impl Failure {
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), hint: None }
    }

    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// The reason alone.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// Adds the name of the failed step.
    pub fn within(mut self, step: &str) -> Self {
        self.message = format!("step `{step}` failed: {}", self.message);
        self
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "error: {}", self.message)?;
        match &self.hint {
            Some(hint) => write!(f, "\n\nhint: {hint}"),
            None => Ok(()),
        }
    }
}

/// Runs a program with inherited output streams.
pub fn run(command: &mut Command) -> Outcome {
    let status = command.status().map_err(|error| cannot_start(command, &error))?;
    if status.success() { Ok(()) } else { Err(Failure::new(format!("`{}` ended with {status}", shown(command)))) }
}

/// Runs all of some programs, whichever fails. The first failure is the outcome.
pub fn run_all(commands: &mut [Command]) -> Outcome {
    let ended: Vec<Outcome> = commands.iter_mut().map(run).collect();
    ended.into_iter().collect()
}

/// Runs a program silently. On failure, its output is part of the message.
pub fn run_quietly(command: &mut Command) -> Outcome {
    let output = command.output().map_err(|error| cannot_start(command, &error))?;
    if output.status.success() {
        return Ok(());
    }
    let printed = [output.stdout, output.stderr].concat();
    let printed = String::from_utf8_lossy(&printed);
    Err(Failure::new(format!("`{}` ended with {}\n{}", shown(command), output.status, printed.trim_end())))
}

/// Runs a program, and returns how it ended with all that it printed, in order.
pub fn run_and_keep(command: &mut Command) -> Outcome<(Outcome, String)> {
    run_and_pass(command, |_| Ok(()))
}

/// Like [`run_and_keep`], and prints its output as it comes.
pub fn run_and_show(command: &mut Command) -> Outcome<(Outcome, String)> {
    let mut screen = io::stderr();
    if screen.is_terminal() {
        // The program itself writes into a pipe.
        command.env("CARGO_TERM_COLOR", "always").env("FORCE_COLOR", "1");
    }
    run_and_pass(command, |bytes| screen.write_all(bytes))
}

/// Runs a program, keeps what it prints, and passes on each part.
fn run_and_pass(command: &mut Command, mut pass: impl FnMut(&[u8]) -> io::Result<()>) -> Outcome<(Outcome, String)> {
    let fault = |error: &io::Error| Failure::new(format!("cannot pass on the output of a program: {error}"));
    let (mut reader, writer) = io::pipe().map_err(|error| fault(&error))?;
    let second = writer.try_clone().map_err(|error| fault(&error))?;
    let spawned = command.stdout(writer).stderr(second).spawn();
    let mut child = spawned.map_err(|error| cannot_start(command, &error))?;
    // The command holds the writing end, and reading ends when all of those are closed.
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let (mut printed, mut part) = (Vec::new(), [0; 1 << 16]);
    loop {
        match reader.read(&mut part).map_err(|error| fault(&error))? {
            0 => break,
            count => {
                pass(&part[..count]).map_err(|error| fault(&error))?;
                printed.extend(&part[..count]);
            }
        }
    }
    let status = child.wait().map_err(|error| cannot_start(command, &error))?;
    let outcome =
        if status.success() { Ok(()) } else { Err(Failure::new(format!("`{}` ended with {status}", shown(command)))) };
    Ok((outcome, String::from_utf8_lossy(&printed).into_owned()))
}

/// The path of the running program.
pub fn this_program() -> Outcome<PathBuf> {
    std::env::current_exe().map_err(|error| Failure::new(format!("cannot find the path of this program: {error}")))
}

fn cannot_start(command: &Command, error: &std::io::Error) -> Failure {
    Failure::new(format!("cannot run `{}`: {error}", command.get_program().to_string_lossy()))
}

fn shown(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    words.map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
}
