//! The report of a build as JSON.

use super::build::Built;
use super::text;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tailor::error::{Error, plain};

/// Whether a report may be written to `file`, before the work that leads there.
///
/// # Errors
/// A name that does not end in `.json`, so that no garment, layer or recipe is taken for a report; a file that is
/// there already, unless `force`; a folder, or one that is missing.
pub fn check_target(file: &Path, force: bool) -> Result<(), Error> {
    let shown = file.display();
    let fault = |fault: &str, hint: &str| Err(Error::Usage(format!("{fault}\n  hint: {hint}")));
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
        return fault(&format!("report {shown} exists already"), "overwrite it by --force");
    }
    let folder = folder(file);
    if !folder.is_dir() {
        let fault_text = format!("cannot write report {shown}: there is no folder {}", folder.display());
        return fault(&fault_text, "create the folder first");
    }
    Ok(())
}

/// Writes the report of all builds; the file is complete or is not there. A link is replaced, not followed, so that
/// nothing else than the named file changes.
///
/// # Errors
/// A folder that cannot be written to, a full disk.
pub fn write(file: &Path, all: &[Built]) -> Result<(), Error> {
    let mut reports: Vec<Value> = all.iter().map(report).collect();
    let report = if reports.len() == 1 { reports.swap_remove(0) } else { json!({ "builds": reports }) };
    let mut text = serde_json::to_string_pretty(&report).map_err(|e| Error::Internal(e.to_string()))?;
    text.push('\n');
    write_whole(file, &text).map_err(|e| {
        Error::Usage(format!(
            "cannot write report {}: {}\n  hint: check the folder's permissions and the space on its disk",
            file.display(),
            plain(&e)
        ))
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
        // As any new file: temporary ones are their owner's alone.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let mut temporary = builder.tempfile_in(folder(file))?;
    temporary.write_all(text.as_bytes())?;
    temporary.persist(file).map(drop).map_err(|e| e.error)
}

/// Whether a path leads to something that is written to as it is: a terminal, a pipe, `/dev/null`.
fn is_device(file: &Path) -> bool {
    fs::metadata(file).is_ok_and(|m| !m.is_file() && !m.is_dir())
}

fn folder(file: &Path) -> PathBuf {
    match file.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
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
        "operatorFaces": text::made(p).into_iter().collect::<BTreeMap<_, _>>(),
        "stages": p.stages,
        "warnings": built.warnings.iter().map(text::warning_json).collect::<Vec<_>>(),
    })
}
