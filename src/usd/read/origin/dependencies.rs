//! The files that a stage uses under any selection of variants, so that none of them is written over.

use super::resolver::{Files, package_file};
use crate::assets::{ARGUMENTS, Identity, as_named, frames, normalized, tiles};
use crate::names;
use crate::on_large_stack;
use crate::values::text;
use openusd::ar::{ResolvedPath, Resolver};
use openusd::sdf::{self, AbstractData, FieldKey, Layer, Value};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use tailor_mesh::error::Error;

/// Layers that are opened for one stage. More take minutes.
const MAX_LAYERS: usize = 10_000;
/// The entry of a clip set that is a pattern of file names.
const TEMPLATE: &str = "templateAssetPath";
/// The fields with the values of an attribute.
const VALUES: [&str; 2] = ["default", "timeSamples"];

/// An asset path without the arguments of its file format.
pub fn without_arguments(asset_path: &str) -> &str {
    asset_path.split(ARGUMENTS).next().unwrap_or_default()
}

/// The first of `targets` that the stage in the file `stage` uses: itself, and all that its layers name, in all variants, and
/// the layers of these in turn. Targets that do not exist are not used.
///
/// # Errors
/// A stage of too many layers.
pub fn first_used(stage: &Path, targets: &[PathBuf]) -> Result<Option<usize>, Error> {
    let places = targets.iter().enumerate().filter_map(|(i, target)| Some((Identity::of(target)?, i)));
    let targets: HashMap<Identity, usize> = places.collect();
    if targets.is_empty() {
        return Ok(None);
    }
    let Ok(name) = as_named(stage) else { return Ok(None) };
    on_large_stack(|| {
        let mut reach =
            LayerDependencies { files: Files::default(), targets, seen: HashSet::new(), open: Vec::new(), found: None };
        reach.name(&name, None);
        let mut layers = 0;
        while let Some(layer) = reach.open.pop().filter(|_| reach.found.is_none()) {
            layers += 1;
            if layers > MAX_LAYERS {
                let text =
                    format!("{name} uses more than {MAX_LAYERS} layers, so the list of its files would be incomplete");
                return Err(Error::usd(text).remedy("write to a file that does not exist yet"));
            }
            reach.read(&layer);
        }
        Ok(reach.found)
    })
}

/// Whether the values of an attribute name files. Those of others are not read, as points are most of a layer.
fn holds_files(data: &dyn AbstractData, path: &sdf::Path) -> bool {
    match data.try_field(path, FieldKey::TypeName.as_str()) {
        Ok(Some(type_name)) => text(&type_name).is_none_or(|name| name.starts_with("asset")),
        _ => true,
    }
}

/// The file of a body that is named by a text.
fn body(data: &dyn AbstractData, path: &sdf::Path, field: &str) -> Option<String> {
    text(data.try_field(path, field).ok()??.as_ref()).map(str::to_owned)
}

/// The files that were found so far.
struct LayerDependencies {
    files: Files,
    targets: HashMap<Identity, usize>,
    /// Identifiers of the files that were found.
    seen: HashSet<String>,
    /// Those of them that are layers and were not read yet.
    open: Vec<String>,
    /// The target that was found.
    found: Option<usize>,
}

impl LayerDependencies {
    /// Reads all that a layer names. One that cannot be read names nothing.
    fn read(&mut self, identifier: &str) {
        let Ok(layer) = Layer::open_with(Files::default(), identifier) else { return };
        let anchor = ResolvedPath::new(layer.resolved_path().unwrap_or(identifier));
        let data = layer.data();
        for path in data.spec_paths() {
            let holds_files = holds_files(data, &path);
            let is_body = path.as_str().rsplit_once('.').is_some_and(|(_, name)| names::is_body(name));
            for field in data.list_fields(&path).unwrap_or_default() {
                let is_value = VALUES.contains(&field.as_str());
                if !holds_files && !is_body && is_value {
                    continue;
                }
                if let Some(body) = body(data, &path, &field).filter(|_| is_body && is_value) {
                    self.name(&body, Some(&anchor));
                    continue;
                }
                if let Ok(Some(value)) = data.try_field(&path, &field) {
                    self.value(&field, &value, &anchor);
                }
            }
        }
    }

    fn value(&mut self, key: &str, value: &Value, anchor: &ResolvedPath) {
        match value {
            Value::StringVec(layers) if key == FieldKey::SubLayers.as_str() => {
                layers.iter().for_each(|layer| self.name(layer, Some(anchor)));
            }
            Value::ReferenceListOp(all) => all.iter().for_each(|one| self.name(&one.asset_path, Some(anchor))),
            Value::PayloadListOp(all) => all.iter().for_each(|one| self.name(&one.asset_path, Some(anchor))),
            Value::Payload(one) => self.name(&one.asset_path, Some(anchor)),
            Value::AssetPath(asset) => self.name(asset.asset_path(), Some(anchor)),
            Value::AssetPathVec(assets) => assets.iter().for_each(|one| self.name(one.asset_path(), Some(anchor))),
            Value::String(pattern) if key == TEMPLATE => self.pattern(pattern, anchor),
            Value::Dictionary(entries) | Value::UnregisteredDictionary(entries) => {
                entries.iter().for_each(|(key, value)| self.value(key, value, anchor));
            }
            Value::TimeSamples(samples) => samples.iter().for_each(|(_, value)| self.value(key, value, anchor)),
            Value::ValueVec(values) => values.iter().for_each(|value| self.value(key, value, anchor)),
            _ => {}
        }
    }

    /// A file that a layer names, or the tiles of one.
    fn name(&mut self, name: &str, anchor: Option<&ResolvedPath>) {
        let name = without_arguments(name);
        if name.is_empty() {
            return;
        }
        let found = self.files.create_identifier(name, anchor);
        let tiles = tiles(Path::new(&found));
        if tiles.is_empty() {
            self.file(found);
        }
        tiles.iter().for_each(|tile| self.file(tile.to_string_lossy().into_owned()));
    }

    /// The files of a pattern of value clips.
    fn pattern(&mut self, pattern: &str, anchor: &ResolvedPath) {
        let folder = anchor.parent().unwrap_or(Path::new(""));
        for frame in frames(&normalized(&folder.join(pattern))) {
            self.file(frame.to_string_lossy().into_owned());
        }
    }

    fn file(&mut self, identifier: String) {
        if self.seen.contains(&identifier) {
            return;
        }
        let file = package_file(Path::new(&identifier));
        if let Some(target) = Identity::of(&file).and_then(|file| self.targets.get(&file)) {
            self.found = Some(*target);
        }
        let inner = Path::new(identifier.trim_end_matches(']')).extension().and_then(|e| e.to_str());
        if inner.is_some_and(|e| ["usd", "usda", "usdc", "usdz"].iter().any(|usd| e.eq_ignore_ascii_case(usd))) {
            self.open.push(identifier.clone());
        }
        self.seen.insert(identifier);
    }
}
