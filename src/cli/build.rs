//! `usdtailor build`.

use super::{Build, Opened, Output, text};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use tailor::error::{Error, Warnings};
use tailor::pipeline::{Limits, Products, Stage};
use tailor::usd::{Product, Role, WriteOptions, check_target, write};

/// What one input gave.
struct Built {
    input: PathBuf,
    output: PathBuf,
    products: Products,
    warnings: Warnings,
}

/// Builds every input.
pub fn run(build: &Build) -> Result<Output, Error> {
    let files = build.inputs.files()?;
    let outputs = outputs(build, &files)?;
    let mut all = Vec::with_capacity(files.len());
    for (input, output) in files.into_iter().zip(outputs) {
        let built = build_one(build, input, output)?;
        text::print_warnings(&built.warnings, build.inputs.quiet);
        all.push(built);
    }
    if let Some(file) = &build.report {
        write_report(file, &all)?;
    }
    let summaries = all.iter().filter(|_| !build.inputs.quiet);
    let text = summaries.map(|b| text::summary(&b.input, &b.output, &b.products, build.inputs.verbose)).collect();
    Ok(Output { text, code: 0 })
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

fn build_one(build: &Build, input: PathBuf, output: PathBuf) -> Result<Built, Error> {
    let bar = spinner(build.inputs.quiet);
    let progress = |stage: &str| bar.set_message(format!("{}: {stage}", input.display()));
    progress("read");
    let start = Instant::now();
    let mut opened = build.inputs.open(&input)?;
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
        Product { name: &build.sim_name, role: Role::Sim, mesh: &products.sim },
        Product { name: &build.render_name, role: Role::Render, mesh: &products.render },
    ];
    let options = WriteOptions { flatten: build.flatten, force: build.force, model_guide: !build.keep_model_purpose };
    write(&source, &meshes, &output, &options, &mut warnings)?;
    products.stages.push(Stage { name: "write", seconds: start.elapsed().as_secs_f64() });
    products.stages.splice(0..0, [read, check]);
    bar.finish_and_clear();
    Ok(Built { input, output, products, warnings })
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

fn write_report(file: &Path, all: &[Built]) -> Result<(), Error> {
    let mut reports: Vec<Value> = all.iter().map(report).collect();
    let report = if reports.len() == 1 { reports.swap_remove(0) } else { json!({ "builds": reports }) };
    let text = serde_json::to_string_pretty(&report).map_err(|e| Error::Internal(e.to_string()))?;
    let failed = |e: std::io::Error| {
        Error::Usage(format!(
            "cannot write report {}: {e}\n  hint: choose a folder that you may write to",
            file.display()
        ))
    };
    let mut out = std::fs::File::create(file).map_err(failed)?;
    out.write_all(text.as_bytes()).and_then(|()| out.write_all(b"\n")).map_err(failed)
}

fn report(built: &Built) -> Value {
    let p = &built.products;
    json!({
        "input": built.input.display().to_string(),
        "output": built.output.display().to_string(),
        "recipe": p.recipe,
        "sim": p.sim_figures,
        "remesh": p.remesh,
        "render": p.render_figures,
        "stages": p.stages,
        "warnings": built.warnings.iter().map(text::warning_json).collect::<Vec<_>>(),
    })
}
