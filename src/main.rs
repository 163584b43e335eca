//! The command `usdtailor`. It exits with 1 for an error in the user's input and with 2 for an internal error.

mod cli;

use clap::Parser;
use std::io::{self, Write};
use std::panic::AssertUnwindSafe;
use std::process::ExitCode;
use tailor::error::{Error, ErrorKind, plain};

fn main() -> ExitCode {
    let cli = match cli::Cli::try_parse() {
        Ok(cli) => cli,
        Err(e) => {
            // Clap reports help and version as errors, for standard output.
            let code = u8::from(e.use_stderr());
            return printed(e.print(), code);
        }
    };
    // A panic becomes one message and the exit code of internal errors.
    std::panic::set_hook(Box::new(|_| {}));
    let result = std::panic::catch_unwind(AssertUnwindSafe(|| cli::run(&cli)))
        .unwrap_or_else(|panic| Err(Error::internal(panic_text(panic.as_ref()))));
    match result {
        Ok(output) => print_all(&output.text, output.code),
        Err(error) => {
            cli::print_error(&error);
            ExitCode::from(exit_code(&error))
        }
    }
}

/// The exit code of an error: 2 for internal errors, else 1.
fn exit_code(error: &Error) -> u8 {
    if error.kind == ErrorKind::Internal { 2 } else { 1 }
}

/// Prints the output.
fn print_all(text: &str, code: u8) -> ExitCode {
    let mut out = io::stdout();
    printed(out.write_all(text.as_bytes()).and_then(|()| out.flush()), code)
}

/// The exit code after printing. A closed pipe is no failure: the reader has read enough.
fn printed(result: io::Result<()>, code: u8) -> ExitCode {
    match result {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            let _ = writeln!(io::stderr(), "error: cannot write to standard output: {}", plain(&e));
            ExitCode::from(code.max(1))
        }
        _ => ExitCode::from(code),
    }
}

fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().cloned();
    text.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned())).unwrap_or_else(|| "no message".into())
}
