//! Runs another program in place of this one.

use std::process::Command;

/// Becomes another program. Returns only a failure.
#[cfg(unix)]
pub fn become_it(command: &mut Command) -> std::io::Error {
    use std::os::unix::process::CommandExt;
    command.exec()
}

/// Runs another program, and ends as it does. Returns only a failure.
#[cfg(not(unix))]
pub fn become_it(command: &mut Command) -> std::io::Error {
    match command.status() {
        Ok(status) => std::process::exit(status.code().unwrap_or(1)),
        Err(error) => error,
    }
}
