//! The presets beside the garment: `coat.presets.json` for `coat.usda`.

use crate::document::Options;
use crate::hub::Hub;
use crate::messages::{PresetSavedMessage, PresetsMessage, ServerMessage};
use crate::presets::Presets;
use crate::stage::Stage;
use std::io;
use std::path::{Path, PathBuf};
use tailor_mesh::error::{Error, ErrorKind, plain};
use tailor_mesh::files;
use tailor_usd::write_whole;

/// The file of a garment's presets.
pub fn file_of(stage: &Stage) -> PathBuf {
    stage.source.file().with_extension("presets.json")
}

/// Reads the file of presets and shows them, or its fault.
pub fn read(hub: &Hub) {
    let _reading = hub.reading();
    let stage = hub.snapshot().stage;
    hub.show_presets(parsed(&file_of(&stage)).and_then(|saved| message(&stage, &saved)));
}

/// Saves a preset and shows it, or takes it out without values.
pub fn save(hub: &Hub, kind: &str, name: &str, values: Option<&Options>) -> PresetSavedMessage {
    let _reading = hub.reading();
    let stage = hub.snapshot().stage;
    let file = file_of(&stage);
    let fault = match written(&stage, &file, (kind, name), values) {
        Ok(message) => {
            hub.show_presets(Ok(message));
            None
        }
        Err(error) => error.faults.into_iter().next(),
    };
    let file = file.display().to_string();
    PresetSavedMessage { name: name.into(), file, removed: values.is_none(), fault }
}

/// The presets of a file; none without the file.
fn parsed(file: &Path) -> Result<Presets, Error> {
    match files::text(file) {
        Ok(text) => Presets::parse(file, &text),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(Presets::default()),
        Err(e) => {
            let fault = Error::recipe(file.display(), format!("cannot be read: {}", plain(&e)));
            Err(fault.code(tailor_costume::codes::RECIPE_FILE).remedy("check the file").caused_by(e))
        }
    }
}

/// Changes the file, and gives the message of what it then holds. A file with a fault is not replaced.
fn written(stage: &Stage, file: &Path, (kind, name): (&str, &str), values: Option<&Options>) -> Result<String, Error> {
    let mut presets = parsed(file)?;
    match values {
        Some(values) => presets.put(kind, name, values, stage.checks.garment().units)?,
        None => presets.remove(kind, name),
    }
    let text = presets.to_text();
    // What is written can be read.
    let presets = Presets::parse(file, &text)?;
    write_whole(file, text.as_bytes(), true).map_err(|e| {
        Error::new(ErrorKind::Usage, file.display(), format!("cannot be written: {}", plain(&e)))
            .code(tailor_usd::codes::WRITE_FAILED)
            .remedy("allow the program to write to the garment's folder")
            .caused_by(e)
    })?;
    message(stage, &presets)
}

fn message(stage: &Stage, saved: &Presets) -> Result<String, Error> {
    let units = stage.checks.garment().units;
    let (built_in, saved) = (Presets::built_in()?.in_units(units), saved.in_units(units));
    let file = file_of(stage).display().to_string();
    Ok(ServerMessage::Presets(PresetsMessage { file, built_in: &built_in, saved: &saved }).to_text())
}
