//! `usdtailor build`.

mod batch;
mod levels;
mod protect;
mod request;
mod unused;

pub use levels::{lines as level_lines, report as level_report, warnings as all_warnings};
pub use request::Request;

use super::process::folders::{MadeFolders, is_folder};
use super::process::memory::{self, RunningStep};
use super::variants::{self, Opening};
use super::{Build, Output, report, text, usage};
use batch::{Budget, run_all};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::Value;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant, SystemTime};
use tailor::report::{RenderFigures, SimFigures};
use tailor_costume::{Builder, ClothFigures, Products, Progress, Recipe, RenderPanel, Timing};
use tailor_mesh::error::{Error, Warnings};
use tailor_mesh::garment::Mesh;
use tailor_mesh::meter::PassedLimit;
use tailor_usd::session::{is_usd, written};
use tailor_usd::{
    BoundTrim, BuildRecord, Format, GarmentProducts, HeldOutput, ProductNames, Selection, Source, WriteOptions,
    check_name, check_target, product_names, write_all,
};

/// An input and its output.
#[derive(Default)]
pub struct Task {
    pub input: PathBuf,
    pub output: PathBuf,
    /// Where the output of a lone input waits for the report.
    pub held: Option<HeldOutput>,
}

/// The result of one input. It holds no mesh, so that a run of many inputs does not keep them all.
pub enum Outcome {
    /// Its output was written.
    Built(Box<Summary>),
    /// Its output was fresh and stays; the warnings are those of the build that wrote it.
    Fresh(Vec<Value>),
    /// Its output would be written in other than a dry run; the text says what it would hold.
    Planned { text: String, warnings: Warnings },
    /// Its output was not written.
    Failed(Error),
}

impl Outcome {
    /// Whether the output was there already.
    fn lost(&self) -> bool {
        let Self::Failed(error) = self else { return false };
        error.faults.iter().any(|fault| fault.code == tailor_usd::codes::OUTPUT_EXISTS)
    }
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

/// The figures of the products of a garment.
pub struct Figures {
    pub sim: SimFigures,
    pub render: Option<RenderFigures>,
    pub cloth: Option<ClothFigures>,
}

/// The products of one garment of an input.
pub struct Built {
    /// Path of the garment in messages.
    pub prim: String,
    /// The variant that it was read with, and whose part its products are.
    pub variant: Option<Selection>,
    pub names: ProductNames,
    pub products: Products,
    /// The parts of the render mesh that are written in its place, at each level of detail; none for the whole.
    pub panels: Vec<Vec<RenderPanel>>,
    /// Files of which the output, a package, has a copy.
    pub packed: Vec<PathBuf>,
    /// The trims that ride on it.
    pub trims: Vec<BoundTrim>,
    pub timings: Vec<Timing>,
    pub warnings: Warnings,
}

impl Built {
    /// The render mesh, if it is written.
    pub fn render(&self) -> Option<&Mesh> {
        (!self.names.render.is_empty()).then_some(&*self.products.render)
    }

    /// Measures the products, and notes the time of it.
    fn measure(&mut self) -> Figures {
        let (products, start) = (&self.products, Instant::now());
        let (sim, cloth) = (products.sim_figures(), products.cloth_figures());
        let render = self.render().map(RenderFigures::new);
        self.timings.push(Timing { name: "figures", seconds: start.elapsed().as_secs_f64() });
        Figures { sim, render, cloth }
    }
}

/// Builds every input. With several inputs, a failed one is reported and the others are still built.
pub fn run(build: &Build) -> Result<Output, Error> {
    let mut tasks = tasks(build)?;
    // Kept to the end, when it goes again if nothing is in it.
    let _made = if is_folder(&build.output, tasks.len()) { Some(MadeFolders::new(&build.output)?) } else { None };
    let report_file = build.report.as_deref().filter(|file| !report::is_printed(file));
    let prints_report = build.report.is_some() && report_file.is_none();
    // The caller prints the error of a lone input, unless there is a report to print as well.
    let is_lone = tasks.len() == 1 && !prints_report;
    let _turn = report_file.map(|file| report::reserve(file, build.force, build.inputs.quiet)).transpose()?;
    protect::check(build, &tasks)?;
    if let ([task], Some(_)) = (&mut tasks[..], &build.report) {
        task.held = Some(HeldOutput::default());
    }
    let budget = Budget::new(memory::hold(build.limits.max_memory));
    let jobs = build.jobs.map_or_else(rayon::current_num_threads, usize::from).min(tasks.len());
    let bar = bar(build.inputs.quiet, tasks.len());
    let mut outcomes = Vec::with_capacity(tasks.len());
    // One of several inputs is a line of a table.
    let is_told = !build.inputs.quiet && (tasks.len() == 1 || build.inputs.verbose);
    run_all(
        &tasks,
        jobs,
        |task| build_one(build, task, &budget, &bar, jobs == 1, is_told),
        |task, outcome| {
            bar.suspend(|| tell(build, &outcome, (tasks.len() > 1).then_some(&task.input), is_lone));
            bar.inc(1);
            outcomes.push(outcome);
        },
    );
    bar.finish_and_clear();
    let report = report::text(&tasks, &outcomes)?;
    // Where nothing was written as all outputs were there, the report is that of the run which wrote them.
    if let Some(file) = build.report.as_deref().filter(|_| prints_report || !outcomes.iter().all(Outcome::lost)) {
        report::write(file, &report, build.force)?;
        tasks.iter().filter_map(|task| task.held.as_ref()).try_for_each(|held| report::release(file, held))?;
    }
    if is_lone && let Some(Outcome::Failed(error)) = outcomes.pop_if(|outcome| matches!(outcome, Outcome::Failed(_))) {
        return Err(error);
    }
    let failed = outcomes.iter().filter_map(|outcome| if let Outcome::Failed(e) = outcome { Some(e) } else { None });
    let code = failed.map(super::program::exit_code).max().unwrap_or(0);
    let text = if prints_report || build.inputs.quiet { String::new() } else { text::outcomes(&tasks, &outcomes) };
    Ok(Output { text, code })
}

/// Each input with its output: `-o` itself, or a file in it if it is a folder.
fn tasks(build: &Build) -> Result<Vec<Task>, Error> {
    check_name("--sim-name", &build.sim_name)?;
    check_name("--render-name", &build.render_name)?;
    let files = build.inputs.files()?;
    let out = &build.output;
    if !is_folder(&build.output, files.len()) {
        return Ok(files.into_iter().map(|input| Task { input, output: out.clone(), held: None }).collect());
    }
    if !out.is_dir() && (out.exists() || Format::of(out).is_ok()) {
        return Err(usage(format!("-o {}", out.display()), format!("{} inputs need a folder", files.len()))
            .remedy("name a folder, which is made if it is missing, or build one input at a time"));
    }
    let mut known = std::collections::HashSet::new();
    let task = |input: PathBuf| {
        let stem = input.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let output = out.join(format!("{stem}_tailored.usdc"));
        if known.insert(output.clone()) {
            return Ok(Task { input, output, held: None });
        }
        Err(usage("", format!("two inputs are named {stem}")).remedy("build them into separate folders"))
    };
    files.into_iter().map(task).collect()
}

/// Prints the warnings and the error of an input, which `label` names where it is one of several.
fn tell(build: &Build, outcome: &Outcome, label: Option<&PathBuf>, is_lone: bool) {
    let wording = build.inputs.wording();
    match outcome {
        Outcome::Built(summary) => text::print_warnings(summary.warnings.worst_first(), wording, label),
        Outcome::Failed(error) if !is_lone => text::print_error(error, label.map(PathBuf::as_path)),
        Outcome::Planned { warnings, .. } => text::print_warnings(warnings.worst_first(), wording, label),
        Outcome::Fresh(warnings) => text::print_earlier(warnings, wording, label),
        Outcome::Failed(_) => {}
    }
}

/// Builds one input, the only one at a time if it `is_lone`. Its summary is empty unless it `is_told`.
fn build_one(build: &Build, task: &Task, budget: &Budget, bar: &ProgressBar, is_lone: bool, is_told: bool) -> Outcome {
    if build.skip_fresh
        && let Some(record) = Request::fresh(build, task)
    {
        return Outcome::Fresh(record.warnings().collect());
    }
    let start = Instant::now();
    let step = RunningStep::default();
    let result = budget.build(is_lone, || built(build, task, budget, bar, &step));
    match result.unwrap_or_else(|PassedLimit| Err(memory::passed(budget.limit(), &step))) {
        Ok(garments) if build.dry_run => planned(task, garments),
        Ok(garments) => Outcome::Built(Box::new(summary(build, task, garments, is_told, start))),
        Err(error) => Outcome::Failed(error),
    }
}

/// The results of an input. Figures are measured only for a text or a report.
fn summary(build: &Build, task: &Task, mut garments: Vec<Built>, is_told: bool, start: Instant) -> Summary {
    let is_reported = build.report.is_some();
    let figures: Vec<Figures> =
        if is_told || is_reported { garments.iter_mut().map(Built::measure).collect() } else { Vec::new() };
    let faces = |of: fn(&Built) -> Option<&Mesh>| garments.iter().filter_map(of).map(|mesh| mesh.faces.len()).sum();
    Summary {
        text: if is_told { text::summaries(task, &garments, &figures, build.inputs.verbose) } else { String::new() },
        report: if is_reported { report::built(task, &garments, &figures) } else { Value::Null },
        faces: [faces(|built| Some(&built.products.sim)), faces(Built::render)],
        warnings: warnings(garments),
        seconds: start.elapsed().as_secs_f64(),
    }
}

fn warnings(garments: Vec<Built>) -> Warnings {
    garments.into_iter().fold(Warnings::default(), |mut all, built| {
        all.extend(built.warnings);
        all
    })
}

/// The outcome of a dry run.
fn planned(task: &Task, garments: Vec<Built>) -> Outcome {
    let mut text = format!("{} -> {}: would write", task.input.display(), task.output.display());
    for built in &garments {
        let Built { products, names, variant, .. } = built;
        let within = variant.as_ref().map(|variant| format!(" in {}", variant.choice)).unwrap_or_default();
        let rendered = |render: &Mesh| format!(", {} faces to {}", render.faces.len(), names.render.join(" and "));
        let rendered = built.render().map(rendered).unwrap_or_default();
        text += &format!(" {} triangles to {}{rendered}{within};", products.sim.faces.len(), names.sim);
    }
    Outcome::Planned { text: text.trim_end_matches(';').to_owned() + "\n", warnings: warnings(garments) }
}

fn built(
    build: &Build,
    task: &Task,
    budget: &Budget,
    bar: &ProgressBar,
    step: &RunningStep,
) -> Result<Vec<Built>, Error> {
    let Task { input, output, .. } = task;
    *step.lock().unwrap_or_else(PoisonError::into_inner) = String::new();
    let started = SystemTime::now();
    let mut timings = Vec::new();
    let openings = timed("read", &mut timings, || {
        let openings = variants::open(build, input)?;
        check_target(&openings[0].garments[0].source, output, build.force).map(|()| openings)
    })?;
    let (mut sources, mut checked) = (Vec::new(), Vec::new());
    timed("check", &mut timings, || {
        for Opening { variant, garments } in openings {
            let names = product_names(garments.iter().map(|g| &g.source), [&build.sim_name, &build.render_name]);
            for (garment, names) in garments.into_iter().zip(names) {
                let (source, builder, recipe) = garment.check()?;
                let names = leveled(build, &source, &recipe, names)?;
                let recipe = if build.sim_only { recipe.of_sim() } else { recipe };
                sources.push(source);
                checked.push((limited(builder, build, task, budget, bar, step), recipe, names, variant.clone()));
            }
        }
        Ok(())
    })?;
    let bytes = checked.iter().map(|(builder, recipe, ..)| Ok(builder.estimate(recipe)?.bytes()));
    let _reserved = budget.reserve(bytes.sum::<Result<usize, Error>>()?);
    let record = BuildRecord::new(&sources, &recipes(build, input), Request::of(build, task)?.text(), output, started)?;
    let mut garments = Vec::with_capacity(sources.len());
    for (builder, recipe, names, variant) in checked {
        let timings = std::mem::take(&mut timings);
        let mut built = garment(builder, &recipe, build.mark, names, timings)?;
        if build.render_per_panel {
            let panels = sources[garments.len()].panel_sets();
            built.panels = built.products.all_levels().map(|level| level.render_panels(panels)).collect();
        }
        garments.push(Built { variant, ..built });
    }
    if build.strictness.is_any() {
        // A rehearsal finds the warnings of writing before anything is written.
        write(build, task, record.clone(), &sources, &mut garments, true)?;
        garments.iter().try_for_each(|built| build.strictness.check(&built.warnings))?;
    }
    write(build, task, record, &sources, &mut garments, build.dry_run)?;
    Ok(garments)
}

/// The names of the products of a garment at all levels of detail.
fn leveled(build: &Build, source: &Source, recipe: &Recipe, names: ProductNames) -> Result<ProductNames, Error> {
    let levels = recipe.lod.levels;
    if build.sim_only {
        let faults = [
            (levels > 1, "levels of detail are of both meshes", "set lod.levels to 1"),
            (source.has_products(), "the input has products of another build", "name the file without them"),
        ];
        let fault = faults.into_iter().find(|(is_there, ..)| *is_there);
        let refused = fault.map(|(_, fault, remedy)| Error::recipe("--sim-only", fault).remedy(remedy));
        return refused.map_or(Ok(ProductNames { render: Vec::new(), ..names }), Err);
    }
    if levels > 1 {
        variants::refuse_products(source, "lod.levels", "levels of detail")?;
    }
    let names = names.with_levels(levels, build.lod_schema);
    Ok(if build.render_per_panel { names.per_panel(source) } else { names })
}

/// A builder with the limits of the command, which shows its steps.
fn limited(
    builder: Builder,
    build: &Build,
    task: &Task,
    budget: &Budget,
    bar: &ProgressBar,
    running: &RunningStep,
) -> Builder {
    let (shown, spinner, running) = (task.input.display().to_string(), bar.clone(), Arc::clone(running));
    let progress = Progress::new(move |step| {
        spinner.set_message(format!("{shown}: {step}"));
        *running.lock().unwrap_or_else(PoisonError::into_inner) = step.to_owned();
    });
    builder.with_progress(progress).with_max_faces(build.max_faces).with_max_memory(budget.limit())
}

/// Builds one garment. The builder keeps the result of each step for another update, and there is none.
fn garment(
    mut builder: Builder,
    recipe: &Recipe,
    marks: bool,
    names: ProductNames,
    mut timings: Vec<Timing>,
) -> Result<Built, Error> {
    let prim = builder.garment().prim.clone();
    let mut products = builder.update(recipe)?;
    let marker = marks.then(|| builder.sibling());
    drop(builder);
    if let Some(marked) = marker.map(|marker| marker.marked(&products)).transpose()?.flatten() {
        products.render = marked;
    }
    timings.extend(products.timings.iter().cloned());
    let warnings = levels::warnings(&products);
    let (panels, packed, trims) = (Vec::new(), Vec::new(), Vec::new());
    Ok(Built { prim, variant: None, names, panels, packed, trims, products, timings, warnings })
}

/// Writes the products of all garments, or rehearses it. The last one gets the time of it, and its warnings.
fn write(
    build: &Build,
    task: &Task,
    record: BuildRecord,
    sources: &[Source],
    garments: &mut [Built],
    dry_run: bool,
) -> Result<(), Error> {
    let options = WriteOptions {
        flatten: build.flatten,
        sets: build.sets,
        lod_schema: build.lod_schema,
        force: build.force,
        // Without a render mesh, the model is what is drawn.
        model_guide: !(build.keep_model_purpose || build.sim_only),
        dry_run,
        record: Some(record.with_warnings(garments.iter().flat_map(|built| built.warnings.iter()))),
        held: task.held.clone(),
    };
    let mut timings = Vec::new();
    let (written, warnings) = timed(if dry_run { "rehearsal" } else { "write" }, &mut timings, || {
        let meshes: Vec<_> =
            garments.iter().map(|built| written(&built.products, &built.panels, &built.names)).collect();
        let variants = garments.iter().map(|built| built.variant.as_ref());
        let all: Vec<_> = (sources.iter().zip(&meshes).zip(variants))
            .map(|((source, products), variant)| GarmentProducts { source, products, variant })
            .collect();
        write_all(&all, &task.output, &options)
    })?;
    for (number, built) in garments.iter_mut().enumerate() {
        built.trims = written.trims.iter().filter(|trim| trim.garment == number).cloned().collect();
    }
    if let Some(last) = garments.last_mut() {
        last.timings.extend(timings);
        last.warnings.extend(warnings);
        last.packed = written.packed;
    }
    Ok(())
}

/// The files of an input that are not layers of its stage.
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
