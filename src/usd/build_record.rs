//! The sources of an output: `build` writes them into the layer, so that a later run can tell whether the output is fresh.

use super::assets::{Anchor, as_named, file_path, normalized};
use super::read::{Files, OrUnreadable, Selection, Source, VariantSet};
use super::{names, on_large_stack};
use openusd::sdf::{self, AbstractData, FieldKey, Value};
use serde_json::Value as Json;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use tailor_mesh::error::{Error, Warning, plain};
use tailor_mesh::files::{self, folder_of};

/// Key of the record in the dictionary of this program in `customLayerData`.
const KEY: &str = "build";
/// Most bytes of the files of one record that are read. Larger ones are taken for changed.
const MAX_HASHED: u64 = 8 << 30;
/// This program.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The sources of an output.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BuildRecord {
    /// Version of the program that wrote the output.
    version: String,
    /// The request: equal for builds with the same options.
    request: String,
    /// Path of the mesh.
    prim: String,
    /// The selected variants, as `prim{set=choice}`.
    variants: Vec<String>,
    /// The warnings of the build as JSON.
    warnings: Vec<String>,
    /// The state of each file, by its path from the output's folder.
    files: BTreeMap<String, FileState>,
}

/// A warning as JSON: its code, data and text.
pub fn warning_json(warning: &Warning) -> Json {
    let mut json = serde_json::to_value(warning).unwrap_or_default();
    json["message"] = Json::String(warning.to_string());
    json
}

/// An output that is stale.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stale {
    /// The output.
    pub output: PathBuf,
    /// Why a build would write something else.
    pub changes: Vec<String>,
}

/// The first stale output of some with their records. `more` adds to the changes of one.
fn first_stale(
    records: impl IntoIterator<Item = (PathBuf, BuildRecord)>,
    more: impl Fn(&BuildRecord) -> Vec<String>,
) -> Result<Option<Stale>, Error> {
    for (output, record) in records {
        let changes: Vec<String> = record.changes(&output)?.into_iter().chain(more(&record)).collect();
        if !changes.is_empty() {
            return Ok(Some(Stale { output, changes }));
        }
    }
    Ok(None)
}

/// The size of a file and the hash of its content.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct FileState {
    bytes: u64,
    /// Empty for a file that was written to while it was read, or that is too large.
    hash: String,
}

impl BuildRecord {
    /// The record of an output in `out` that is made of `sources`, garments of one stage, and the files `recipes`, none of which
    /// was read before `started`. `request` tells the options of the build; equal options are the same text.
    ///
    /// # Errors
    /// A file that cannot be read any more.
    pub fn new(
        sources: &[Source],
        recipes: &[PathBuf],
        request: String,
        out: &Path,
        started: SystemTime,
    ) -> Result<Self, Error> {
        let folder = folder(out)?;
        let (mut files, mut left) = (BTreeMap::new(), MAX_HASHED);
        let path = |file: &Path| Ok::<_, Error>(Anchor::real(&folder).path_to(&as_named(file)?));
        // Garments of one stage use the same layers, those of other variants use others.
        for source in sources {
            let origin = &source.model.origin;
            origin.check_unchanged()?;
            for file in &source.model.layers {
                let state = match origin.read.content(file) {
                    Some((bytes, hash)) => FileState { bytes, hash },
                    None => FileState::unchanged(file, started, &mut left)?,
                };
                files.insert(path(file)?, state);
            }
        }
        for file in recipes {
            files.insert(path(file)?, FileState::unchanged(file, started, &mut left)?);
        }
        let prim = sources.first().map(|source| source.prim().to_owned()).unwrap_or_default();
        let mut variants: Vec<String> =
            sources.iter().flat_map(|source| selections(&source.facts().variants)).collect();
        let mut seen = BTreeSet::new();
        variants.retain(|variant| seen.insert(variant.clone()));
        Ok(Self { version: VERSION.into(), request, prim, variants, warnings: Vec::new(), files })
    }

    /// The record of an output that has products for these variants too.
    #[must_use]
    pub(super) fn with_variants(&self, variants: impl Iterator<Item = Selection>) -> Self {
        let mut record = self.clone();
        for variant in variants.map(|selection| in_words(&selection)) {
            if !record.variants.contains(&variant) {
                record.variants.push(variant);
            }
        }
        record
    }

    /// The record of an output with these warnings too.
    #[must_use]
    pub fn with_warnings<'a>(mut self, warnings: impl IntoIterator<Item = &'a Warning>) -> Self {
        warnings.into_iter().for_each(|warning| self.add_warning(warning_json(warning).to_string()));
        self
    }

    fn add_warning(&mut self, text: String) {
        if !self.warnings.contains(&text) {
            self.warnings.push(text);
        }
    }

    /// The warnings of the build as [`warning_json`] has them.
    pub fn warnings(&self) -> impl Iterator<Item = Json> {
        self.warnings.iter().filter_map(|warning| serde_json::from_str(warning).ok())
    }

    /// The record of an output that is made of all that several records are of, at least one, with the same request.
    pub fn of_all(records: Vec<Self>) -> Self {
        let mut all = records.into_iter();
        let mut first = all.next().unwrap_or_default();
        for other in all {
            first.files.extend(other.files);
            other.warnings.into_iter().for_each(|warning| first.add_warning(warning));
        }
        first
    }

    /// The record in the layer `out`; none in a layer without one, or that cannot be opened.
    pub fn of(out: &Path) -> Option<Self> {
        let path = out.to_str()?.to_owned();
        on_large_stack(|| {
            let layer = sdf::Layer::open_with(Files::default(), path).map_err(|e| Error::usd(e.to_string()))?;
            Ok(Self::in_layer(&layer))
        })
        .ok()?
    }

    /// The layers in use by a garment's stage that this program built, and what they were made of. The stage is opened again.
    ///
    /// # Errors
    /// A stage that can no longer be opened.
    fn in_use(source: &Source) -> Result<Vec<(PathBuf, Self)>, Error> {
        on_large_stack(|| {
            let stage = source.model.origin.open()?;
            let of_layer = |id: &String| {
                let layer = stage.layer(id)?;
                Some((PathBuf::from(file_path(layer.resolved_path()?)), Self::in_layer(&layer)?))
            };
            Ok(stage.layer_identifiers().iter().filter_map(of_layer).collect())
        })
    }

    /// The path of `file` in the record of `out`.
    ///
    /// # Errors
    /// A folder that does not exist.
    pub fn path_of(file: &Path, out: &Path) -> Result<String, Error> {
        Ok(Anchor::real(&folder(out)?).path_to(&as_named(file)?))
    }

    /// The file of such a path.
    ///
    /// # Errors
    /// As [`BuildRecord::path_of`].
    pub fn file_of(path: &str, out: &Path) -> Result<PathBuf, Error> {
        Ok(folder(out)?.join(path))
    }

    /// The options of the build.
    pub fn request(&self) -> &str {
        &self.request
    }

    /// The record of the output `out`, if this program made it by the same request, and would make it so again.
    pub fn fresh(out: &Path, request: &str) -> Option<Self> {
        Self::of(out).filter(|record| record.request == request && record.stale(out).is_ok_and(|stale| stale.is_none()))
    }

    /// The first stale output among `out` with this record and the outputs that it was made of, and why it is stale.
    ///
    /// # Errors
    /// A folder that is gone.
    pub fn stale(&self, out: &Path) -> Result<Option<Stale>, Error> {
        let folder = folder(out)?;
        let below = self.files.keys().map(|file| normalized(&folder.join(file)));
        let below = below.filter_map(|file| Self::of(&file).map(|record| (file, record)));
        let all = std::iter::once((out.to_path_buf(), self.clone())).chain(below);
        first_stale(all, |_| Vec::new())
    }

    /// The first stale output among the layers in use by a garment's stage; none where no layer is an output. An output that is
    /// selected by other variants than it was made for is stale too.
    ///
    /// # Errors
    /// A stage that can no longer be opened.
    pub fn stale_in_use(source: &Source) -> Result<Option<Option<Stale>>, Error> {
        let records = Self::in_use(source)?;
        let of_variants = |record: &Self| {
            if record.prim == source.prim() { record.variant_changes(source) } else { Vec::new() }
        };
        if records.is_empty() { Ok(None) } else { first_stale(records, of_variants).map(Some) }
    }

    /// Why the output `out` with this record is stale, in words; empty if a build with the same options would write it
    /// again.
    fn changes(&self, out: &Path) -> Result<Vec<String>, Error> {
        let folder = folder(out)?;
        let (mut changes, mut left) = (Vec::new(), MAX_HASHED);
        if self.version != VERSION {
            changes.push(format!("usdtailor {} made it, and this is {VERSION}", self.version));
        }
        for (path, recorded) in &self.files {
            match recorded.is_of(&folder.join(path), &mut left) {
                Err(_) => changes.push(format!("{path} cannot be read any more")),
                Ok(false) => changes.push(format!("{path} has changed")),
                Ok(true) => {}
            }
        }
        Ok(changes)
    }

    /// The variants that are selected now and were not when the output was made; `source` is the mesh as the output shows
    /// it. Sets that the output was made without are of layers over its inputs.
    fn variant_changes(&self, source: &Source) -> Vec<String> {
        let of_set = |selection: &str| selection.rsplit_once('=').map(|(set, _)| format!("{set}="));
        let is_known = |set: String| self.variants.iter().any(|made| made.starts_with(&set));
        let now = selections(&source.facts().variants).into_iter();
        let other = now.filter(|now| of_set(now).is_some_and(is_known) && !self.variants.contains(now));
        other.map(|selection| format!("it is not made for {selection}")).collect()
    }

    /// Path of the mesh.
    pub fn prim(&self) -> &str {
        &self.prim
    }

    /// Adds the record to a layer's own data.
    pub(super) fn author(&self, data: &mut sdf::Data) -> Result<(), Error> {
        let root = sdf::Path::abs_root();
        let known = data.try_field(&root, FieldKey::CustomLayerData.as_str()).or_unreadable(&root)?;
        let mut layer_data = known.and_then(|known| known.into_owned().try_as_dictionary()).unwrap_or_default();
        let ours = layer_data.remove(names::PRODUCT_SPACE).and_then(Value::try_as_dictionary);
        let mut ours = ours.unwrap_or_default();
        ours.insert(KEY.into(), Value::Dictionary(self.dictionary()));
        layer_data.insert(names::PRODUCT_SPACE.into(), Value::Dictionary(ours));
        AbstractData::set_field(data, &root, FieldKey::CustomLayerData.as_str(), Value::Dictionary(layer_data));
        Ok(())
    }

    /// Lists of texts are left out where they are empty: not every reader of crates has empty ones in dictionaries.
    fn dictionary(&self) -> HashMap<String, Value> {
        let (paths, hashes) = self.files.iter().map(|(path, file)| (path.clone(), file.hash.clone())).unzip();
        let own = [("variants", self.variants.clone()), ("warnings", self.warnings.clone())];
        let lists = own.into_iter().chain([("files", paths), ("hashes", hashes)]);
        let lists = lists.filter(|(_, texts)| !texts.is_empty());
        let sizes = self.files.values().map(|file| file.bytes as i64).collect();
        let one = [
            ("version", Value::String(self.version.clone())),
            ("request", Value::String(self.request.clone())),
            ("prim", Value::String(self.prim.clone())),
            ("sizes", Value::Int64Vec(sizes)),
        ];
        let all = lists.map(|(key, texts)| (key, Value::StringVec(texts))).chain(one);
        all.map(|(key, value)| (key.to_owned(), value)).collect()
    }

    fn in_layer(layer: &sdf::Layer) -> Option<Self> {
        let data = layer.data().try_field(&sdf::Path::abs_root(), FieldKey::CustomLayerData.as_str()).ok()??;
        let ours = data.into_owned().try_as_dictionary()?.remove(names::PRODUCT_SPACE)?;
        let record = ours.try_as_dictionary()?.remove(KEY)?.try_as_dictionary()?;
        let text = |key: &str| record.get(key)?.clone().try_as_string();
        let texts = |key: &str| record.get(key).map_or(Some(Vec::new()), |texts| texts.clone().try_as_string_vec());
        let Some(Value::Int64Vec(sizes)) = record.get("sizes") else { return None };
        let (files, hashes) = (texts("files")?, texts("hashes")?);
        (files.len() == hashes.len() && files.len() == sizes.len()).then_some(())?;
        let states = sizes.iter().zip(hashes).map(|(bytes, hash)| FileState { bytes: *bytes as u64, hash });
        Some(Self {
            version: text("version")?,
            request: text("request")?,
            prim: text("prim")?,
            variants: texts("variants")?,
            warnings: texts("warnings")?,
            files: files.into_iter().zip(states).collect(),
        })
    }
}

fn selections(sets: &[VariantSet]) -> Vec<String> {
    sets.iter().map(|set| in_words(&set.selected)).collect()
}

fn in_words(Selection { prim, set, choice }: &Selection) -> String {
    format!("{prim}{{{set}={choice}}}")
}

/// The folder of an output, without links.
fn folder(out: &Path) -> Result<PathBuf, Error> {
    let file = out.canonicalize();
    let folder = folder_of(file.as_deref().unwrap_or(out));
    folder.canonicalize().map_err(|e| {
        let fault = Error::usd(format!("there is no folder {}: {}", folder.display(), plain(&e)));
        fault.remedy("create the folder first")
    })
}

impl FileState {
    /// The state of a file that was read after `started`; without a hash if it was written to since, or is beyond what is `left`.
    fn unchanged(file: &Path, started: SystemTime, left: &mut u64) -> Result<Self, Error> {
        let metadata = files::metadata(file).map_err(|e| unreadable(file, &e))?;
        let (bytes, changed) = (metadata.len(), metadata.modified().is_ok_and(|time| time >= started));
        let is_hashed = !changed && take(left, bytes);
        let hash = is_hashed.then(|| files::hash(file).map_err(|e| unreadable(file, &e)));
        Ok(Self { bytes, hash: hash.transpose()?.unwrap_or_default() })
    }

    /// Whether a file is still in this state. It is read only if it may be, and if its size is within `left`, which it takes.
    fn is_of(&self, file: &Path, left: &mut u64) -> io::Result<bool> {
        let may_be = files::metadata(file)?.len() == self.bytes && !self.hash.is_empty() && take(left, self.bytes);
        Ok(may_be && files::hash(file)? == self.hash)
    }
}

/// Takes `bytes` from `left`, if there are as many.
fn take(left: &mut u64, bytes: u64) -> bool {
    let rest = left.checked_sub(bytes);
    *left = rest.unwrap_or(*left);
    rest.is_some()
}

fn unreadable(file: &Path, e: &io::Error) -> Error {
    let fault = Error::usd(format!("cannot read {}: {}", file.display(), plain(e)));
    fault.remedy("check the path, and who may read the file")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;

    #[test]
    fn files_are_read_only_within_a_bound() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("sparse.usda");
        let sparse = File::create(&file).expect("a file");
        let state = |bytes| FileState { bytes, hash: blake3::hash(b"").to_hex().to_string() };
        assert!(state(0).is_of(&file, &mut 0).expect("a file"));
        sparse.set_len(200 << 30).expect("a sparse file");
        // By its size, and where the record states this size.
        assert!(!state(5).is_of(&file, &mut MAX_HASHED.clone()).expect("a file"));
        assert!(!state(200 << 30).is_of(&file, &mut MAX_HASHED.clone()).expect("a file"));
        assert!(state(0).is_of(folder.path(), &mut MAX_HASHED.clone()).is_err());
    }
}
