//! Files: formats, what may be overwritten, and writes that are complete or not there.

use super::UsdError;
use super::assets::tiles;
use super::crates::{encode, take_out_unwritable, write_crate};
use crate::error::{Warning, Warnings, plain};
use openusd::sdf::{AbstractData, AssetPath, Data, FormatError};
use openusd::usda::TextWriter;
use openusd::usdz::{Archive, ArchiveWriter};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// How a layer is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Text.
    Usda,
    /// Crate, the binary form (`.usdc`, `.usd`).
    Usdc,
    /// A package of a crate and the files that it uses.
    Usdz,
}

impl Format {
    /// The format that a file's name asks for.
    ///
    /// # Errors
    /// Another ending than `.usd`, `.usda`, `.usdc` and `.usdz`.
    pub fn of(file: &Path) -> Result<Self, UsdError> {
        let extension = file.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        match extension.as_str() {
            "usda" => Ok(Self::Usda),
            "usd" | "usdc" => Ok(Self::Usdc),
            "usdz" => Ok(Self::Usdz),
            _ => Err(UsdError::new(format!("{} does not end in .usd, .usda, .usdc or .usdz", file.display()))
                .hint("the name of the output decides its format")),
        }
    }
}

/// A file that may be written.
#[derive(Debug)]
pub struct Target {
    /// As the user named it.
    shown: String,
    /// Its folder, without links.
    pub folder: PathBuf,
    /// Where the bytes go.
    file: PathBuf,
    /// Its format.
    pub format: Format,
}

impl Target {
    /// Checks that `out` may be written.
    ///
    /// # Errors
    /// An unknown format, a folder that is missing, a file that is there already (unless `force`), and, always, one of
    /// the files `layers` under any name.
    pub fn find(out: &Path, layers: &[PathBuf], force: bool) -> Result<Self, UsdError> {
        let shown = out.display().to_string();
        let format = Format::of(out)?;
        // A link is followed, so that what it points at is replaced and not the link.
        let file = out.canonicalize().unwrap_or_else(|_| out.to_path_buf());
        if let Ok(there) = fs::metadata(&file) {
            if layers.iter().any(|layer| same_file(layer, &file)) {
                return Err(UsdError::new(format!("{shown} is the input, or a layer that the input uses"))
                    .hint("write to another file; the input is never changed"));
            }
            if !there.is_file() {
                return Err(UsdError::new(format!("{shown} is not a file")).hint("name a file to be written"));
            }
            if !force {
                return Err(UsdError::new(format!("{shown} exists already")).hint("overwrite it by --force"));
            }
        }
        let folder = match file.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let folder = folder.canonicalize().ok().filter(|f| f.is_dir()).ok_or_else(|| {
            UsdError::new(format!("cannot write {shown}: there is no folder {}", folder.display()))
                .hint("create the folder first")
        })?;
        let file = folder.join(file.file_name().unwrap_or_default());
        Ok(Self { shown, folder, file, format })
    }

    /// Writes the layer `data`.
    ///
    /// # Errors
    /// A folder that cannot be written to, a full disk, a value that the format cannot hold.
    pub fn save(&self, mut data: Data, warnings: &mut Warnings) -> Result<(), UsdError> {
        if self.format == Format::Usda {
            return self.replace(|out| TextWriter::write(&data, out));
        }
        take_out_unwritable(&mut data, warnings);
        self.replace(|out| write_crate(&data, out))
    }

    /// Writes the layer `data`, whose asset paths are absolute, and all files that it uses as a package.
    ///
    /// # Errors
    /// As [`Target::save`].
    pub fn save_package(&self, data: &Data, warnings: &mut Warnings) -> Result<(), UsdError> {
        let stem = self.file.file_stem().and_then(|s| s.to_str()).unwrap_or("layer");
        let mut package = Package::default();
        let mut data = package.collect(data, warnings);
        take_out_unwritable(&mut data, warnings);
        let layer = encode(&data)?;
        // In memory, for the archive's writer tells a full disk in its own words, and on standard error.
        let mut whole = io::Cursor::new(Vec::with_capacity(layer.len()));
        let mut archive = ArchiveWriter::new(&mut whole);
        let fault = |e: openusd::usdz::ArchiveError| UsdError::new(format!("cannot write {}: {e}", self.shown));
        archive.add_layer(&format!("{stem}.usdc"), &layer).map_err(fault)?;
        for (name, bytes) in &package.entries {
            archive.add_layer(name, bytes).map_err(fault)?;
        }
        archive.finish().map_err(fault)?;
        self.replace(|out| Ok(out.write_all(whole.get_ref())?))
    }

    /// Lets `fill` write a file beside the target and puts it in the target's place.
    fn replace(&self, fill: impl FnOnce(&mut BufWriter<&File>) -> Result<(), FormatError>) -> Result<(), UsdError> {
        let fault = |e: &io::Error| {
            UsdError::new(format!("cannot write {}: {}", self.shown, plain(e)))
                .hint("check the folder's permissions and the space on its disk")
        };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".usdtailor-").suffix(".tmp");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = fs::metadata(&self.file).map_or(0o666, |m| m.permissions().mode() & 0o777);
            builder.permissions(fs::Permissions::from_mode(mode));
        }
        let temporary = builder.tempfile_in(&self.folder).map_err(|e| fault(&e))?;
        let mut out = BufWriter::with_capacity(1 << 20, temporary.as_file());
        fill(&mut out).map_err(|e| match e {
            FormatError::Io(e) => fault(&e),
            other => UsdError::new(format!("cannot write {}: {other}", self.shown)),
        })?;
        out.flush().map_err(|e| fault(&e))?;
        drop(out);
        temporary.as_file().sync_all().map_err(|e| fault(&e))?;
        temporary.persist(&self.file).map_err(|e| fault(&e.error))?;
        Ok(())
    }
}

/// Whether two paths lead to the same file, through links of any kind.
fn same_file(a: &Path, b: &Path) -> bool {
    let (Ok(a), Ok(b)) = (a.canonicalize(), b.canonicalize()) else { return false };
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        if let (Ok(a), Ok(b)) = (fs::metadata(&a), fs::metadata(&b)) {
            return a.dev() == b.dev() && a.ino() == b.ino();
        }
    }
    a == b
}

/// The files of a package besides its layer.
#[derive(Default)]
struct Package {
    entries: Vec<(String, Vec<u8>)>,
    /// Name of the entry of each file.
    names: BTreeMap<String, String>,
}

impl Package {
    /// Takes the files that `data` uses, and states their places in the package.
    fn collect(&mut self, data: &Data, warnings: &mut Warnings) -> Data {
        let mut packed = Data::new();
        for path in data.spec_paths() {
            let Some(spec) = data.spec(&path) else { continue };
            packed.create_spec(path.clone(), spec.ty);
            for (key, value) in &spec.fields {
                let value = value.clone().map_asset_paths(&mut |asset| self.place(asset, warnings));
                AbstractData::set_field(&mut packed, &path, key, value);
            }
        }
        packed
    }

    fn place(&mut self, asset: AssetPath, warnings: &mut Warnings) -> AssetPath {
        let file = asset.as_str();
        if !Path::new(file).is_absolute() {
            return asset;
        }
        match self.entry(file) {
            Ok(name) => AssetPath::new(name),
            Err(e) => {
                warnings.push(Warning::NotCarried {
                    what: format!("the file @{file}@"),
                    why: format!("it cannot be packed: {e}"),
                });
                asset
            }
        }
    }

    /// The entry of a file, which is packed when it is met first; all tiles of a tiled texture go together.
    fn entry(&mut self, file: &str) -> Result<String, String> {
        if let Some(name) = self.names.get(file) {
            return Ok(name.clone());
        }
        let folder = self.names.len().to_string();
        let outer = file.split('[').next().unwrap_or(file);
        let last = file.trim_end_matches(']').rsplit(['/', '[']).next().unwrap_or(file);
        let name = format!("{folder}/{last}");
        let tiled = tiles(Path::new(file));
        if tiled.is_empty() {
            self.entries.push((name.clone(), bytes(file, outer)?));
        }
        for tile in tiled {
            let tile_name = tile.file_name().and_then(|n| n.to_str()).unwrap_or_default();
            let content = fs::read(&tile).map_err(|e| plain(&e))?;
            self.entries.push((format!("{folder}/{tile_name}"), content));
        }
        self.names.insert(file.to_owned(), name.clone());
        Ok(name)
    }
}

/// The content of a file, or of an entry of a package (`outer[entry]`).
fn bytes(file: &str, outer: &str) -> Result<Vec<u8>, String> {
    let inner =
        file.strip_prefix(outer).and_then(|rest| rest.strip_prefix('[')).and_then(|rest| rest.strip_suffix(']'));
    match inner {
        None => fs::read(file).map_err(|e| plain(&e)),
        Some(inner) => {
            let mut archive = Archive::open(outer).map_err(|e| e.to_string())?;
            let entry = archive.entry(inner).map_err(|e| e.to_string())?;
            Ok(entry.as_ref().to_vec())
        }
    }
}
