//! The native files of the package that do not depend on a version of OpenUSD: the core and the launcher.
//!
//! Zig links them for the oldest glibc of the package's platform. The Rust code is compiled once for them and the program.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::cargo::{self, Profile};
use crate::plugin::elf::Elf;
use crate::process::{self, Failure, Outcome};
use crate::project::Project;

const CORE: &str = "libusdtailor_core.so";
const TARGET: &str = "x86_64-linux-gnu.2.28";

/// The newest versions of system libraries that the platform has: its glibc, and the C++ library of GCC 8.
const FLOOR: [(&str, [u32; 3]); 3] = [("GLIBC_", [2, 28, 0]), ("GLIBCXX_", [3, 4, 24]), ("CXXABI_", [1, 3, 11])];

/// Builds the core and its launcher into a folder, and returns the path of the core.
pub fn core(project: &Project, profile: Profile, linker: &Path, folder: &Path) -> Outcome<PathBuf> {
    fs::create_dir_all(folder).map_err(|error| Failure::new(format!("cannot create {}: {error}", folder.display())))?;
    let no_streams = linker.with_file_name("no_streams.o");
    let mut compiler: Command = project.command(linker);
    process::run_quietly(compiler.args(["-c", "-fPIC", "usd_plugin/no_streams.c", "-o"]).arg(&no_streams))?;
    let mut cargo = cargo::cargo(project, "rustc");
    cargo.args(["--package", "tailor-usd-plugin", "--lib", "--crate-type", "cdylib", "--features", "core"]);
    cargo.args(profile.flags()).arg("--");
    cargo.arg("-C").arg(format!("linker={}", linker.display()));
    cargo.arg("-C").arg(format!("link-arg={}", no_streams.display()));
    process::run(cargo.args(["-C", "strip=symbols", "-C", &format!("link-arg=-Wl,-soname,{CORE}")]))?;
    let core = folder.join(CORE);
    let built = profile.built(project, "libtailor_usd_plugin.so");
    fs::copy(&built, &core).map_err(|error| Failure::new(format!("cannot copy {}: {error}", built.display())))?;

    let mut compiler = project.command(linker);
    compiler.args(["-O2", "-Wall", "-Werror", "-s", "usd_plugin/launcher.c", "-o"]).arg(folder.join("usdtailor"));
    compiler.arg("-L").arg(folder).args(["-lusdtailor_core", "-Wl,-rpath,$ORIGIN"]);
    process::run_quietly(&mut compiler)?;
    Ok(core)
}

/// The system that the files of a package are linked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum System {
    /// This one, with its own compiler: for tests.
    This,
    /// The oldest of the package's platform.
    Oldest,
}

impl System {
    /// That of the test step, with all tests or without.
    pub fn of_test(all: bool) -> Self {
        if all { Self::Oldest } else { Self::This }
    }
}

/// A script that compiles and links. Rust's `-C linker` takes one path and no arguments.
pub fn linker(project: &Project, system: System, tools: &Path) -> Outcome<PathBuf> {
    let folder = project.scratch("linker")?;
    let script = folder.join("cc");
    let zigbuild = tools.with_file_name("cargo-zigbuild");
    let command = match system {
        System::This => "exec cc".to_owned(),
        System::Oldest => format!(
            "CARGO_ZIGBUILD_PYTHON_PATH='{}' exec '{}' zig cc -- -target {TARGET}",
            tools.display(),
            zigbuild.display()
        ),
    };
    let text = format!("#!/bin/sh\n{command} \"$@\"\n");
    let write = || {
        fs::write(&script, text)?;
        #[cfg(unix)]
        fs::set_permissions(&script, std::os::unix::fs::PermissionsExt::from_mode(0o755))?;
        Ok(())
    };
    write().map_err(|error: std::io::Error| Failure::new(format!("cannot write {}: {error}", script.display())))?;
    Ok(script)
}

/// Refuses libraries that need a newer system than the package's platform.
pub fn check_floor(folder: &Path) -> Outcome {
    for path in native_files(folder)? {
        let elf = Elf::read(&path)?;
        for version in elf.versions() {
            let newer = FLOOR.iter().find_map(|(prefix, most)| Some(numbers(version.strip_prefix(prefix)?) > *most));
            if newer == Some(true) {
                return Err(Failure::new(format!("{} needs {version}, which the platform lacks", path.display()))
                    .hint("avoid the function, or define it in usd_plugin/floor.cpp"));
            }
        }
    }
    Ok(())
}

fn numbers(version: &str) -> [u32; 3] {
    let mut parts = version.split('.').map(|part| part.parse().unwrap_or(u32::MAX));
    std::array::from_fn(|_| parts.next().unwrap_or(0))
}

fn native_files(folder: &Path) -> Outcome<Vec<PathBuf>> {
    let fault = |error| Failure::new(format!("cannot read {}: {error}", folder.display()));
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(fault)? {
        let path = entry.map_err(fault)?.path();
        if path.is_dir() {
            found.extend(native_files(&path)?);
        } else if fs::read(&path).map_err(fault)?.starts_with(b"\x7fELF") {
            found.push(path);
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_compare_by_number() {
        assert!(numbers("2.9") < numbers("2.28"));
        assert!(numbers("3.4.26") > numbers("3.4.24"));
        assert_eq!(numbers("1.3"), [1, 3, 0]);
        assert!(numbers("PRIVATE") > numbers("2.28"));
    }
}
