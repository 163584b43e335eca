//! Layers and stages that the USD library cannot read: another program writes them anew.
//!
//! Layers are converted one by one: paths, variants and the layers below stay what they are. Where that does not help, as for edits of
//! arrays and for packages in packages, the whole stage is flattened, and stands for the layer of its file.

use super::resolver::Files;
use crate::codes;
use openusd::pcp::CompositionDiagnostic::{MalformedLayer, MalformedSublayer};
use openusd::sdf::Layer;
use openusd::usd::Stage;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use tailor_mesh::error::{Error, Warning};

/// A layer or a stage that another program is to write anew as a crate.
#[derive(Clone, Copy, Debug)]
pub struct Foreign<'a> {
    /// The layer: a file, or an entry of a package as `package[entry]`.
    pub path: &'a str,
    /// Whether it is the stage of this file, flattened. One with variants is not, as those that are not selected would be lost.
    pub is_stage: bool,
}

/// A crate that another program wrote.
#[derive(Clone, Debug)]
pub struct Rewritten {
    /// The crate.
    pub content: Arc<[u8]>,
    /// The name of the program.
    pub program: String,
    /// The files of the layers of a stage.
    pub files: Vec<PathBuf>,
}

/// Writes a layer or a stage anew: none where no program can, and an error where the program was ended.
pub type Converter = fn(Foreign<'_>) -> Result<Option<Rewritten>, String>;

static CONVERTER: OnceLock<Converter> = OnceLock::new();

/// Lets layers that the library cannot read be converted, in this process. Without it, they are errors.
pub fn set_converter(converter: Converter) {
    // The first one stays.
    let _ = CONVERTER.set(converter);
}

/// Whether there is a converter.
pub fn has_converter() -> bool {
    CONVERTER.get().is_some()
}

/// A layer or a stage that was converted.
#[derive(Clone, Debug)]
pub struct Converted {
    /// What another program wrote, or why it was ended.
    pub result: Result<Rewritten, String>,
    /// Why the library cannot read it.
    fault: String,
    /// Whether it is a whole stage.
    pub is_stage: bool,
}

impl Converted {
    /// A layer that the library cannot read; none of one that it reads, or that cannot be converted.
    pub fn of_layer(layer: &str) -> Option<Self> {
        let fault = check(Layer::open_with(Files::default(), layer).map_err(|e| e.to_string())).err()?;
        Self::of(layer, false, fault)
    }

    /// A layer or a stage, which the library cannot read for this reason; none where it cannot be converted.
    pub fn of(path: &str, is_stage: bool, fault: String) -> Option<Self> {
        let result = CONVERTER.get()?(Foreign { path, is_stage }).transpose()?;
        if let Ok(Rewritten { content, .. }) = &result {
            check(Layer::from_bytes("converted", content.to_vec()).map_err(|e| e.to_string())).ok()?;
        }
        Some(Self { result, fault, is_stage })
    }

    /// The note about it.
    pub fn note(&self, place: &Path) -> Warning {
        // The name of the file is before, and the other lines show the place.
        let fault = self.fault.rsplit("read as USD: ").next().unwrap_or_default();
        let fault = fault.trim_start_matches("error: ").lines().next().unwrap_or_default();
        let (how, command) = if self.is_stage { ("flattened", "usdcat --flatten -o") } else { ("read", "usdcat -o") };
        let problem = match &self.result {
            Ok(Rewritten { program, .. }) => format!("{how} by {program}, as this program cannot read it: {fault}"),
            Err(ended) => format!("{ended}; this program cannot read it: {fault}"),
        };
        let remedy = format!("Write it again by `{command}` to do without OpenUSD; --no-fallback refuses it");
        Warning::new(codes::CONVERTED_LAYER, place.display(), problem).remedy(remedy)
    }
}

/// The library's words where it cannot read a layer, or one of its values.
fn check(layer: Result<Layer, String>) -> Result<(), String> {
    let layer = layer?;
    let data = layer.data();
    for path in data.spec_paths() {
        for field in data.list_fields(&path).unwrap_or_default() {
            data.try_field(&path, &field).map_err(|e| e.to_string())?;
        }
    }
    Ok(())
}

/// The fault of an error that is of what the library cannot read.
pub fn unread(error: &Error) -> Option<String> {
    let unread = [tailor_mesh::codes::DAMAGED_FILE, codes::NOT_SUPPORTED, codes::COMPOSITION_FAILED];
    error.faults.iter().find(|fault| unread.contains(&fault.code)).map(|fault| fault.text.clone())
}

/// The fault of a stage that lacks a layer that the library cannot read, among those of the prims that are composed so far.
pub fn lacking(stage: &Stage) -> Option<String> {
    stage.composition_errors().iter().find_map(|fault| match fault {
        MalformedLayer { asset_path, .. } | MalformedSublayer { asset_path, .. } => {
            is_layer(Path::new(asset_path)).then(|| format!("{asset_path} cannot be read"))
        }
        _ => None,
    })
}

/// Whether a path is of USD by its name, or of an entry of a package that is.
pub fn is_layer(path: &Path) -> bool {
    let path = path.to_string_lossy().to_ascii_lowercase();
    [".usd", ".usda", ".usdc", ".usdz"].iter().any(|end| path.trim_end_matches(']').ends_with(end))
}
