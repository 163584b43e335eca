//! Compiles the C++ of the file format and links it into the library, when `cargo xtask plugin` asks for it.
//!
//! With the feature `core` only the C++ side of the bridge is written. Without either (`cargo test`, `cargo clippy`,
//! `cargo doc`) nothing is compiled: the Rust side needs no OpenUSD.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::{env, fs};

/// Names a file of `key=value` lines that `cargo xtask plugin` writes: `include`, `define` and `link`.
const BUILD: &str = "USDTAILOR_PLUGIN_BUILD";

/// The C++ sources; the headers beside them are watched too.
const SOURCES: [&str; 6] =
    ["arguments.cpp", "errors.cpp", "fileFormat.cpp", "scratch.cpp", "source.cpp", "sourceLayers.cpp"];

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed={BUILD}");
    if env::var_os("CARGO_FEATURE_CORE").is_some() {
        // The C++ that calls the core; `cargo xtask wheel` compiles it for each version of OpenUSD.
        drop(cxx_build::bridge("src/lib.rs"));
        // It links an object that is made of this.
        println!("cargo:rerun-if-changed=no_streams.c");
        return;
    }
    let Some(file) = env::var_os(BUILD).map(PathBuf::from) else { return };
    println!("cargo:rerun-if-changed={}", file.display());
    let text = fs::read_to_string(&file).unwrap_or_else(|e| panic!("{BUILD} names {}: {e}", file.display()));
    let settings: Vec<(&str, &str)> = text.lines().filter_map(|line| line.split_once('=')).collect();
    let all = |key: &'static str| settings.iter().filter(move |(k, _)| *k == key).map(|(_, value)| *value);
    compile(all("include").map(Path::new), all("define"));
    link(all("link"));
}

fn compile<'a>(includes: impl Iterator<Item = &'a Path>, defines: impl Iterator<Item = &'a str>) {
    let mut build = cxx_build::bridge("src/lib.rs");
    build.std("c++17").flag("-fvisibility=hidden").flag("-fvisibility-inlines-hidden");
    build.warnings(true).extra_warnings(true).warnings_into_errors(true);
    // What OpenUSD's headers warn of is not ours to mend; that they use ext/hash_set is reported wherever they are.
    build.flag("-Wno-deprecated");
    includes.for_each(|folder| {
        build.flag("-isystem").flag(folder);
    });
    defines.for_each(|define| {
        let (name, value) = define.split_once('=').unwrap_or((define, "1"));
        build.define(name, value);
    });
    for source in SOURCES {
        println!("cargo:rerun-if-changed={source}");
        println!("cargo:rerun-if-changed={}", source.replace(".cpp", ".h"));
        build.file(source);
    }
    println!("cargo:rerun-if-changed=minimal");
    build.file(hidden_names());
    // Linked below, whole: nothing in Rust refers to it.
    build.cargo_metadata(false).compile("tailor_usd_plugin_cpp");
}

/// An assembler file that hides the Rust functions which only our own C++ calls; a library in Rust exports them all.
fn hidden_names() -> PathBuf {
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    let glue = out.join("cxxbridge/sources/tailor-usd-plugin/src/lib.rs.cc");
    let text = fs::read_to_string(&glue).unwrap_or_else(|e| panic!("{}: {e}", glue.display()));
    let words = text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_' || c == '$'));
    let names: BTreeSet<&str> = words.filter(|word| word.contains("cxxbridge1$")).collect();
    let lines: Vec<String> = names.iter().map(|name| format!(".hidden {name}\n")).collect();
    let file = out.join("hidden.S");
    let note = ".section .note.GNU-stack,\"\",@progbits\n";
    fs::write(&file, lines.concat() + note).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    file
}

fn link<'a>(arguments: impl Iterator<Item = &'a str>) {
    let out = env::var("OUT_DIR").expect("cargo sets OUT_DIR");
    let argument = |text: &str| println!("cargo:rustc-cdylib-link-arg={text}");
    argument(&format!("-Wl,--whole-archive,{out}/libtailor_usd_plugin_cpp.a,--no-whole-archive"));
    arguments.for_each(argument);
    argument("-lstdc++");
    // Line tables are nine tenths of the library, and nobody steps through it where it is used.
    argument("-Wl,--strip-debug");
    // Other plugins made with cxx are loaded into the same process; none shall take our functions, nor we theirs.
    argument("-Wl,--exclude-libs,ALL,-Bsymbolic");
}
