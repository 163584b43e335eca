//! Packages (`.usdz`): a crate and the files that it uses.

use super::crates::{encode, remove_unwritable};
use crate::assets::tiles;
use crate::codes;
use crate::read::Files;
use openusd::ar::{ResolvedPath, Resolver};
use openusd::sdf::{AbstractData, AssetPath, Data, Value};
use openusd::usdz::{ArchiveError, ArchiveWriter};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{io, mem};
use tailor_mesh::error::{Error, Warning, Warnings, plain};
use tailor_mesh::files;

/// Endings of the files that a package takes: layers, images, sound, volumes, materials and light profiles. An asset path may
/// name any file of the machine, and others have no use in a stage.
const PACKED: &[&str] = &[
    "usd", "usda", "usdc", "usdz", "png", "jpg", "jpeg", "jfif", "exr", "avif", "hdr", "tif", "tiff", "tx", "tex",
    "rat", "ptx", "ptex", "tga", "bmp", "gif", "webp", "dds", "ktx", "ktx2", "psd", "dpx", "m4a", "mp3", "wav", "vdb",
    "mtlx", "osl", "oso", "sbsar", "ies",
];

/// A package, and the files of which it has a copy.
pub struct PackageData {
    pub bytes: Vec<u8>,
    /// Sorted; entries of other packages as `package[entry]`.
    pub files: Vec<PathBuf>,
}

/// The layer `data`, whose asset paths are absolute, and the files that it uses, as a package. The layer is called `stem`, and its
/// asset paths become those of entries.
///
/// # Errors
/// A value that a crate cannot hold. A file that cannot be read, or is of no kind that stages use, becomes a warning.
pub fn package(data: &mut Data, stem: &str) -> Result<(PackageData, Warnings), Error> {
    let mut package = Package::default();
    package.collect(data);
    package.warnings.extend(remove_unwritable(data));
    let layer = encode(data)?;
    // Built in memory, as the archive's writer reports a full disk on standard error.
    let mut whole = io::Cursor::new(Vec::with_capacity(layer.len()));
    let mut archive = ArchiveWriter::new(&mut whole);
    let fault = |e: ArchiveError| Error::usd(format!("the package cannot be built: {e}")).code(codes::WRITE_FAILED);
    archive.add_layer(&format!("{stem}.usdc"), &layer).map_err(fault)?;
    for (name, bytes) in &package.entries {
        archive.add_layer(name, bytes).map_err(fault)?;
    }
    archive.finish().map_err(fault)?;
    package.files.sort();
    Ok((PackageData { bytes: whole.into_inner(), files: package.files }, package.warnings))
}

/// The files of a package besides its layer.
#[derive(Default)]
struct Package {
    /// Names and contents.
    entries: Vec<(String, Vec<u8>)>,
    /// The files of the entries.
    files: Vec<PathBuf>,
    /// Name of the entry of each file.
    names: BTreeMap<String, String>,
    /// Warnings of files that are not packed.
    warnings: Warnings,
}

impl Package {
    /// Collects the files that `data` uses, and changes its asset paths to their entries.
    fn collect(&mut self, data: &mut Data) {
        for path in data.spec_paths() {
            for (_, value) in data.spec_mut(&path).into_iter().flat_map(|spec| &mut spec.fields) {
                let files = mem::replace(value, Value::ValueBlock);
                *value = files.map_asset_paths(&mut |asset| self.packed(asset));
            }
        }
    }

    /// The path of a file's entry.
    fn packed(&mut self, asset: AssetPath) -> AssetPath {
        let file = asset.as_str();
        if !Path::new(file).is_absolute() {
            return asset;
        }
        match self.entry(file) {
            Ok(name) => AssetPath::new(name),
            Err(e) => {
                let (place, why) = (format!("the file @{file}@"), format!("it cannot be packed: {e}"));
                self.warnings.push(Warning::not_carried(place, why));
                asset
            }
        }
    }

    /// The entry of a file, which is read once. The tiles of a texture share a folder.
    fn entry(&mut self, file: &str) -> Result<String, String> {
        if let Some(name) = self.names.get(file) {
            return Ok(name.clone());
        }
        let folder = self.names.len().to_string();
        let path = file.trim_end_matches(']');
        let ending = path.rsplit_once('.').map_or("", |(_, ending)| ending);
        if !PACKED.iter().any(|packed| packed.eq_ignore_ascii_case(ending)) {
            return Err("its name does not end as that of a layer, an image, a sound, a volume or a material".into());
        }
        let name = format!("{folder}/{}", path.rsplit_once(['/', '[']).map_or(path, |(_, last)| last));
        let tiled = tiles(Path::new(file));
        if tiled.is_empty() {
            self.entries.push((name.clone(), bytes(file)?));
            self.files.push(PathBuf::from(file));
        }
        for tile in tiled {
            let tile_name = tile.file_name().and_then(|n| n.to_str()).expect("tiles have UTF-8 names");
            let content = files::read(&tile).map_err(|e| plain(&e))?;
            self.entries.push((format!("{folder}/{tile_name}"), content));
            self.files.push(tile);
        }
        self.names.insert(file.to_owned(), name.clone());
        Ok(name)
    }
}

/// The content of a file, or of an entry of a package (`package[entry]`).
fn bytes(file: &str) -> Result<Vec<u8>, String> {
    let content = Files::default().open_asset(&ResolvedPath::new(file)).and_then(|mut asset| asset.read_all());
    content.map_err(|e| plain(&e))
}
