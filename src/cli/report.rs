//! Writes the JSON report of a build.

use super::build::{Built, Outcome, Task};
use super::{text, usage};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tailor::error::{Error, ErrorCode, plain};

/// Checks that a report may be written to `file`, before the build starts.
///
/// # Errors
/// A name that does not end in `.json`, which protects garments, layers and recipes; a file that exists, unless
/// `force`; a folder; a missing parent folder.
pub fn check_target(file: &Path, force: bool) -> Result<(), Error> {
    let shown = file.display();
    let fault = |fault: &str, remedy: &str| Err(usage("", fault).code(ErrorCode::OutputPath).remedy(remedy));
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
        let exists = usage("", format!("report {shown} exists already")).code(ErrorCode::OutputExists);
        return Err(exists.remedy("overwrite it with --force"));
    }
    let folder = folder(file);
    if !folder.is_dir() {
        let fault_text = format!("cannot write report {shown}: there is no folder {}", folder.display());
        return fault(&fault_text, "create the folder first");
    }
    Ok(())
}

/// Writes the report of all builds atomically: the file is complete or absent. A link is replaced, so its target does
/// not change.
///
/// # Errors
/// A folder without write permission; a full disk.
pub fn write(file: &Path, tasks: &[Task], outcomes: &[Outcome]) -> Result<(), Error> {
    let mut reports: Vec<Value> = tasks.iter().zip(outcomes).map(|(task, outcome)| report(task, outcome)).collect();
    let report = if reports.len() == 1 { reports.swap_remove(0) } else { json!({ "builds": reports }) };
    let mut text = serde_json::to_string_pretty(&report).map_err(|e| Error::internal(e.to_string()))?;
    text.push('\n');
    write_whole(file, &text).map_err(|e| {
        let fault = usage("", format!("cannot write report {}: {}", file.display(), plain(&e)));
        fault
            .code(ErrorCode::WriteFailed)
            .remedy("check the folder's permissions and the space on its disk")
            .caused_by(e)
    })
}

fn write_whole(file: &Path, text: &str) -> io::Result<()> {
    if is_device(file) {
        return fs::write(file, text);
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".usdtailor-").suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // The permissions of any new file; temporary files are private to their owner.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let mut temporary = builder.tempfile_in(folder(file))?;
    temporary.write_all(text.as_bytes())?;
    temporary.persist(file).map(drop).map_err(|e| e.error)
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
        Outcome::Fresh => head(task, "fresh"),
        Outcome::Failed(error) => {
            let faults = error
                .faults
                .iter()
                .map(|f| json!({ "code": f.code, "place": f.place, "problem": f.text, "remedy": f.remedy }));
            let mut report = head(task, "failed");
            report["error"] = json!({ "message": error.to_string(), "faults": faults.collect::<Vec<_>>() });
            report
        }
    }
}

fn head(task: &Task, status: &str) -> Value {
    json!({
        "input": task.input.display().to_string(),
        "output": task.output.display().to_string(),
        "status": status,
    })
}

/// The report of an output that was written.
pub fn built(task: &Task, built: &Built) -> Value {
    let p = &built.products;
    let mut report = json!({
        "recipe": p.recipe,
        "sim": built.sim,
        "remesh": p.remesh(),
        "render": built.render,
        "cloth": built.cloth,
        "operatorFaces": text::operator_sets(p).into_iter().collect::<BTreeMap<_, _>>(),
        "stages": built.timings,
        "warnings": built.warnings.iter().map(text::warning_json).collect::<Vec<_>>(),
    });
    if let (Value::Object(report), Value::Object(head)) = (&mut report, head(task, "built")) {
        report.extend(head);
    }
    report
}
