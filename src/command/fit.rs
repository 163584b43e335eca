//! `usdtailor fit`.

mod pairs;
mod shown;

use super::process::folders::{MadeFolders, is_folder};
use super::process::memory;
use super::strict::Strictness;
use super::text::{print_earlier, print_error, print_warnings};
use super::{Inputs, Limits, Output, report, usage};
use clap::Args;
use glam::DVec3;
use serde_json::{Value, json};
use shown::{in_report, summary, with_files};
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use tailor_costume::fit::{Bodies, FitFigures, Fitted, fit};
use tailor_mesh::error::{Error, Warning, Warnings};
use tailor_mesh::meter::{PassedLimit, within_limit};
use tailor_usd::session::{OpenGarment, fit_options};
use tailor_usd::{
    BodyChoice, BoundTrim, BuildRecord, Format, HeldOutput, ReadOptions, Source, WriteOptions, body_of, check_target,
    stage_to_garment, write_bodies, write_fitted,
};

#[derive(Args)]
pub struct Fit {
    #[command(flatten)]
    inputs: Inputs,
    #[command(flatten)]
    limits: Limits,
    /// The body that the garment was made for
    #[arg(long, value_name = "BODY", help_heading = "Bodies")]
    from: PathBuf,
    /// The body that it is to fit, of the same faces or with a common UV set; repeatable
    #[arg(long, value_name = "BODY", help_heading = "Bodies", required = true, num_args = 1..)]
    to: Vec<PathBuf>,
    /// Path of the mesh in the files of bodies [default: the only mesh]
    #[arg(long, value_name = "PATH", help_heading = "Bodies")]
    body_prim: Option<String>,
    /// Places that correspond on bodies without common faces or UVs: lines of six numbers, a point of each body in its stage
    #[arg(long, value_name = "FILE", help_heading = "Bodies")]
    pairs: Option<PathBuf>,
    /// A set whose connected parts move as wholes, such as buttons, or an expression; repeatable
    #[arg(long, value_name = "SET", help_heading = "Fit")]
    rigid: Vec<String>,
    /// A set whose edges keep their lengths, such as a hem, or an expression; repeatable
    #[arg(long, value_name = "SET", help_heading = "Fit")]
    keep_length: Vec<String>,
    /// Output layer over the garment (.usd, .usda or .usdc), or a folder for several bodies or garments, which is made where it is
    /// missing
    #[arg(short, long, value_name = "OUT", help_heading = "Output")]
    output: PathBuf,
    /// Write one layer with a variant set of this name: a choice for each body, the first of which is the garment as it is
    #[arg(long, value_name = "SET", help_heading = "Output")]
    variant_set: Option<String>,
    /// Overwrite an existing output; the input is never overwritten
    #[arg(long, help_heading = "Output")]
    force: bool,
    /// Leave outputs that were made of the same files with the same options and version
    #[arg(long, help_heading = "Output")]
    skip_fresh: bool,
    /// Write crossings, distances, lengths and warnings as JSON; - prints them instead of the summary
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    report: Option<PathBuf>,
    #[command(flatten)]
    strictness: Strictness,
}

impl Fit {
    /// The options of reading.
    pub fn inputs(&self) -> &Inputs {
        &self.inputs
    }

    /// The warnings that are errors.
    pub fn strictness(&self) -> &Strictness {
        &self.strictness
    }
}

/// A garment that is fitted to a body.
struct Task {
    input: PathBuf,
    to: PathBuf,
    output: PathBuf,
    /// Where a lone output waits for the report.
    held: Option<HeldOutput>,
}

/// A garment that fits.
struct Done {
    source: Source,
    figures: FitFigures,
    /// The trims that it takes along.
    trims: Vec<BoundTrim>,
    warnings: Warnings,
}

/// The text, the reports and the exit code of the tasks so far.
#[derive(Default)]
struct Results {
    text: String,
    reports: Vec<Value>,
    code: u8,
}

impl Results {
    /// Adds garments that fit, and prints their warnings.
    fn add(&mut self, command: &Fit, task: &Task, garments: &[Done], label: Option<&PathBuf>) {
        let warnings: Warnings = garments.iter().flat_map(|done| done.warnings.iter().cloned()).collect();
        print_warnings(warnings.worst_first(), command.inputs.wording(), label);
        self.text += &summary(task, garments);
        self.reports.push(in_report(command, task, garments));
    }

    /// Adds a fresh output, and prints the warnings of the run that made it.
    fn add_fresh(&mut self, command: &Fit, task: &Task, record: &BuildRecord, label: Option<&PathBuf>) {
        let warnings: Vec<Value> = record.warnings().collect();
        print_earlier(&warnings, command.inputs.wording(), label);
        self.text += &format!("{}: fresh\n", task.output.display());
        self.reports.push(with_files(command, task, json!({ "status": "fresh", "warnings": warnings })));
    }
}

/// Fits each garment to each body.
pub fn run(command: &Fit) -> Result<Output, Error> {
    let prints_report = command.report.as_deref().is_some_and(report::is_printed);
    command.inputs.refuse_options_of_build()?;
    memory::hold(command.limits.max_memory);
    let mut tasks = tasks(command)?;
    if tasks.len() == 1 || command.variant_set.is_some() {
        tasks[0].held = command.report.as_ref().map(|_| HeldOutput::default());
    }
    // Kept to the end, when it goes again if nothing is in it.
    let _made = if has_folder(command, tasks.len()) { Some(MadeFolders::new(&command.output)?) } else { None };
    let report_file = command.report.as_deref().filter(|_| !prints_report);
    let reserve = |file| report::reserve(file, command.force, command.inputs.quiet);
    let _turn = report_file.map(reserve).transpose()?;
    let Results { text, mut reports, code } = match &command.variant_set {
        Some(set) => as_variants(command, &tasks, set)?,
        None => apart(command, &tasks)?,
    };
    let all = if reports.len() == 1 { reports.swap_remove(0) } else { json!({ "fits": reports }) };
    let all = report::pretty(&all)?;
    if let Some(file) = &command.report {
        report::write(file, &all, command.force)?;
        tasks.iter().filter_map(|task| task.held.as_ref()).try_for_each(|held| report::release(file, held))?;
    }
    let text = if prints_report || command.inputs.quiet { String::new() } else { text };
    Ok(Output { text, code })
}

/// Writes an output for each garment and body. With several, a failed one is reported and the others are still fitted.
fn apart(command: &Fit, tasks: &[Task]) -> Result<Results, Error> {
    let mut results = Results::default();
    for task in tasks {
        let label = (tasks.len() > 1).then_some(&task.output);
        if let Some(record) = fresh(command, task) {
            results.add_fresh(command, task, &record, label);
            continue;
        }
        let fitted = within_limit(|| fit_one(command, task));
        match fitted.unwrap_or_else(|PassedLimit| Err(super::program::too_much_memory())) {
            Ok(garments) => results.add(command, task, &garments, label),
            Err(error) => {
                let Some(label) = label else { return Err(error) };
                print_error(&error, Some(label));
                let failed = json!({ "status": "failed", "error": report::error_json(&error) });
                results.reports.push(with_files(command, task, failed));
                results.code = results.code.max(super::program::exit_code(&error));
            }
        }
    }
    Ok(results)
}

/// Writes one output with a variant for each body.
fn as_variants(command: &Fit, tasks: &[Task], set: &str) -> Result<Results, Error> {
    let mut results = Results::default();
    if let Some(record) = fresh(command, &tasks[0]) {
        results.add_fresh(command, &tasks[0], &record, None);
        return Ok(results);
    }
    for (task, garments) in tasks.iter().zip(fit_all(command, tasks, set)?) {
        results.add(command, task, &garments, (tasks.len() > 1).then_some(&task.to));
    }
    Ok(results)
}

/// Whether the output is a folder for the outputs of so many tasks.
fn has_folder(command: &Fit, tasks: usize) -> bool {
    is_folder(&command.output, if command.variant_set.is_some() { 1 } else { tasks })
}

/// Each garment and body with its output: `-o` itself, or a file in it if it is a folder.
fn tasks(command: &Fit) -> Result<Vec<Task>, Error> {
    let files = command.inputs.files()?;
    let all: Vec<(&PathBuf, &PathBuf)> =
        files.iter().flat_map(|input| command.to.iter().map(move |to| (input, to))).collect();
    let out = &command.output;
    if Format::of(out).is_ok_and(|format| format == Format::Usdz) {
        let fault = usage(format!("-o {}", out.display()), "a package has no layer over another file");
        return Err(fault
            .code(tailor_usd::codes::OUTPUT_PATH)
            .remedy("write .usd, .usda or .usdc, and build a package of it"));
    }
    let is_folder = has_folder(command, all.len());
    if is_folder && !out.is_dir() && (out.exists() || Format::of(out).is_ok()) {
        let fault = usage(format!("-o {}", out.display()), format!("{} outputs need a folder", all.len()));
        return Err(fault.remedy("name a folder, which is made if it is missing, or fit to one body at a time"));
    }
    let mut known = HashSet::new();
    if command.variant_set.is_some() {
        known.insert((out.clone(), Some(stem(&command.from))));
    }
    let task = |(input, to): (&PathBuf, &PathBuf)| {
        let [garment, body] = [input, to].map(|file| stem(file));
        let output = if is_folder { out.join(format!("{garment}_{body}.usdc")) } else { out.clone() };
        if let Some(body) = [&command.from].into_iter().chain(&command.to).find(|body| is_same(body, &output)) {
            let fault = usage("", format!("{} is a body", body.display())).code(tailor_usd::codes::OUTPUT_IS_INPUT);
            return Err(fault.remedy("write to another file; bodies are never changed"));
        }
        if known.insert((output.clone(), command.variant_set.is_some().then(|| body.clone()))) {
            return Ok(Task { input: input.clone(), to: to.clone(), output, held: None });
        }
        let what = match command.variant_set {
            Some(_) => format!("two variants would be named {body}"),
            None => format!("two outputs would be {}", output.display()),
        };
        let fault = usage("", what).code(tailor_usd::codes::OUTPUT_PATH);
        Err(fault.remedy("give the files other names, or fit them into separate folders"))
    };
    all.into_iter().map(task).collect()
}

/// The record of an output that was made by this program of these files with these options, if it may be skipped.
fn fresh(command: &Fit, task: &Task) -> Option<BuildRecord> {
    let request = request(command, task).ok().filter(|_| command.skip_fresh)?;
    BuildRecord::fresh(&task.output, &request)
}

/// The options that shape an output, as its record has them. Those of reading have the names that a build gives them.
fn request(command: &Fit, task: &Task) -> Result<String, Error> {
    let inputs = &command.inputs;
    let path = |file: &Path| BuildRecord::path_of(file, &task.output);
    // A variant set is of all bodies.
    let to = command.to.iter().map(PathBuf::as_path).filter(|to| command.variant_set.is_some() || *to == task.to);
    let request = json!({
        "input": path(&task.input)?,
        "recipe": inputs.recipe.as_deref().map(path).transpose()?,
        "prim": inputs.prim,
        "time": inputs.time,
        "set": inputs.input(&task.input).overrides,
        "all": inputs.several.all,
        "exclude": inputs.several.exclude,
        "sewTolerance": inputs.several.sew_tolerance,
        "fit": {
            "from": path(&command.from)?,
            "to": to.map(path).collect::<Result<Vec<_>, Error>>()?,
            "variantSet": command.variant_set,
            "pairs": command.pairs.as_deref().map(path).transpose()?,
            "bodyPrim": command.body_prim,
            "rigid": command.rigid,
            "keepLength": command.keep_length,
            "strictness": command.strictness,
        },
    });
    Ok(request.to_string())
}

/// Fits the garments of one input to one body and writes them.
fn fit_one(command: &Fit, task: &Task) -> Result<Vec<Done>, Error> {
    let (mut garments, record) = fit_to(command, task)?;
    let write = |options: &WriteOptions| write_fitted(&sources(&garments), &task.output, options);
    let (trims, warnings) = strictly(command, task, record, write)?;
    add_trims(&mut garments, trims);
    add_warnings(&mut garments, warnings);
    Ok(garments)
}

/// Fits the garments of one input to several bodies and writes them as variants.
fn fit_all(command: &Fit, tasks: &[Task], set: &str) -> Result<Vec<Vec<Done>>, Error> {
    let first = &tasks[0];
    if tasks.iter().any(|task| task.input != first.input) {
        let fault =
            usage(format!("--variant-set {set}"), "it takes one garment").code(tailor_mesh::codes::COMMAND_LINE);
        return Err(fault.remedy("name one input, or leave it out to write a folder"));
    }
    let (mut all, records): (Vec<_>, Vec<_>) =
        tasks.iter().map(|task| fit_to(command, task)).collect::<Result<Vec<_>, Error>>()?.into_iter().unzip();
    let names: Vec<String> =
        std::iter::once(&command.from).chain(tasks.iter().map(|task| &task.to)).map(|file| stem(file)).collect();
    let garments = std::iter::once(Vec::new()).chain(all.iter().map(|garments| sources(garments)));
    let choices: Vec<BodyChoice> =
        names.iter().zip(garments).map(|(name, garments)| BodyChoice { name, garments }).collect();
    let record = BuildRecord::of_all(records);
    let write = |options: &WriteOptions| write_bodies(set, &choices, &first.output, options);
    let (trims, warnings) = strictly(command, first, record, write)?;
    // The first choice is the garment as it is.
    all.iter_mut().zip(trims.into_iter().skip(1)).for_each(|(garments, trims)| add_trims(garments, trims));
    if let Some(last) = all.last_mut() {
        add_warnings(last, warnings);
    }
    Ok(all)
}

/// Whether two paths are of one file that is there.
fn is_same(a: &Path, b: &Path) -> bool {
    a.canonicalize().is_ok_and(|a| b.canonicalize().is_ok_and(|b| a == b))
}

fn stem(file: &Path) -> String {
    file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Adds warnings of writing, which replace those of reading about the same places.
fn add_warnings(garments: &mut [Done], warnings: Warnings) {
    for done in garments.iter_mut() {
        let is_other = |own: &&Warning| !warnings.iter().any(|new| new.place == own.place);
        done.warnings = done.warnings.iter().filter(is_other).cloned().collect();
    }
    if let Some(last) = garments.last_mut() {
        last.warnings.extend(warnings);
    }
}

/// Writes a layer. If warnings are errors, a rehearsal finds them before anything is written.
fn strictly<T>(
    command: &Fit,
    task: &Task,
    record: BuildRecord,
    write: impl Fn(&WriteOptions) -> Result<(T, Warnings), Error>,
) -> Result<(T, Warnings), Error> {
    let (record, held) = (Some(record), task.held.clone());
    let options = WriteOptions { force: command.force, record, held, ..WriteOptions::default() };
    if command.strictness.is_any() {
        command.strictness.check(&write(&WriteOptions { dry_run: true, ..options.clone() })?.1)?;
    }
    write(&options)
}

fn add_trims(garments: &mut [Done], trims: Vec<BoundTrim>) {
    trims.into_iter().for_each(|trim| garments[trim.garment].trims.push(trim));
}

fn sources(garments: &[Done]) -> Vec<&Source> {
    garments.iter().map(|done| &done.source).collect()
}

/// The garments of one input on one body, and the record of what they are made of.
fn fit_to(command: &Fit, task: &Task) -> Result<(Vec<Done>, BuildRecord), Error> {
    let started = SystemTime::now();
    let opened = command.inputs.open(&task.input)?;
    check_target(&opened[0].source, &task.output, command.force)?;
    let body = |file: &Path| {
        let (prim, time) = (command.body_prim.clone(), command.inputs.time);
        let read = ReadOptions { prim, time, unsewn: true, ..ReadOptions::default() };
        Source::open(file, &read).map_err(of_body)
    };
    let bodies = [body(&command.from)?, body(&task.to)?];
    bodies.iter().try_for_each(|body| check_target(body, &task.output, command.force))?;
    let read: Vec<Source> = opened.iter().map(|garment| garment.source.clone()).chain(bodies.iter().cloned()).collect();
    let recipes: Vec<PathBuf> = command.inputs.recipe.iter().chain(&command.pairs).cloned().collect();
    let record = BuildRecord::new(&read, &recipes, request(command, task)?, &task.output, started)?;
    let fit = |garment| fitted(command, garment, &bodies);
    let mut garments = opened.into_iter().map(fit).collect::<Result<Vec<_>, Error>>()?;
    garments.iter_mut().take(1).for_each(|done| done.warnings.extend(bodies.iter().flat_map(Source::notes)));
    garments.iter().try_for_each(|done| command.strictness.check(&done.warnings))?;
    let record = record.with_warnings(garments.iter().flat_map(|done| done.warnings.iter()));
    Ok((garments, record))
}

/// A fault of reading a body, whose mesh has a flag of its own.
fn of_body(mut error: Error) -> Error {
    for fault in &mut error.faults {
        fault.remedy = fault.remedy.replace("--prim", "--body-prim");
    }
    error
}

/// One garment, fitted.
fn fitted(command: &Fit, garment: OpenGarment, files: &[Source; 2]) -> Result<Done, Error> {
    let (mut source, builder, recipe) = garment.check()?;
    if !recipe.fit.to.is_empty() {
        let fault = Error::recipe("fit.to", format!("the recipe fits {} to {} already", source.whole(), recipe.fit.to));
        return Err(fault
            .code(tailor_mesh::codes::OPTION_VALUE)
            .remedy("take fit.from and fit.to out of it, or build it"));
    }
    let bodies = bodies(command, &source, files)?;
    let (rigid, keep_length) = (("--rigid", &command.rigid[..]), ("--keep-length", &command.keep_length[..]));
    let options = fit_options(&builder, &recipe, rigid, keep_length)?;
    let Fitted { points, figures, warnings: of_fit, .. } = fit(builder.garment(), &bodies, &options)?;
    let mut warnings: Warnings = builder.warnings().iter().cloned().collect();
    if source.has_products() {
        let stay = Warning::not_carried(format!("the products of {}", source.whole()), "they stay on the first body");
        warnings.push(stay.remedy("Fit the garment without products, and build the result"));
    }
    warnings.extend(source.set_fitted(builder.garment(), points, command.inputs.time, &recipe.trim)?);
    warnings.extend(builder.face_numbers().warnings_in_file(of_fit));
    Ok(Done { source, figures, trims: Vec::new(), warnings })
}

/// The bodies in the space of a garment.
fn bodies(command: &Fit, garment: &Source, files: &[Source; 2]) -> Result<Bodies, Error> {
    let [from, to] = [body_of(garment, &files[0])?, body_of(garment, &files[1])?];
    let Some(file) = &command.pairs else { return Bodies::new(&from, &to) };
    let [of_from, of_to] = files.each_ref().map(|body| stage_to_garment(garment, body));
    let pairs = pairs::read(file)?;
    pairs::check(
        file,
        &pairs,
        files,
        &[(&from, of_from), (&to, of_to)].map(|(mesh, map)| pairs::bounds(mesh, map.inverse())),
    )?;
    let placed = |[a, b]: [DVec3; 2]| [of_from.transform_point3(a), of_to.transform_point3(b)];
    Bodies::by_pairs(&from, &to, &pairs.into_iter().map(placed).collect::<Vec<_>>())
}
