//! Checks that the minimal headers match the libraries of a wheel, before anything is built for it.
//!
//! A probe is compiled from the headers, and its tables are compared with those of the wheel. Libraries do not show the
//! pure slots of `PcpDynamicFileFormatInterface`, the size of `VtValue` and the offset of an error's text. A trial run
//! of the plugin tests these.

mod layout;
mod member;
mod vtables;

use std::fmt;
use std::path::Path;

use super::build::{self, Target};
use super::elf::Elf;
use super::wheel::Wheel;
use crate::process::{self, Failure, Outcome};
use crate::project::Project;

/// A difference between the headers and the wheel.
#[derive(Debug, PartialEq)]
pub struct Mismatch {
    class: String,
    place: String,
    declared: String,
    found: String,
}

impl fmt::Display for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { class, place, declared, found } = self;
        write!(f, "{class}, {place}: declared {declared}, found {found}")
    }
}

/// A wheel and the probe that was compiled for it.
struct Check<'a> {
    wheel: &'a Wheel,
    probe: &'a Elf,
    namespace: String,
}

/// Compares the headers with the wheel. `defines` are additional macros.
pub fn headers(project: &Project, wheel: &Wheel, target: &Target, defines: &[String]) -> Outcome {
    let probe = compile_probe(project, target, defines)?;
    let namespace = wheel.traits()?.namespace;
    let check = Check { wheel, probe: &probe, namespace };
    let mut mismatches = check.namespaces();
    // With a different namespace, no other symbol can match.
    if mismatches.is_empty() {
        mismatches = check.vtables();
        mismatches.extend(check.layout());
    }
    refuse(wheel, &mismatches)
}

/// Checks that the wheel exports all symbols that the built plugin uses, and that the plugin exports none.
pub fn library(wheel: &Wheel, library: &Path) -> Outcome {
    let plugin = Elf::read(library)?;
    let mut mismatches = Vec::new();
    let mut add = |place: &str, declared: String, found: &str| {
        mismatches.push(Mismatch { class: plugin.name.clone(), place: place.into(), declared, found: found.into() });
    };
    for symbol in plugin.undefined().filter(|symbol| symbol.contains("pxrInternal")) {
        if wheel.export(symbol).is_none() {
            add("symbol", symbol.to_owned(), "it is not exported");
        }
    }
    for name in plugin.needed.iter().filter(|name| name.starts_with("libusd_")) {
        if wheel.libraries.iter().all(|library| library.name != *name) {
            add("library", name.clone(), "the wheel has no such file");
        }
    }
    for symbol in plugin.exports() {
        add("exports", "nothing".into(), symbol);
    }
    refuse(wheel, &mismatches)
}

fn refuse(wheel: &Wheel, mismatches: &[Mismatch]) -> Outcome {
    if mismatches.is_empty() {
        return Ok(());
    }
    let lines: Vec<String> = mismatches.iter().map(|mismatch| format!("\n  {mismatch}")).collect();
    let message = format!("usd-core {} does not match usd_plugin/minimal:{}", wheel.version, lines.concat());
    Err(Failure::new(message)
        .hint("please report it; until then, build against the SDK of this version with --sdk, or use another version"))
}

fn compile_probe(project: &Project, target: &Target, defines: &[String]) -> Outcome<Elf> {
    let library = target.folder.join(format!("probe{}.so", defines.concat()));
    let mut compiler = project.command(build::compiler());
    compiler.args(["-std=c++17", "-shared", "-fPIC", "-O1", "-Wall", "-Wextra", "-Werror"]).arg(target.abi_flag());
    for folder in &target.includes {
        compiler.arg("-I").arg(folder);
    }
    compiler.args(defines.iter().map(|define| format!("-D{define}")));
    compiler.arg("usd_plugin/minimal/probe.cpp").arg("-o").arg(&library);
    process::run_quietly(&mut compiler)?;
    Elf::read(&library)
}

impl Check<'_> {
    /// Reports headers that were generated for another version.
    fn namespaces(&self) -> Vec<Mismatch> {
        let mut declared = self.probe.exports().filter_map(super::wheel::namespace);
        let declared = declared.next().unwrap_or_default();
        if declared == self.namespace {
            return Vec::new();
        }
        let found = self.namespace.clone();
        vec![Mismatch { class: "all classes".into(), place: "namespace".into(), declared, found }]
    }

    /// The namespace in mangled form.
    fn prefix(&self) -> String {
        format!("{}{}", self.namespace.len(), self.namespace)
    }

    /// A class of the namespace in mangled form. It may have one class as its template argument.
    fn mangled(&self, class: &str) -> String {
        let identifier = |name: &str| format!("{}{name}", name.len());
        match class.trim_end_matches('>').split_once('<') {
            Some((template, argument)) => {
                format!("{}{}INS_{}EE", self.prefix(), identifier(template), identifier(argument))
            }
            None => self.prefix() + &identifier(class),
        }
    }
}
