//! The program `usdtailor`. It exits with 1 for bad input, with 2 for a wrong command line, and with 70 for a fault of its own.

use super::Cli;
use crate::codes;
use clap::Parser;
use std::io::{self, Write};
use std::panic::{AssertUnwindSafe, PanicHookInfo};
use std::path::Path;
use std::sync::OnceLock;
use tailor_mesh::error::{Error, ErrorCode, ErrorKind, plain};
use tailor_mesh::meter::{PassedLimit, within_limit};

/// The exit code for a wrong command line.
const USAGE: u8 = 2;
/// The exit code for a fault of the program: `EX_SOFTWARE` of `sysexits.h`.
const INTERNAL: u8 = 70;

/// Codes of a wrong command line. Others of the kind are about files that it names.
const ARGUMENTS: [ErrorCode; 4] = [
    tailor_mesh::codes::COMMAND_LINE,
    codes::NO_INPUT,
    tailor_mesh::codes::OPTION_VALUE,
    tailor_costume::codes::UNKNOWN_OPTION,
];

/// Where the first panic was, as file and line.
static PANIC_PLACE: OnceLock<String> = OnceLock::new();

/// Runs the program with the arguments of the process, and returns its exit code.
pub fn main() -> u8 {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(e) => {
            // Clap reports help and version as errors, for standard output.
            return printed(e.print(), if e.use_stderr() { USAGE } else { 0 });
        }
    };
    // A panic becomes one message and the exit code of internal errors.
    std::panic::set_hook(Box::new(note_place));
    let run = || within_limit(|| super::run(&cli)).unwrap_or_else(|PassedLimit| Err(too_much_memory()));
    let result = std::panic::catch_unwind(AssertUnwindSafe(run))
        .unwrap_or_else(|panic| Err(Error::internal(panic_text(panic.as_ref()))));
    match result {
        Ok(output) => print_all(&output.text, output.code),
        Err(error) => {
            super::print_error(&error);
            exit_code(&error)
        }
    }
}

/// The error of a run that has passed its limit of memory.
pub fn too_much_memory() -> Error {
    let fault =
        Error::recipe("", "the run has taken all of the memory that it may take").code(tailor::codes::TOO_LARGE);
    fault.remedy("give fewer or smaller meshes at once, or allow more memory (--max-memory)")
}

/// The exit code of an error.
pub fn exit_code(error: &Error) -> u8 {
    match error.kind {
        ErrorKind::Internal => INTERNAL,
        ErrorKind::Usage if error.faults.iter().any(|fault| ARGUMENTS.contains(&fault.code)) => USAGE,
        _ => 1,
    }
}

fn note_place(panic: &PanicHookInfo<'_>) {
    if let Some(place) = panic.location() {
        let _ = PANIC_PLACE.set(format!("{}:{}", shortened(place.file()), place.line()));
    }
}

/// A source file without the folders of the machine that compiled it: `openusd-0.8.0/src/usd/prim.rs`.
fn shortened(file: &str) -> String {
    let parts: Vec<&str> = file.split(['/', '\\']).collect();
    let is_relative = Path::new(file).is_relative() && !file.contains(':');
    let start = parts.iter().rposition(|part| *part == "src").map_or(parts.len() - 1, |src| src.saturating_sub(1));
    parts[if is_relative { 0 } else { start }..].join("/")
}

/// Prints the output.
fn print_all(text: &str, code: u8) -> u8 {
    let mut out = io::stdout();
    printed(out.write_all(text.as_bytes()).and_then(|()| out.flush()), code)
}

/// The exit code after printing. A closed pipe is not a failure: the reader has read enough.
fn printed(result: io::Result<()>, code: u8) -> u8 {
    match result {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            let _ = writeln!(io::stderr(), "error: cannot write to standard output: {}", plain(&e));
            code.max(1)
        }
        _ => code,
    }
}

/// The message of a panic, with its file and line.
pub fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    let place = PANIC_PLACE.get().map(|place| format!(" at {place}")).unwrap_or_default();
    format!("{}{place}", text.unwrap_or("no message"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_have_no_folder_of_the_build_machine() {
        for (file, expected) in [
            ("src/cli/build.rs", "src/cli/build.rs"),
            (
                "/home/me/.cargo/registry/src/index.crates.io-19/openusd-0.8.0/src/usd/prim.rs",
                "openusd-0.8.0/src/usd/prim.rs",
            ),
            ("/rustc/48cc71ee/library/core/src/option.rs", "core/src/option.rs"),
            ("C:\\Users\\me\\glam-0.30.4\\src\\lib.rs", "glam-0.30.4/src/lib.rs"),
            ("/home/me/build.rs", "build.rs"),
        ] {
            assert_eq!(shortened(file), expected);
        }
    }
}
