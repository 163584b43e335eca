//! `usdtailor build`.

use super::{Build, Output, report, text, usage};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use tailor::error::{Error, Warnings};
use tailor::report::{RenderFigures, SimFigures};
use tailor::session::written;
use tailor::usd::{WriteOptions, check_target, write};
use tailor::{ClothFigures, Products, Progress, Timing};

/// The figures of the products.
pub struct Figures {
    pub sim: SimFigures,
    pub render: RenderFigures,
    pub cloth: Option<ClothFigures>,
}

/// The result of one input.
pub struct Built {
    pub input: PathBuf,
    pub output: PathBuf,
    pub products: Products,
    pub figures: Figures,
    pub timings: Vec<Timing>,
    pub warnings: Warnings,
}

/// Builds every input. With several inputs, a failed one is reported and the others are still built.
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
                text::print_warnings(built.warnings.iter(), build.inputs.quiet, several.then_some(&input));
                all.push(built);
            }
            Err(error) if several => {
                text::print_error(&error, &input);
                code = code.max(crate::exit_code(&error));
            }
            Err(error) => return Err(error),
        }
    }
    if let Some(file) = &build.report {
        report::write(file, &all)?;
    }
    let summaries = all.iter().filter(|_| !build.inputs.quiet);
    let text = summaries.map(|b| text::summary(b, build.inputs.verbose)).collect();
    Ok(Output { text, code })
}

/// The output file of each input: `-o` itself, or a file in it if it is a folder.
fn outputs(build: &Build, files: &[PathBuf]) -> Result<Vec<PathBuf>, Error> {
    let out = &build.output;
    if files.len() == 1 && !out.is_dir() {
        return Ok(vec![out.clone()]);
    }
    if !out.is_dir() {
        return Err(usage(format!("-o {}", out.display()), format!("{} inputs need an existing folder", files.len()))
            .remedy("create the folder first, or build one input at a time"));
    }
    let mut paths: Vec<PathBuf> = Vec::with_capacity(files.len());
    for file in files {
        let stem = file.file_stem().unwrap_or_default().to_string_lossy();
        let path = out.join(format!("{stem}_tailored.usda"));
        if paths.contains(&path) {
            return Err(usage("", format!("two inputs are named {stem}")).remedy("build them into separate folders"));
        }
        paths.push(path);
    }
    Ok(paths)
}

fn build_one(build: &Build, input: &Path, output: PathBuf) -> Result<Built, Error> {
    let bar = spinner(build.inputs.quiet);
    let (shown, spinner) = (input.display().to_string(), bar.clone());
    let progress = Progress::new(move |step| spinner.set_message(format!("{shown}: {step}")));
    let mut timings = Vec::new();
    let opened = timed("read", &mut timings, || {
        let opened = build.inputs.open(input)?;
        check_target(&opened.source, &output, build.force)?;
        Ok(opened)
    })?;
    let (source, builder, recipe) = timed("check", &mut timings, || opened.check())?;
    let products = builder.with_progress(progress).with_max_faces(build.max_faces).update(&recipe)?;
    timings.extend(products.timings.iter().cloned());
    let figures = timed("figures", &mut timings, || {
        Ok(Figures { sim: products.sim_figures(), render: products.render_figures(), cloth: products.cloth_figures() })
    })?;
    let meshes = written(&products, [&build.sim_name, &build.render_name]);
    let options = WriteOptions { flatten: build.flatten, force: build.force, model_guide: !build.keep_model_purpose };
    let mut warnings = products.warnings.clone();
    timed("write", &mut timings, || write(&source, &meshes, &output, &options, &mut warnings))?;
    bar.finish_and_clear();
    Ok(Built { input: input.to_path_buf(), output, products, figures, timings, warnings })
}

/// Runs a step of the command and appends its time to `timings`.
fn timed<T>(
    name: &'static str,
    timings: &mut Vec<Timing>,
    work: impl FnOnce() -> Result<T, Error>,
) -> Result<T, Error> {
    let start = Instant::now();
    let result = work();
    timings.push(Timing { name, seconds: start.elapsed().as_secs_f64() });
    result
}

/// A progress spinner; hidden unless standard error is a terminal.
fn spinner(quiet: bool) -> ProgressBar {
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new_spinner().with_style(ProgressStyle::default_spinner());
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}
