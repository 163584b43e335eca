//! The command `usdtailor`: flags in, exit code out.

mod cli;

use clap::Parser;
use std::io::{ErrorKind, Write};
use std::panic::AssertUnwindSafe;
use std::process::ExitCode;
use tailor::error::Error;

fn main() -> ExitCode {
    let cli = match cli::Cli::try_parse() {
        Ok(cli) => cli,
        Err(e) => {
            // Help and version are answers, anything else is the user's input.
            let code = u8::from(e.use_stderr());
            return if e.print().is_ok() { ExitCode::from(code) } else { ExitCode::SUCCESS };
        }
    };
    // A fault of ours must still end in one clear message and its own exit code.
    std::panic::set_hook(Box::new(|_| {}));
    let result = std::panic::catch_unwind(AssertUnwindSafe(|| cli::run(&cli)))
        .unwrap_or_else(|panic| Err(Error::Internal(panic_text(panic.as_ref()))));
    match result {
        Ok(output) => print_all(&output.text, output.code),
        Err(error) => {
            let _ = writeln!(std::io::stderr(), "error: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}

fn print_all(text: &str, code: u8) -> ExitCode {
    match std::io::stdout().write_all(text.as_bytes()) {
        // Whoever closed the pipe has read enough.
        Err(e) if e.kind() != ErrorKind::BrokenPipe => ExitCode::from(2),
        _ => ExitCode::from(code),
    }
}

fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().cloned();
    text.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned())).unwrap_or_else(|| "no message".into())
}
