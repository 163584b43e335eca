//! `usdtailor build`.

use super::batch::{Budget, run_all};
use super::process::memory;
use super::{Build, Output, protect, report, text, usage};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};
use tailor::error::{Error, Warnings};
use tailor::report::{RenderFigures, SimFigures};
use tailor::session::{is_usd, written};
use tailor::usd::{BuildRecord, WriteOptions, check_target, write};
use tailor::{ClothFigures, Products, Progress, Timing};

/// The name of a report that is printed.
const STDOUT: &str = "-";

/// An input and its output.
pub struct Task {
    pub input: PathBuf,
    pub output: PathBuf,
}

/// The result of one input. It holds no mesh, so that a run of many inputs does not keep them all.
pub enum Outcome {
    /// Its output was written.
    Built(Box<Summary>),
    /// Its output was fresh and stays.
    Fresh,
    /// Its output would be written; the text says what it would hold.
    Planned(String),
    /// Its output was not written.
    Failed(Error),
}

/// The report of a build, as text and as JSON.
pub struct Summary {
    pub text: String,
    pub report: Value,
    pub warnings: Warnings,
    /// Faces of the two meshes.
    pub faces: [usize; 2],
    pub seconds: f64,
}

/// The products of one input, with their figures.
pub struct Built {
    pub products: Products,
    pub sim: SimFigures,
    pub render: RenderFigures,
    pub cloth: Option<ClothFigures>,
    /// Files of which the output, a package, has a copy.
    pub packed: Vec<PathBuf>,
    pub timings: Vec<Timing>,
    pub warnings: Warnings,
}

/// Builds every input. With several inputs, a failed one is reported and the others are still built.
pub fn run(build: &Build) -> Result<Output, Error> {
    let tasks = tasks(build)?;
    let report_file = build.report.as_deref().filter(|file| *file != Path::new(STDOUT));
    if let Some(file) = report_file {
        report::check_target(file, build.force)?;
    }
    protect::check(build, &tasks)?;
    let budget = Budget::new(memory::limit(build.limits.max_memory));
    let jobs = build.jobs.map_or_else(rayon::current_num_threads, usize::from).min(tasks.len());
    let bar = bar(build.inputs.quiet, tasks.len());
    let mut outcomes = Vec::with_capacity(tasks.len());
    run_all(
        &tasks,
        jobs,
        |task| build_one(build, task, &budget, &bar),
        |task, outcome| {
            bar.suspend(|| tell(build, task, &outcome, tasks.len() > 1));
            bar.inc(1);
            outcomes.push(outcome);
        },
    );
    bar.finish_and_clear();
    let report = report::text(&tasks, &outcomes)?;
    if let Some(file) = report_file {
        report::write(file, &report, build.force)?;
    }
    if tasks.len() == 1
        && let Some(Outcome::Failed(error)) = outcomes.pop_if(|outcome| matches!(outcome, Outcome::Failed(_)))
    {
        return Err(error);
    }
    let failed = outcomes.iter().filter_map(|outcome| if let Outcome::Failed(e) = outcome { Some(e) } else { None });
    let code = failed.map(crate::exit_code).max().unwrap_or(0);
    let text = match &build.report {
        Some(_) if report_file.is_none() => report,
        _ if build.inputs.quiet => String::new(),
        _ => text::outcomes(&tasks, &outcomes, build.inputs.verbose),
    };
    Ok(Output { text, code })
}

/// Each input with its output: `-o` itself, or a file in it if it is a folder.
fn tasks(build: &Build) -> Result<Vec<Task>, Error> {
    let files = build.inputs.files()?;
    let out = &build.output;
    if files.len() == 1 && !out.is_dir() {
        return Ok(files.into_iter().map(|input| Task { input, output: out.clone() }).collect());
    }
    if !out.is_dir() {
        return Err(usage(format!("-o {}", out.display()), format!("{} inputs need an existing folder", files.len()))
            .remedy("create the folder first, or build one input at a time"));
    }
    let mut known = std::collections::HashSet::new();
    let task = |input: PathBuf| {
        let stem = input.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let output = out.join(format!("{stem}_tailored.usda"));
        if known.insert(output.clone()) {
            return Ok(Task { input, output });
        }
        Err(usage("", format!("two inputs are named {stem}")).remedy("build them into separate folders"))
    };
    files.into_iter().map(task).collect()
}

/// Prints the warnings of an input, and its error where it is one of several.
fn tell(build: &Build, task: &Task, outcome: &Outcome, several: bool) {
    match outcome {
        Outcome::Built(summary) => {
            let input = several.then_some(&task.input);
            text::print_warnings(summary.warnings.iter(), build.inputs.quiet, input);
        }
        Outcome::Failed(error) if several => text::print_error(error, Some(&task.input)),
        Outcome::Failed(_) | Outcome::Fresh | Outcome::Planned(_) => {}
    }
}

fn build_one(build: &Build, task: &Task, budget: &Budget, bar: &ProgressBar) -> Outcome {
    if build.skip_fresh && is_fresh(build, task) {
        return Outcome::Fresh;
    }
    if build.dry_run {
        return planned(build, task, budget).map_or_else(Outcome::Failed, Outcome::Planned);
    }
    let start = Instant::now();
    match built(build, task, budget, bar) {
        Ok(built) => Outcome::Built(Box::new(Summary {
            text: text::summary(task, &built, build.inputs.verbose),
            report: report::built(task, &built),
            faces: [built.sim.faces, built.render.faces],
            warnings: built.warnings,
            seconds: start.elapsed().as_secs_f64(),
        })),
        Err(error) => Outcome::Failed(error),
    }
}

/// What a build would write, found by less work than it takes.
fn planned(build: &Build, task: &Task, budget: &Budget) -> Result<String, Error> {
    let Task { input, output } = task;
    let opened = build.inputs.open(input)?;
    check_target(&opened.source, output, build.force)?;
    let (_, builder, recipe) = opened.check()?;
    let plan = builder.with_max_memory(budget.limit()).plan(&recipe)?;
    Ok(format!(
        "{} -> {}: would write about {} triangles to {} and {} faces to {}\n",
        input.display(),
        output.display(),
        plan.expected_faces,
        build.sim_name,
        plan.render_faces,
        build.render_name
    ))
}

fn built(build: &Build, task: &Task, budget: &Budget, bar: &ProgressBar) -> Result<Built, Error> {
    let Task { input, output } = task;
    let (shown, spinner) = (input.display().to_string(), bar.clone());
    let progress = Progress::new(move |step| spinner.set_message(format!("{shown}: {step}")));
    let started = SystemTime::now();
    let mut timings = Vec::new();
    let opened = timed("read", &mut timings, || {
        let opened = build.inputs.open(input)?;
        check_target(&opened.source, output, build.force)?;
        Ok(opened)
    })?;
    let (source, builder, recipe) = timed("check", &mut timings, || opened.check())?;
    let mut builder = builder.with_progress(progress).with_max_faces(build.max_faces).with_max_memory(budget.limit());
    let _reserved = budget.reserve(builder.estimate(&recipe)?.bytes());
    let record = BuildRecord::new(&source, &recipes(build, input), request(build, task)?, output, started)?;
    let products = builder.update(&recipe)?;
    // The builder keeps the result of each step for another update, and there is none.
    drop(builder);
    timings.extend(products.timings.iter().cloned());
    let (sim, render, cloth) = timed("figures", &mut timings, || {
        Ok((products.sim_figures(), products.render_figures(), products.cloth_figures()))
    })?;
    let meshes = written(&products, [&build.sim_name, &build.render_name]);
    let options = WriteOptions {
        flatten: build.flatten,
        force: build.force,
        model_guide: !build.keep_model_purpose,
        record: Some(record),
    };
    let mut warnings = products.warnings.clone();
    let packed = timed("write", &mut timings, || write(&source, &meshes, output, &options, &mut warnings))?.packed;
    Ok(Built { packed, products, sim, render, cloth, timings, warnings })
}

/// True if the output was made by this program of these files with these options.
fn is_fresh(build: &Build, task: &Task) -> bool {
    BuildRecord::of(&task.output).is_some_and(|record| {
        request(build, task).is_ok_and(|request| request == record.request())
            && record.changes(&task.output).is_ok_and(|changes| changes.is_empty())
    })
}

/// The options of a build that shape its output, as text. The record knows the files by what they hold, too.
fn request(build: &Build, task: &Task) -> Result<String, Error> {
    let inputs = &build.inputs;
    let path = |file: &Path| BuildRecord::path_of(file, &task.output);
    let request = json!({
        "input": path(&task.input)?,
        "recipe": inputs.recipe.as_deref().map(path).transpose()?,
        "prim": inputs.prim,
        "time": inputs.time,
        "set": inputs.input(&task.input).overrides,
        "flatten": build.flatten,
        "names": [build.sim_name, build.render_name],
        "keepModelPurpose": build.keep_model_purpose,
        "maxFaces": build.max_faces,
    });
    Ok(request.to_string())
}

/// The files of an input that are no layers of its stage.
fn recipes(build: &Build, input: &Path) -> Vec<PathBuf> {
    let own = (!is_usd(input)).then(|| input.to_path_buf());
    own.into_iter().chain(build.inputs.recipe.clone()).collect()
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

/// A progress bar, or a spinner for one input; hidden unless standard error is a terminal.
fn bar(quiet: bool, count: usize) -> ProgressBar {
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = if count == 1 { ProgressBar::new_spinner() } else { ProgressBar::new(count as u64) };
    let style = match count {
        1 => ProgressStyle::default_spinner(),
        _ => ProgressStyle::with_template("{bar:30} {pos}/{len}, {eta} left  {msg}")
            .unwrap_or_else(|_| ProgressStyle::default_bar()),
    };
    bar.set_style(style);
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}
