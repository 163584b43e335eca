//! Layers that the USD library cannot read, as another program writes them anew.
//!
//! A layer is converted, and the stage is not flattened: its paths, its variants and the layers below it stay what they are.

use super::resolver::Files;
use crate::codes;
use openusd::pcp::CompositionDiagnostic::{MalformedLayer, MalformedSublayer};
use openusd::sdf::Layer;
use openusd::usd::Stage;
use std::path::Path;
use std::sync::{Arc, OnceLock};
use tailor_mesh::error::{Error, Warning};

/// Writes a layer anew as a crate, by its path: a file, or an entry of a package as `package[entry]`. The result is the content and
/// the name of the program; none where no program can.
pub type Converter = fn(&str) -> Option<(Vec<u8>, String)>;

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

/// A layer that was converted.
#[derive(Clone, Debug)]
pub struct Converted {
    pub content: Arc<[u8]>,
    /// The program that did it.
    program: String,
    /// Why the library cannot read it.
    fault: String,
}

impl Converted {
    /// A layer that the library cannot read; none of one that it reads, or that cannot be converted.
    pub fn of(layer: &str) -> Option<Self> {
        let fault = check(Layer::open_with(Files::default(), layer).map_err(|e| e.to_string())).err()?;
        let (content, program) = CONVERTER.get()?(layer)?;
        check(Layer::from_bytes("converted", content.clone()).map_err(|e| e.to_string())).ok()?;
        Some(Self { content: content.into(), program, fault })
    }

    /// The note about it.
    pub fn note(&self, layer: &Path) -> Warning {
        // The other lines show the place.
        let fault = self.fault.trim_start_matches("error: ").lines().next().unwrap_or_default();
        let problem = format!("read by {}, as this program cannot: {fault}", self.program);
        let remedy = "Write it again by `usdcat -o` to do without OpenUSD; --no-fallback refuses it";
        Warning::new(codes::CONVERTED_LAYER, layer.display(), problem).remedy(remedy)
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

/// Whether an error is of a layer that the library cannot read.
pub fn is_unread(error: &Error) -> bool {
    let unread = [tailor_mesh::codes::DAMAGED_FILE, codes::NOT_SUPPORTED];
    error.faults.iter().any(|fault| unread.contains(&fault.code))
}

/// Whether a stage lacks a layer that the library cannot read, among those of the prims that are composed so far.
pub fn lacks_layers(stage: &Stage) -> bool {
    let of = |fault: &_| match fault {
        MalformedLayer { asset_path, .. } | MalformedSublayer { asset_path, .. } => is_layer(Path::new(asset_path)),
        _ => false,
    };
    stage.composition_errors().iter().any(of)
}

/// Whether a path is of USD by its name, or of an entry of a package that is.
pub fn is_layer(path: &Path) -> bool {
    let path = path.to_string_lossy().to_ascii_lowercase();
    [".usd", ".usda", ".usdc", ".usdz"].iter().any(|end| path.trim_end_matches(']').ends_with(end))
}
