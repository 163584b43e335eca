//! Creates the Python environments of the tests: `target/venv` with usd-core, numpy and pytest, and one per older
//! wheel. One environment has pip and installs into all others, as making pip itself takes longer than most installations.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::process::{self, Failure, Outcome};
use crate::project::Project;

const REQUIREMENTS: &str = "tests/usd/requirements.txt";
const SITE: &str = "xtask/site/requirements.txt";
const PACKAGING: &str = "python/requirements.txt";
const NEWTON: &str = "tests/newton/requirements.txt";
const PACKAGE: &str = "tests/wheel/requirements.txt";
const BLENDER: &str = "tests/blender/requirements.txt";
/// The start of the lines of [`BLENDER`] that pin a version of Blender.
const BPY: &str = "bpy==";

/// Creates `target/venv`, or recreates it if its requirements have changed, and returns its interpreter.
pub fn ensure(project: &Project) -> Outcome<PathBuf> {
    let wanted = project.read(REQUIREMENTS)?;
    ensure_with(project, "venv", &wanted, &["--requirement", REQUIREMENTS])
}

/// Like [`ensure`], for the solver that the tests of cloth run.
pub fn ensure_newton(project: &Project) -> Outcome<PathBuf> {
    let wanted = project.read(NEWTON)?;
    ensure_with(project, "venv-newton", &wanted, &["--requirement", NEWTON])
}

/// Like [`ensure`], for the program that draws the documents.
pub fn ensure_site(project: &Project) -> Outcome<PathBuf> {
    let wanted = project.read(SITE)?;
    ensure_with(project, "venv-site", &wanted, &["--requirement", SITE])
}

/// Like [`ensure`], for the programs that make the Python package: all of them, or that which packs it.
pub fn ensure_packaging(project: &Project, links: bool) -> Outcome<PathBuf> {
    let wanted = project.read(PACKAGING)?;
    if links {
        return ensure_with(project, "venv-packaging", &wanted, &["--requirement", PACKAGING]);
    }
    let packer = wanted.lines().find(|line| line.starts_with("hatchling"));
    let packer = packer.ok_or_else(|| Failure::new(format!("{PACKAGING} names no hatchling")))?;
    ensure_package(project, "venv-packing", packer)
}

/// Like [`ensure`], for the tests of the Python package.
pub fn ensure_package_tests(project: &Project) -> Outcome<PathBuf> {
    let wanted = project.read(PACKAGE)?;
    ensure_with(project, "venv-package", &wanted, &["--requirement", PACKAGE])
}

/// The environment of [`ensure_package_tests`], with the Python package.
pub fn with_package(project: &Project, wheel: &Path) -> Outcome<PathBuf> {
    let python = ensure_package_tests(project)?;
    process::run(pip(project, &python, "install")?.args(["--no-index", "--no-deps", "--force-reinstall"]).arg(wheel))?;
    Ok(python)
}

/// A version of Blender that the tests run.
pub struct Blender {
    pub version: String,
    /// The version of Python that it has a package for.
    python: String,
}

/// The pinned versions of Blender.
pub fn blenders(project: &Project) -> Outcome<Vec<Blender>> {
    let wanted = project.read(BLENDER)?;
    wanted.lines().filter(|line| line.starts_with(BPY)).map(blender).collect()
}

fn blender(line: &str) -> Outcome<Blender> {
    let parse = || {
        let (version, python) = line.strip_prefix(BPY)?.split_once("; python_version == \"")?;
        Some(Blender { version: version.to_owned(), python: python.strip_suffix('"')?.to_owned() })
    };
    parse().ok_or_else(|| Failure::new(format!("{BLENDER}: `{line}` pins no version for one version of Python")))
}

/// Like [`ensure`], for a version of Blender. Its package of about 400 MB is kept when the environment is made again.
pub fn ensure_blender(project: &Project, blender: &Blender) -> Outcome<PathBuf> {
    let version = &blender.version;
    let base = python_of(project, &blender.python)?;
    let text = project.read(BLENDER)?;
    let others: Vec<&str> = text.lines().filter(|line| !line.starts_with('#') && !line.starts_with(BPY)).collect();
    let wheels = project.target.join("blender/wheels");
    let wanted = format!("{BPY}{version}\n{}\n", others.join("\n"));
    ensure_by(project, &format!("blender/venv-{version}"), &wanted, &base, |python| {
        let wheel = match downloaded(&wheels, version) {
            Some(wheel) => wheel,
            None => {
                eprintln!("downloading bpy {version}");
                let mut command = pip(project, python, "download")?;
                command.args(["--no-deps", "--only-binary", ":all:", "--dest"]).arg(&wheels);
                process::run(command.arg(format!("{BPY}{version}")))?;
                downloaded(&wheels, version).ok_or_else(|| Failure::new("pip downloaded no bpy"))?
            }
        };
        eprintln!("installing bpy {version}");
        process::run(pip(project, python, "install")?.args(&others).arg(wheel))
    })
}

fn downloaded(folder: &Path, version: &str) -> Option<PathBuf> {
    let start = format!("bpy-{version}-");
    let mut files = fs::read_dir(folder).ok()?.filter_map(|entry| Some(entry.ok()?.path()));
    files.find(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(&start)))
}

/// An interpreter of a version of Python, such as 3.11.
fn python_of(project: &Project, version: &str) -> Outcome<String> {
    let usual = [format!("python{version}"), "python3".to_owned(), "python".to_owned()];
    let is_right = |python: &String| {
        let printed =
            project.command(python).args(["-c", "import sys; print(*sys.version_info[:2], sep='.')"]).output();
        printed.is_ok_and(|output| output.stdout.trim_ascii() == version.as_bytes())
    };
    std::env::var("PYTHON").into_iter().chain(usual).find(is_right).ok_or_else(|| {
        Failure::new(format!("it needs Python {version}, which is not on the path"))
            .hint(format!("install Python {version} with its venv module, or name it in PYTHON"))
    })
}

/// Like [`ensure`], for an environment with only one version of usd-core.
pub fn ensure_wheel(project: &Project, version: &str) -> Outcome<PathBuf> {
    ensure_package(project, &format!("venv-{version}"), &format!("usd-core=={version}"))
}

/// Like [`ensure`], for an environment `name` with only one package.
pub fn ensure_package(project: &Project, name: &str, package: &str) -> Outcome<PathBuf> {
    ensure_with(project, name, package, &["--only-binary", ":all:", package])
}

fn ensure_with(project: &Project, name: &str, wanted: &str, what: &[&str]) -> Outcome<PathBuf> {
    ensure_by(project, name, wanted, &base(), |python| {
        eprintln!("installing {}", what.last().unwrap_or(&name));
        process::run(pip(project, python, "install")?.args(what))
    })
}

/// Creates the environment `name` with the interpreter `base`, unless it has what is wanted.
fn ensure_by(
    project: &Project,
    name: &str,
    wanted: &str,
    base: &str,
    install: impl FnOnce(&Path) -> Outcome,
) -> Outcome<PathBuf> {
    let folder = project.target.join(name);
    let python = interpreter(&folder);
    // Written last, so that an interrupted installation is repeated.
    let installed = folder.join("installed-requirements.txt");
    if python.exists() && fs::read_to_string(&installed).is_ok_and(|text| text == wanted) {
        return Ok(python);
    }
    create(project, &folder, base, &["--without-pip"])?;
    install(&python)?;
    fs::write(&installed, wanted)
        .map_err(|error| Failure::new(format!("cannot write {}: {error}", installed.display())))?;
    Ok(python)
}

/// A command of pip, such as `install`, for the environment of an interpreter.
fn pip(project: &Project, python: &Path, name: &str) -> Outcome<Command> {
    let folder = project.target.join("venv-pip");
    let own = interpreter(&folder);
    // Made last of that environment.
    if !folder.join("bin/pip").exists() && !folder.join("Scripts/pip.exe").exists() {
        create(project, &folder, &base(), &[])?;
    }
    let mut command = project.command(own);
    command.args(["-m", "pip", "--python"]).arg(python);
    command.args([name, "--quiet", "--disable-pip-version-check"]);
    Ok(command)
}

/// The interpreter of environments that need no other.
fn base() -> String {
    std::env::var("PYTHON").unwrap_or_else(|_| "python3".into())
}

fn create(project: &Project, folder: &Path, base: &str, options: &[&str]) -> Outcome {
    if folder.is_symlink() {
        return Err(
            Failure::new(format!("{} is a link, and would be emptied", folder.display())).hint("remove the link")
        );
    }
    eprintln!("creating {}", folder.display());
    process::run(project.command(base).args(["-m", "venv", "--clear"]).args(options).arg(folder)).map_err(|failure| {
        failure.hint("install Python 3.10 or later with its venv module (Debian and Ubuntu: apt install python3-venv), or name an interpreter in PYTHON")
    })
}

fn interpreter(folder: &Path) -> PathBuf {
    if cfg!(windows) { folder.join("Scripts/python.exe") } else { folder.join("bin/python") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_version_of_blender_names_its_python() {
        let found = blender("bpy==5.0.1; python_version == \"3.11\"").unwrap();
        assert_eq!([found.version, found.python], ["5.0.1", "3.11"]);
        assert!(blender("bpy==5.0.1").is_err());
    }
}
