//! Writes the JSON report of a build.

use super::build::{Built, Figures, Outcome, Task, level_report};
use super::text::operator_sets;
use super::usage;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use tailor_mesh::error::{Error, plain};
use tailor_usd::{BoundTrim, HeldOutput, OutputLock, warning_json, write_whole};

/// Checks that a report may be written to `file`, before the build starts.
///
/// # Errors
/// A name that does not end in `.json`, which protects garments, layers and recipes; a file that exists, unless
/// `force`; a folder; a missing parent folder.
pub fn check_target(file: &Path, force: bool) -> Result<(), Error> {
    let shown = file.display();
    let fault = |fault: &str, remedy: &str| Err(usage("", fault).code(tailor_usd::codes::OUTPUT_PATH).remedy(remedy));
    let there = fs::metadata(file).ok();
    if there.as_ref().is_some_and(fs::Metadata::is_dir) {
        return fault(&format!("cannot write report {shown}: it is a folder"), "name a file, such as report.json");
    }
    if is_device(file) {
        return Ok(());
    }
    if !file.extension().is_some_and(|e| e.eq_ignore_ascii_case("json")) {
        return fault(&format!("report {shown} does not end in .json"), "name a file such as report.json");
    }
    if there.is_some() && !force {
        return Err(exists_already(file));
    }
    let folder = folder(file);
    if !folder.is_dir() {
        let fault_text = format!("cannot write report {shown}: there is no folder {}", folder.display());
        return fault(&fault_text, "create the folder first");
    }
    Ok(())
}

/// The report of all builds.
///
/// # Errors
/// None in practice: every value has a form in JSON.
pub fn text(tasks: &[Task], outcomes: &[Outcome]) -> Result<String, Error> {
    let mut reports: Vec<Value> = tasks.iter().zip(outcomes).map(|(task, outcome)| report(task, outcome)).collect();
    pretty(&if reports.len() == 1 { reports.swap_remove(0) } else { json!({ "builds": reports }) })
}

/// JSON with a line for each value.
///
/// # Errors
/// As [`text`].
pub fn pretty(json: &Value) -> Result<String, Error> {
    let text = serde_json::to_string_pretty(json).map_err(|e| Error::internal(e.to_string()))?;
    Ok(text + "\n")
}

/// As [`check_target`], for a run that has the report to itself: it waits for another that writes it. None for a device.
///
/// # Errors
/// As [`check_target`], and a folder that cannot be written to.
pub fn reserve(file: &Path, force: bool, quiet: bool) -> Result<Option<OutputLock>, Error> {
    check_target(file, force)?;
    if is_device(file) {
        return Ok(None);
    }
    let waits = || {
        if !quiet {
            let _ = writeln!(io::stderr(), "waiting for another run that writes {}", file.display());
        }
    };
    let lock = OutputLock::new(file, waits).map_err(|e| cannot_write(file, e))?;
    check_target(file, force)?;
    Ok(Some(lock))
}

/// Writes a report atomically: the file is complete or absent. The target of a link is replaced, not the link.
///
/// # Errors
/// A folder without write permission; a full disk; without `force`, a file that came up in the meantime.
pub fn write(file: &Path, text: &str, force: bool) -> Result<(), Error> {
    if is_printed(file) {
        let mut out = io::stdout();
        return out.write_all(text.as_bytes()).and_then(|()| out.flush()).or_else(|e| match e.kind() {
            // The reader has read enough.
            io::ErrorKind::BrokenPipe => Ok(()),
            _ => Err(cannot_write(Path::new("standard output"), e)),
        });
    }
    let written = if is_device(file) { fs::write(file, text) } else { write_whole(file, text.as_bytes(), force) };
    written.map_err(|e| match e.kind() {
        io::ErrorKind::AlreadyExists => exists_already(file),
        _ => cannot_write(file, e),
    })
}

/// Gives an output its name after its report. Without the output, there is no report of it.
///
/// # Errors
/// As [`HeldOutput::release`].
pub fn release(file: &Path, held: &HeldOutput) -> Result<(), Error> {
    held.release().inspect_err(|_| {
        if !is_printed(file) && !is_device(file) {
            let _ = fs::remove_file(file);
        }
    })
}

/// Whether a report goes to standard output.
pub fn is_printed(file: &Path) -> bool {
    file == Path::new("-")
}

fn cannot_write(file: &Path, e: io::Error) -> Error {
    let remedy = "check the folder's permissions and the space on its disk; --skip-fresh leaves outputs that are there";
    let fault = usage("", format!("cannot write report {}: {}", file.display(), plain(&e)));
    fault.code(tailor_usd::codes::WRITE_FAILED).remedy(remedy).caused_by(e)
}

fn exists_already(file: &Path) -> Error {
    usage("", format!("report {} exists already", file.display()))
        .code(tailor_usd::codes::OUTPUT_EXISTS)
        .remedy("overwrite it with --force")
}

/// `true` for a terminal, a pipe, `/dev/null` and the like, which are written to in place.
fn is_device(file: &Path) -> bool {
    fs::metadata(file).is_ok_and(|m| !m.is_file() && !m.is_dir())
}

fn folder(file: &Path) -> PathBuf {
    match file.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

fn report(task: &Task, outcome: &Outcome) -> Value {
    match outcome {
        Outcome::Built(summary) => summary.report.clone(),
        Outcome::Fresh(warnings) => {
            let mut report = head(task, "fresh");
            report["warnings"] = json!(warnings);
            report
        }
        Outcome::Planned { .. } => head(task, "planned"),
        Outcome::Failed(error) => {
            let mut report = head(task, "failed");
            report["error"] = error_json(error);
            report
        }
    }
}

/// An error: its message, and its faults apart.
pub fn error_json(error: &Error) -> Value {
    let faults =
        error.faults.iter().map(|f| json!({ "code": f.code, "place": f.place, "problem": f.text, "remedy": f.remedy }));
    json!({ "message": error.to_string(), "faults": faults.collect::<Vec<_>>() })
}

fn head(task: &Task, status: &str) -> Value {
    json!({
        "input": task.input.display().to_string(),
        "output": task.output.display().to_string(),
        "status": status,
    })
}

/// The report of an output that was written: of its garment, or of each of its garments.
pub fn built(task: &Task, garments: &[Built], figures: &[Figures]) -> Value {
    match (garments, figures) {
        ([one], [figures]) => garment(task, one, figures),
        _ => {
            let mut report = head(task, "built");
            let garments = garments.iter().zip(figures).map(|(built, figures)| {
                let mut report = garment(task, built, figures);
                report["prim"] = json!(built.prim);
                report["names"] = built.names.all().collect();
                if let Some(variant) = &built.variant {
                    report["variant"] = json!(variant);
                }
                report
            });
            report["garments"] = garments.collect();
            report
        }
    }
}

fn garment(task: &Task, built: &Built, Figures { sim, render, cloth }: &Figures) -> Value {
    let p = &built.products;
    let mut report = json!({
        "packed": built.packed,
        "recipe": p.recipe,
        "sim": sim,
        "remesh": p.remesh(),
        "render": render,
        "cloth": cloth,
        "operatorFaces": operator_sets(p).into_iter().collect::<BTreeMap<_, _>>(),
        "stages": built.timings,
        "warnings": built.warnings.iter().map(warning_json).collect::<Vec<_>>(),
    });
    let panels = built.names.render.iter().zip(built.panels.iter().flatten()).map(
        |(name, panel)| json!({ "name": name, "vertices": panel.mesh.points.len(), "faces": panel.mesh.faces.len() }),
    );
    report["renderPanels"] = panels.collect();
    report["trims"] = built.trims.iter().map(trim_json).collect();
    if !built.products.levels.is_empty() {
        report["levels"] = level_report(built);
    }
    if let (Value::Object(report), Value::Object(head)) = (&mut report, head(task, "built")) {
        report.extend(head);
    }
    report
}

/// A trim, and how it rides.
pub fn trim_json(trim: &BoundTrim) -> Value {
    let (pieces, rigid, gap) = (trim.ride.pieces(), trim.ride.rigid(), trim.ride.gap);
    json!({ "prim": trim.prim, "name": trim.name, "pieces": pieces, "rigid": rigid, "gap": gap })
}
