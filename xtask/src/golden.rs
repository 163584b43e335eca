//! `cargo xtask golden`: makes `tests/golden/*.bin` from Pixar OpenSubdiv.
//!
//! ```text
//! cargo xtask golden                    write tests/golden/*.bin
//! cargo xtask golden --out DIR          write them elsewhere
//! ```
//!
//! OpenSubdiv comes from the sources which the crate `opensubdiv-petite-sys` carries (fetched by
//! cargo, not compiled as a crate), or from the installation that `OPENSUBDIV_ROOT` names. CMake and
//! a C++17 compiler are needed; the ordinary tests need neither, only the committed data.
//!
//! Meshes are made in C++, except the garments in `examples`, which `xtask/golden/garments.py` hands over. After a change
//! of those, the data are to be made again.
//!
//! The data hold, for every case, the base mesh and samples of levels 1 to 3 of its uniform
//! refinement. Little endian, no padding; `str` is a `u16` length and UTF-8 bytes:
//!
//! ```text
//! file    "SUBDGOLD", u32 version (1), u32 case count, cases
//! case    str name, u8 scheme, u8 boundary, u8 triangle rule, u8 number of slots S,
//!         u8[6] slot of each face-varying rule,
//!         u32 V, V * (f32[3] point, f32[2] varying value),
//!         u32 F, F * u16 vertex count, u32 C, C * u16 vertex,
//!         u32 n, n * (u16, u16, f32) edge sharpness, u32 n, n * (u16, f32) vertex sharpness,
//!         u32 n, n * u16 hole, u32 n, n * f32[2] face-varying values, C * u16 value index,
//!         3 * level
//! level   u32 vertices, edges, faces, face-vertices,
//!         f64[3], f64[2], S * f64[2], f64: sums over all corners of all faces of point, varying
//!         value, face-varying values, edge sharpness,
//!         u32 number of samples, samples
//! sample  u32 face, u16 base face, u8 hole, u8 corners, corners * corner
//! corner  u32 vertex, u8 flags, f32[3] point, f32[2] varying value, f32[2] value of slot 0,
//!         bit 0: f32 sharpness of the edge to the next corner, bit 1: f32 vertex sharpness,
//!         bit 1+k: f32[2] value of slot k (without it, that of slot 0)
//! ```
//!
//! `xtask/golden/write.h` says the same in more words, `src/mesh/subdivide/tests/golden.rs` is the reader.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::process::{self, Failure, Outcome};
use crate::project::Project;
use crate::venv;

/// The crate whose package carries the sources of OpenSubdiv.
const SOURCES: &str = "opensubdiv-petite-sys";

/// Runs the task with the arguments after `golden`.
pub fn run(project: &Project, args: &[String]) -> Outcome {
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let path = match args[..] {
        [] => project.root.join("tests/golden"),
        ["--out", dir] => PathBuf::from(dir),
        _ => return Err(Failure::new("usage: cargo xtask golden [--out DIR]")),
    };
    let program = build(project)?;
    let garments = project.target.join("golden/garments");
    let python = venv::ensure(project)?;
    process::run(project.command(python).arg("xtask/golden/garments.py").arg(&garments))?;
    process::run(Command::new(program).arg(path).arg(garments))
}

/// Builds the generator with CMake in `target/golden` and returns its path.
fn build(project: &Project) -> Outcome<PathBuf> {
    let source = project.root.join("xtask/golden");
    let build = project.target.join("golden");
    // Both are always given, as CMake remembers the choice of the last time.
    let (installed, sources) = match env::var_os("OPENSUBDIV_ROOT") {
        Some(prefix) => (PathBuf::from(prefix), PathBuf::new()),
        None => (PathBuf::new(), opensubdiv_sources(&source)?),
    };
    process::run_quietly(
        Command::new("cmake")
            .arg("-S")
            .arg(&source)
            .arg("-B")
            .arg(&build)
            .arg("-DCMAKE_BUILD_TYPE=Release")
            .arg(format!("-DOPENSUBDIV_ROOT={}", installed.display()))
            .arg(format!("-DOPENSUBDIV_SOURCE={}", sources.display())),
    )?;
    let options = ["--config", "Release", "--parallel", "2"];
    process::run_quietly(Command::new("cmake").arg("--build").arg(&build).args(options))?;
    let name = format!("golden{}", env::consts::EXE_SUFFIX);
    [build.join(&name), build.join("Release").join(&name)]
        .into_iter()
        .find(|path| path.is_file())
        .ok_or_else(|| Failure::new(format!("CMake made no {name}")))
}

/// The OpenSubdiv tree inside the fetched package.
fn opensubdiv_sources(manifest_dir: &Path) -> Outcome<PathBuf> {
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    // This fetches the package where it is missing.
    let output = Command::new(cargo)
        .args(["metadata", "--locked", "--format-version", "1", "--manifest-path"])
        .arg(manifest_dir.join("Cargo.toml"))
        .output()
        .map_err(|error| Failure::new(format!("cannot run cargo metadata: {error}")))?;
    if !output.status.success() {
        let text = String::from_utf8_lossy(&output.stderr);
        return Err(Failure::new(format!("cargo metadata failed: {}", text.trim())));
    }
    let json = String::from_utf8_lossy(&output.stdout);
    json.split("\"manifest_path\":\"")
        .skip(1)
        .filter_map(|rest| rest.split('"').next())
        .map(|path| PathBuf::from(path.replace("\\\\", "\\")))
        .filter_map(|path| path.parent().map(Path::to_path_buf))
        .find(|dir| dir.file_name().is_some_and(|name| name.to_string_lossy().starts_with(SOURCES)))
        .map(|dir| dir.join("OpenSubdiv"))
        .filter(|dir| dir.is_dir())
        .ok_or_else(|| Failure::new(format!("the sources of {SOURCES} are not where cargo says")))
}
