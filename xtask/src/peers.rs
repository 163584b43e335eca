//! `cargo xtask peers`: other remeshers on the same surfaces, measured by the same code, in one table.

use crate::cargo;
use crate::process::{self, Failure, Outcome};
use crate::project::Project;

/// What the peers are installed from, in an environment of their own.
const PACKAGES: [&str; 7] = ["numpy", "pymeshlab", "gpytoolbox", "meshlib", "scipy", "usd-core", "pillow"];

/// Close-ups of our mesh, of stitched lattices and of PyMeshLab's.
const PICTURE: &str = "docs/looks/lattice.png";

/// Exports the garments, lets the peers remesh them, and prints the tables: quality, and valence along constraints.
pub fn run(project: &Project) -> Outcome {
    let folder = project.scratch("peers")?;
    table(project, "quality", "PEERS_EXPORT", &folder)?;
    let environment = project.target.join("peers-venv");
    let programs = environment.join(if cfg!(windows) { "Scripts" } else { "bin" });
    let python = programs.join(if cfg!(windows) { "python.exe" } else { "python" });
    if !std::fs::read_to_string(environment.join("installed")).is_ok_and(|text| text == PACKAGES.join("\n")) {
        let base = std::env::var("PYTHON").unwrap_or_else(|_| "python3".into());
        process::run(project.command(base).args(["-m", "venv", "--clear"]).arg(&environment))?;
        process::run(project.command(&python).args(["-m", "pip", "install", "--quiet"]).args(PACKAGES))?;
        std::fs::write(environment.join("installed"), PACKAGES.join("\n"))
            .map_err(|error| Failure::new(format!("cannot write in {}: {error}", environment.display())))?;
    }
    process::run(project.command(&python).arg("tests/bench/peers.py").arg(&folder))?;
    table(project, "quality", "PEERS_MEASURE", &folder)?;
    table(project, "lattice", "PEERS_EXPORT", &folder)?;
    let picture = project.root.join(PICTURE);
    process::run(project.command(&python).arg("tests/bench/lattice.py").arg(&folder).arg(picture))
}

/// Runs a table of `src/testing/tests/peers` with a folder for `variable`.
fn table(project: &Project, name: &str, variable: &str, folder: &std::path::Path) -> Outcome {
    let mut command = cargo::cargo(project, "test");
    command.args(["--release", "--package", "tailor-testing", "--test", "meshes", &format!("peers::{name}::table")]);
    process::run(command.args(["--", "--ignored", "--nocapture"]).env(variable, folder))
}
