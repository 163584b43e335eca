//! `cargo usdtailor`: says at once what a first run does, and goes on to `cargo xtask run`. It has no dependencies, so that cargo
//! builds it within a second.

mod exec;

use std::path::Path;
use std::process::{Command, ExitCode};

const FIRST: &str = "\
cargo usdtailor makes a simulation mesh and a render mesh of a garment in USD. This first run builds it from source:
  1. its tasks, and the page of the preview: up to a minute
  2. the program: about 8 minutes of processor time, 5 minutes on two cores
Later runs start at once. `cargo xtask --help` lists the tasks of developers.
";

fn main() -> ExitCode {
    let program = std::env::current_exe().unwrap_or_default();
    // This program is <target>/<profile>/start.
    let target = program.ancestors().nth(2).unwrap_or(Path::new("target"));
    if !is_built(target) {
        eprintln!("{FIRST}");
    }
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.args(["run", "--quiet", "--ignore-rust-version", "--package", "xtask", "--bin", "xtask", "--manifest-path"]);
    cargo.arg(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml")).args(["--", "run"]).args(std::env::args_os().skip(1));
    eprintln!("error: cannot start cargo: {}", exec::become_it(&mut cargo));
    ExitCode::FAILURE
}

/// Whether an earlier run has built the program.
fn is_built(target: &Path) -> bool {
    target.join(format!("release/usdtailor{}", std::env::consts::EXE_SUFFIX)).is_file()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_run_alone_is_announced() {
        let target = std::env::temp_dir().join(format!("usdtailor-start-{}", std::process::id()));
        assert!(!is_built(&target));
        std::fs::create_dir_all(target.join("release")).unwrap();
        std::fs::write(target.join(format!("release/usdtailor{}", std::env::consts::EXE_SUFFIX)), "").unwrap();
        assert!(is_built(&target));
        std::fs::remove_dir_all(target).unwrap();
    }
}
