//! `usdtailor build`.

use super::report;
use super::{Build, Opened, Output, text};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use tailor::error::{Error, Warnings};
use tailor::pipeline::{Limits, Products, Stage};
use tailor::usd::{Product, ProductRole, WriteOptions, check_target, write};

/// What one input gave.
pub struct Built {
    pub input: PathBuf,
    pub output: PathBuf,
    pub products: Products,
    pub warnings: Warnings,
}

/// Builds every input. Of several, one that fails does not keep the others from being built.
pub fn run(build: &Build) -> Result<Output, Error> {
    let files = build.inputs.files()?;
    let outputs = outputs(build, &files)?;
    if let Some(file) = &build.report {
        report::check_target(file, build.force)?;
    }
    let several = files.len() > 1;
    let mut all = Vec::with_capacity(files.len());
    let mut code = 0;
    for (input, output) in files.into_iter().zip(outputs) {
        match build_one(build, &input, output) {
            Ok(built) => {
                text::print_warnings(&built.warnings, build.inputs.quiet, several.then_some(&input));
                all.push(built);
            }
            Err(error) if several => {
                text::print_error(&error, &input);
                code = code.max(error.exit_code());
            }
            Err(error) => return Err(error),
        }
    }
    if let Some(file) = &build.report {
        report::write(file, &all)?;
    }
    let summaries = all.iter().filter(|_| !build.inputs.quiet);
    let text = summaries.map(|b| text::summary(&b.input, &b.output, &b.products, build.inputs.verbose)).collect();
    Ok(Output { text, code })
}

/// The output of each input: the file that was named, or one in the folder that was named.
fn outputs(build: &Build, files: &[PathBuf]) -> Result<Vec<PathBuf>, Error> {
    let out = &build.output;
    if files.len() == 1 && !out.is_dir() {
        return Ok(vec![out.clone()]);
    }
    if !out.is_dir() {
        return Err(Error::Usage(format!(
            "-o {} is no folder, but there are {} inputs\n  hint: make the folder first, or build one input at a time",
            out.display(),
            files.len()
        )));
    }
    let mut paths: Vec<PathBuf> = Vec::with_capacity(files.len());
    for file in files {
        let stem = file.file_stem().unwrap_or_default().to_string_lossy();
        let path = out.join(format!("{stem}_tailored.usda"));
        if paths.contains(&path) {
            return Err(Error::Usage(format!(
                "two inputs are called {stem}\n  hint: build them into folders of their own"
            )));
        }
        paths.push(path);
    }
    Ok(paths)
}

fn build_one(build: &Build, input: &Path, output: PathBuf) -> Result<Built, Error> {
    let bar = spinner(build.inputs.quiet);
    let progress = |stage: &str| bar.set_message(format!("{}: {stage}", input.display()));
    progress("read");
    let start = Instant::now();
    let mut opened = build.inputs.open(input)?;
    check_target(&opened.source, &output, build.force)?;
    let read = Stage { name: "read", seconds: start.elapsed().as_secs_f64() };
    let start = Instant::now();
    progress("check");
    let prepared = opened.prepare()?;
    let check = Stage { name: "check", seconds: start.elapsed().as_secs_f64() };
    let Opened { source, mut warnings, .. } = opened;
    let limits = Limits { max_faces: build.max_faces, progress: &progress };
    let mut products = prepared.build(&limits, &mut warnings)?;
    progress("write");
    let start = Instant::now();
    let meshes = [
        Product { name: &build.sim_name, role: ProductRole::Sim, mesh: &products.sim },
        Product { name: &build.render_name, role: ProductRole::Render, mesh: &products.render },
    ];
    let options = WriteOptions { flatten: build.flatten, force: build.force, model_guide: !build.keep_model_purpose };
    write(&source, &meshes, &output, &options, &mut warnings)?;
    products.stages.push(Stage { name: "write", seconds: start.elapsed().as_secs_f64() });
    products.stages.splice(0..0, [read, check]);
    bar.finish_and_clear();
    Ok(Built { input: input.to_path_buf(), output, products, warnings })
}

/// Progress, on a terminal only.
fn spinner(quiet: bool) -> ProgressBar {
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new_spinner().with_style(ProgressStyle::default_spinner());
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}
