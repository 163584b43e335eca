//! The program `usdtailor`.

#[global_allocator]
static ALLOCATOR: tailor::cli::Counting = tailor::cli::Counting;

fn main() -> std::process::ExitCode {
    tailor::cli::main().into()
}
