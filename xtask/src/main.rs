//! Development tasks, run as `cargo xtask <task>`. The alias `cargo usdtailor` is the task `run`, by `start.rs`.

mod api;
mod apt;
mod blender;
mod browser;
mod cargo;
mod exec;
mod garments;
mod golden;
mod links;
mod node;
mod options;
mod package;
mod page;
mod peers;
mod plugin;
mod process;
mod project;
mod prose;
mod python;
mod run;
mod site;
mod speed;
mod test;
mod text;
mod venv;

use std::process::ExitCode;

use cargo::Profile;
use process::{Failure, Outcome};
use project::Project;

const HELP: &str = "\
Tasks of this project.

Usage: cargo xtask <TASK>

Tasks:
  run [ARGS...]                Make the page of `usdtailor preview` where it is missing, build the program, and run it
  test [OPTIONS] [STEP...] [-- ARGS...]
                               Run the named steps and their prerequisites, or all steps (see below)
  page                         Bundle the page of `usdtailor preview`, which the next build of the program embeds
  protocol                     Write src/preview/page/src/server/protocol.ts, the messages of the preview that the step
                               `rust` compares
  api                          Write docs/api.txt, the public API that the step `docs` compares
  options                      Write schemas/ and the tables of docs/options.md from the table of options, which the step
                               `options` compares
  speed                        Count the instructions of two builds, which the step `speed` compares
  site                         Check the documents, and draw them as a site in target/site
  examples [ARGS...]           Write the garments in examples/ (examples/make_garments.py)
  picture [NAME...] [--before OLD]
                               Draw the meshes in examples/*.png and docs/, and the preview to docs/preview/*.jpg; with
                               arguments, the named meshes, or those that an older program is compared with
  golden [ARGS...]             Write the OpenSubdiv reference data of the subdivision tests (needs cmake and C++)
  plugin [OPTIONS]             Build the OpenUSD plugin into target/usd_plugin (see below)
  wheel [--tested]             Build the Python package into target/wheels, for all versions of usd-core or those that the
                               tests use
  blender [--tested]           Build the extension for Blender into target/blender, with the package of `wheel`
  preview-bench [--quick]      Time edits in the preview, and its memory over 10,000 edits unless --quick is given
  peers                        Compare time and quality with other remeshers
  venv                         Create the Python environment target/venv, which the other tasks use

Options:
  -h, --help                   Print this help

Options of test:
  --all                        Run the long tests too: all wheels of usd-core and versions of Blender, long attacks and fuzz
                               replays, all files of browser tests
  --alone                      Run the named steps without their prerequisites
  --install                    Let apt-get install Chromium and Valgrind for the whole system where they are missing
  --folder FOLDER              Run the step `garments` too, on the stages of this folder
  --bodies FOLDER              Fit these garments to bodies: base.usdc of this folder is the one that they are made for

Options of plugin:
  --python PYTHON              Build for the usd-core wheel of this interpreter [default: that of target/venv]
  --sdk DIR                    Build for the OpenUSD SDK in DIR [default: PXR_ROOT or OPENUSD_ROOT, if set]
  --out DIR                    Folder of the plugin [default: target/usd_plugin]

Arguments after -- go to `cargo test` with the single step `rust`, to pytest with the single steps `python`,
`package`, `newton` and `blender`, and to `node --test` with the single step `browser`:
  cargo xtask test python -- -k schemas

The environment variable PYTHON names the interpreter for target/venv [default: python3], CHROMIUM the browser
[default: one on the path, else one is installed].
";

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    match run(&args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("\n{failure}");
            ExitCode::FAILURE
        }
    }
}

fn run(args: &[String]) -> Outcome {
    let (task, rest) = match args.split_first() {
        Some((task, rest)) => (task.as_str(), rest),
        None => return Err(Failure::new("no task given").hint("cargo xtask --help lists them")),
    };
    if task == "run" {
        return run::run(&Project::find()?, rest);
    }
    if matches!(task, "-h" | "--help" | "help") || rest.first().is_some_and(|arg| arg == "-h" || arg == "--help") {
        print!("{HELP}\n{}", test::help());
        return Ok(());
    }
    let project = Project::find()?;
    match task {
        "test" => test::test(&project, rest),
        "api" if rest.is_empty() => cargo::docs(&project, false).and_then(|()| api::write(&project)),
        "options" if rest.is_empty() => built(&project, Profile::Tested).and_then(|()| options::write(&project)),
        "site" if rest.is_empty() => site::build(&project),
        "speed" if rest.is_empty() => built(&project, Profile::Tested).and_then(|()| speed::write(&project)),
        "examples" => examples(&project, rest),
        "page" if rest.is_empty() => page::build(&project),
        "protocol" if rest.is_empty() => cargo::protocol(&project),
        "preview-bench" => built(&project, Profile::Release).and_then(|()| browser::figures(&project, rest)),
        "picture" => picture(&project, rest),
        "plugin" => plugin::run(&project, rest),
        "wheel" => package::run(&project, rest),
        "blender" => blender::run(&project, rest),
        "golden" => golden::run(&project, rest),
        "venv" if rest.is_empty() => venv::ensure(&project).map(|_| ()),
        "peers" if rest.is_empty() => peers::run(&project),
        "api" | "page" | "options" | "peers" | "protocol" | "site" | "speed" | "venv" => Err(unexpected(task, rest)),
        _ => Err(Failure::new(format!("no task `{task}`")).hint("cargo xtask --help lists them")),
    }
}

fn unexpected(task: &str, args: &[String]) -> Failure {
    Failure::new(format!("`{task}` does not take `{}`", args.join(" "))).hint("cargo xtask --help lists the tasks")
}

/// Builds the program with its page.
fn built(project: &Project, profile: Profile) -> Outcome {
    page::build(project).and_then(|()| cargo::build(project, profile))
}

fn examples(project: &Project, args: &[String]) -> Outcome {
    let python = venv::ensure(project)?;
    process::run(project.command(python).arg("examples/make_garments.py").args(args))
}

/// Draws meshes that the program builds, and the page of its preview. `--before OLD` compares with an older program too.
fn picture(project: &Project, args: &[String]) -> Outcome {
    let python = venv::ensure(project)?;
    built(project, Profile::Release)?;
    let mut script = project.command(python);
    process::run(script.arg("docs/looks/pictures.py").arg(Profile::Release.program(project)).args(args))?;
    if args.is_empty() { browser::pictures(project) } else { Ok(()) }
}
