//! Finds the libraries of an installed usd-core wheel, and how they were built.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::elf::{Elf, Export};
use crate::process::{Failure, Outcome};
use crate::project::Project;

/// The modules that the plugin uses. Since 25.8, the library `ms` holds all of them.
const MODULES: [&str; 7] = ["ar", "ms", "pcp", "sdf", "tf", "usd", "vt"];

/// The oldest version that the minimal headers support. Each build compares them with its own version.
const OLDEST: (u32, u32) = (24, 8);

const LOCATE: &str = "
import importlib.metadata
wheel = importlib.metadata.distribution('usd-core')
print(wheel.version)
print(wheel.locate_file('usd_core.libs').resolve())
";

/// The libraries of a wheel.
pub struct Wheel {
    /// The version in pip's form, such as `26.11`.
    pub version: String,
    pub folder: PathBuf,
    pub libraries: Vec<Elf>,
}

/// The build settings of a wheel that a plugin must share.
pub struct Traits {
    /// OpenUSD's internal namespace, which includes the version.
    pub namespace: String,
    /// `_GLIBCXX_USE_CXX11_ABI`.
    pub cxx11_abi: bool,
    /// `true` if `TfType::SetFactory` takes its pointer by value.
    pub set_factory_by_value: bool,
}

impl Wheel {
    pub fn find(project: &Project, python: &Path) -> Outcome<Self> {
        if !cfg!(all(target_os = "linux", target_arch = "x86_64")) {
            return Err(Failure::new("plugins are built against usd-core wheels on x86-64 Linux only")
                .hint("build against an OpenUSD SDK: cargo xtask plugin --sdk DIR, or PXR_ROOT"));
        }
        let (version, folder) = locate(project.command(python).args(["-c", LOCATE]), python)?;
        if numbers(&version).is_none_or(|version| version < OLDEST) {
            return Err(Failure::new(format!("usd-core {version} is older than {}.{}", OLDEST.0, OLDEST.1))
                .hint("install a later one, or build against its SDK with --sdk"));
        }
        let libraries = libraries(&folder)?;
        Ok(Self { version, folder, libraries })
    }

    /// The library that exports a symbol.
    pub fn export(&self, name: &str) -> Option<(&Elf, Export)> {
        self.libraries.iter().find_map(|library| Some((library, library.export(name)?)))
    }

    pub fn exports(&self) -> impl Iterator<Item = &str> {
        self.libraries.iter().flat_map(Elf::exports)
    }

    /// The build settings, read from the exported symbols.
    pub fn traits(&self) -> Outcome<Traits> {
        let unknown = |what: &str| {
            Failure::new(format!("usd-core {} differs from all known wheels: {what}", self.version))
                .hint("please report it; meanwhile build against its SDK with --sdk")
        };
        let namespace = self.exports().find_map(namespace).ok_or_else(|| unknown("it has no internal namespace"))?;
        let set_factory = self.exports().find(|name| name.contains("6TfType10SetFactory"));
        let set_factory = set_factory.ok_or_else(|| unknown("TfType::SetFactory is not exported"))?;
        let tokens = format!("_ZN{}{namespace}7TfTokenC1ERK", namespace.len());
        let takes = |text: &str| self.exports().any(|name| name == format!("{tokens}{text}"));
        let cxx11_abi = takes("NSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEE");
        if !cxx11_abi && !takes("Ss") {
            return Err(unknown("TfToken has an unknown string type"));
        }
        Ok(Traits { namespace, cxx11_abi, set_factory_by_value: !set_factory.contains("EOSt10unique_ptr") })
    }
}

/// Year and month of a version.
pub fn numbers(version: &str) -> Option<(u32, u32)> {
    let mut parts = version.split('.').map(|part| part.parse().ok());
    Some((parts.next()??, parts.next()??))
}

fn locate(command: &mut Command, python: &Path) -> Outcome<(String, PathBuf)> {
    let output = command.output().map_err(|error| {
        Failure::new(format!("cannot run {}: {error}", python.display())).hint("name an interpreter with --python")
    })?;
    let text = String::from_utf8_lossy(&output.stdout);
    match text.lines().collect::<Vec<_>>()[..] {
        [version, folder] if Path::new(folder).is_dir() => Ok((version.to_owned(), folder.into())),
        [version, folder] => Err(Failure::new(format!("usd-core {version} has no libraries in {folder}"))
            .hint("install the wheel with pip, or build against an SDK with --sdk")),
        _ => Err(Failure::new(format!("{} has no usd-core", python.display()))
            .hint("pip install usd-core there, or name another interpreter with --python")),
    }
}

fn libraries(folder: &Path) -> Outcome<Vec<Elf>> {
    let entries =
        fs::read_dir(folder).map_err(|error| Failure::new(format!("cannot read {}: {error}", folder.display())))?;
    let mut paths: Vec<PathBuf> =
        entries.filter_map(|entry| Some(entry.ok()?.path())).filter(|path| wanted(path)).collect();
    paths.sort();
    if paths.is_empty() {
        return Err(
            Failure::new(format!("{} has no OpenUSD libraries", folder.display())).hint("install the wheel again")
        );
    }
    paths.iter().map(|path| Elf::read(path)).collect()
}

/// `true` for a library of [`MODULES`]; its file name has a hash, as in `libusd_sdf-1a2b3c4d.so`.
fn wanted(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    MODULES.iter().any(|module| name.starts_with(&format!("libusd_{module}-")))
}

pub fn namespace(symbol: &str) -> Option<String> {
    const END: &str = "__pxrReserved__";
    let start = symbol.find("pxrInternal_v")?;
    let length = symbol[start..].find(END)? + END.len();
    Some(symbol[start..start + length].to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_namespace_is_inside_a_symbol() {
        let symbol = "_ZNK35pxrInternal_v0_26_11__pxrReserved__8SdfLayer7IsDirtyEv";
        assert_eq!(namespace(symbol).as_deref(), Some("pxrInternal_v0_26_11__pxrReserved__"));
        assert_eq!(namespace("_ZN3tbb4task"), None);
    }

    #[test]
    fn versions_compare_by_number() {
        assert!(numbers("24.11") > numbers("24.8"));
        assert_eq!(numbers("25.5.1"), Some((25, 5)));
        assert_eq!(numbers("main"), None);
    }

    #[test]
    fn only_the_modules_in_use_are_read() {
        assert!(wanted(Path::new("/x/libusd_sdf-12ab.so")));
        assert!(!wanted(Path::new("/x/libusd_sdfx-12ab.so")));
        assert!(!wanted(Path::new("/x/libtbb-12ab.so.2")));
    }
}
