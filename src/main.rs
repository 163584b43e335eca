//! The program `usdtailor`.

fn main() -> std::process::ExitCode {
    tailor::cli::main().into()
}
