//! The program `usdtailor`.

#[global_allocator]
static ALLOCATOR: usdtailor::Counting = usdtailor::Counting;

fn main() -> std::process::ExitCode {
    usdtailor::main().into()
}
