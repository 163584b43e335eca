//! Finds the headers and libraries of an OpenUSD SDK, as installed by build_usd.py or included in Houdini.

use std::fs;
use std::path::{Path, PathBuf};

use super::build::{self, Target};
use super::elf::Elf;
use crate::process::{Failure, Outcome};
use crate::project::Project;

const VARIABLES: [&str; 2] = ["PXR_ROOT", "OPENUSD_ROOT"];
const INCLUDES: [&str; 2] = ["include", "toolkit/include"];
const LIBRARIES: [&str; 3] = ["lib", "lib64", "dsolib"];
/// Prefixes of library names: those of build_usd.py, of Houdini, and none.
const PREFIXES: [&str; 3] = ["usd_", "pxr_", ""];
const MODULES: [&str; 6] = ["usd", "pcp", "sdf", "ar", "vt", "tf"];
/// The library name, which OpenUSD's macros need.
const DEFINES: [&str; 3] =
    ["MFB_PACKAGE_NAME=usdTailor", "MFB_ALT_PACKAGE_NAME=usdTailor", "MFB_PACKAGE_MODULE=usdTailor"];
/// The oldest supported version, as PXR_VERSION.
const OLDEST: u32 = 2408;

/// The SDK that the environment names.
pub fn from_environment() -> Option<PathBuf> {
    VARIABLES.iter().filter_map(std::env::var_os).find(|value| !value.is_empty()).map(PathBuf::from)
}

impl Target {
    pub fn of_sdk(project: &Project, root: &Path) -> Outcome<Self> {
        let include = INCLUDES.iter().map(|name| root.join(name)).find(|folder| folder.join("pxr/pxr.h").is_file());
        let include = include.ok_or_else(|| missing(root, "headers", "include/pxr/pxr.h"))?;
        let version = version(&include).ok_or_else(|| missing(root, "version", "PXR_VERSION in include/pxr/pxr.h"))?;
        if version < OLDEST {
            return Err(Failure::new(format!("OpenUSD {version} in {} is older than {OLDEST}", root.display()))
                .hint("use a later one"));
        }
        let (folder, names) = libraries(root).ok_or_else(|| missing(root, "libraries", "lib/libusd_sdf.so"))?;
        let cxx11_abi = cxx11_abi(&folder, &names)?;
        let name = format!("sdk-{version}");
        Ok(Self {
            folder: build::generated(project, &name)?,
            name: format!("the SDK in {}", root.display()),
            includes: vec![include],
            defines: DEFINES.map(String::from).to_vec(),
            link: link(&folder, &names),
            cxx11_abi,
        })
    }
}

fn missing(root: &Path, what: &str, where_it_is: &str) -> Failure {
    Failure::new(format!("{} has no OpenUSD {what}, such as {where_it_is}", root.display()))
        .hint("set --sdk, PXR_ROOT or OPENUSD_ROOT to the folder where OpenUSD is installed (in Houdini, $HFS)")
}

fn version(include: &Path) -> Option<u32> {
    let text = fs::read_to_string(include.join("pxr/pxr.h")).ok()?;
    text.lines().find_map(|line| line.trim().strip_prefix("#define PXR_VERSION ")?.trim().parse().ok())
}

/// The folder of the libraries, and their linker names.
fn libraries(root: &Path) -> Option<(PathBuf, Vec<String>)> {
    let folders = LIBRARIES.iter().map(|name| root.join(name));
    folders.into_iter().find_map(|folder| {
        let there = |name: &String| file(&folder, name).is_file();
        let together = PREFIXES.iter().map(|prefix| vec![format!("{prefix}ms")]);
        let apart = PREFIXES.iter().map(|prefix| MODULES.map(|module| format!("{prefix}{module}")).to_vec());
        let names = together.chain(apart).find(|names| names.iter().all(there))?;
        Some((folder, names))
    })
}

fn file(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("lib{name}.so"))
}

/// `true` if the libraries use the C++11 string ABI.
fn cxx11_abi(folder: &Path, names: &[String]) -> Outcome<bool> {
    let Some(tf) = names.last() else { return Ok(true) };
    Ok(Elf::read(&file(folder, tf))?.exports().any(|symbol| symbol.contains("7TfTokenC1ERKNSt7__cxx11")))
}

fn link(folder: &Path, names: &[String]) -> Vec<String> {
    let mut link = vec![format!("-L{}", folder.display())];
    link.extend(names.iter().map(|name| format!("-l{name}")));
    // OpenUSD's headers use TBB inline.
    if file(folder, "tbb").is_file() {
        link.push("-ltbb".into());
    }
    // Report missing symbols at link time rather than when the plugin is loaded.
    link.push("-Wl,-z,defs".into());
    link
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An SDK without content in a folder of its own.
    fn sdk(name: &str, files: &[&str]) -> PathBuf {
        let root = std::env::temp_dir().join(format!("usdtailor-sdk-{name}-{}", std::process::id()));
        for path in files {
            let path = root.join(path);
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            fs::write(path, "#define PXR_MAJOR_VERSION 0\n#define PXR_VERSION 2511\n").expect("a file");
        }
        root
    }

    #[test]
    fn libraries_are_found_under_each_of_their_names() {
        for (name, prefix, folder) in [("pixar", "usd_", "lib"), ("houdini", "pxr_", "dsolib")] {
            let files = MODULES.map(|module| format!("{folder}/lib{prefix}{module}.so"));
            let root = sdk(name, &files.each_ref().map(String::as_str));
            let (found, names) = libraries(&root).expect("libraries");
            assert_eq!(found, root.join(folder));
            assert_eq!(names[0], format!("{prefix}usd"));
            fs::remove_dir_all(root).expect("to remove it");
        }
    }

    #[test]
    fn one_library_for_all_is_preferred_and_a_part_is_not_enough() {
        let root = sdk("one", &["lib/libusd_ms.so", "lib/libusd_tf.so", "include/pxr/pxr.h"]);
        assert_eq!(libraries(&root).expect("libraries").1, ["usd_ms"]);
        assert_eq!(version(&root.join("include")), Some(2511));
        fs::remove_dir_all(root).expect("to remove it");
        let root = sdk("part", &["lib/libusd_tf.so"]);
        assert_eq!(libraries(&root), None);
        fs::remove_dir_all(root).expect("to remove it");
    }
}
