//! Files: their formats, the check that they may be written, and writing them completely or not at all.

use super::crates::{remove_unwritable, write_crate};
use super::package::package;
use crate::error::{Error, ErrorCode, Warnings, plain};
use crate::usd::assets::{Anchor, absolute};
use openusd::sdf::{Data, FormatError};
use openusd::usda::TextWriter;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

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
    /// The format of a file by the end of its name.
    ///
    /// # Errors
    /// Another ending than `.usd`, `.usda`, `.usdc` and `.usdz`.
    pub fn of(file: &Path) -> Result<Self, Error> {
        let extension = file.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        match extension.as_str() {
            "usda" => Ok(Self::Usda),
            "usd" | "usdc" => Ok(Self::Usdc),
            "usdz" => Ok(Self::Usdz),
            _ => Err(Error::usd(format!("{} does not end in .usd, .usda, .usdc or .usdz", file.display()))
                .code(ErrorCode::OutputPath)
                .remedy("the name of the output decides its format")),
        }
    }
}

/// A file that may be written.
#[derive(Debug)]
pub struct OutputFile {
    /// The path as the user named it.
    shown: String,
    /// Its folder, without links.
    pub folder: PathBuf,
    /// Its path, without links.
    file: PathBuf,
    /// Its format.
    pub format: Format,
}

impl OutputFile {
    /// Checks that `out` may be written.
    ///
    /// # Errors
    /// An unknown format, a missing folder, an existing file (unless `force`), and one of the files `layers` under any
    /// name.
    pub fn find(out: &Path, layers: &[PathBuf], force: bool) -> Result<Self, Error> {
        let shown = out.display().to_string();
        let format = Format::of(out)?;
        // The target of a link is replaced, not the link.
        let file = out.canonicalize().unwrap_or_else(|_| out.to_path_buf());
        if let Ok(there) = fs::metadata(&file) {
            if layers.iter().any(|layer| same_file(layer, &file)) {
                return Err(Error::usd(format!("{shown} is the input, or a layer that the input uses"))
                    .code(ErrorCode::OutputIsInput)
                    .remedy("write to another file; the input is never changed"));
            }
            if !there.is_file() {
                return Err(Error::usd(format!("{shown} is not a file"))
                    .code(ErrorCode::OutputPath)
                    .remedy("choose another output"));
            }
            if !force {
                return Err(Error::usd(format!("{shown} exists already"))
                    .code(ErrorCode::OutputExists)
                    .remedy("use --force to overwrite it"));
            }
        }
        let folder = match file.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let folder = folder.canonicalize().ok().filter(|f| f.is_dir()).ok_or_else(|| {
            Error::usd(format!("cannot write {shown}: there is no folder {}", folder.display()))
                .code(ErrorCode::OutputPath)
                .remedy("create the folder first")
        })?;
        let file = folder.join(file.file_name().expect("a path with a known extension has a file name"));
        Ok(Self { shown, folder, file, format })
    }

    /// True if there is a file already.
    #[cfg(feature = "preview")]
    pub fn exists(&self) -> bool {
        self.file.exists()
    }

    /// Its path, without links.
    #[cfg(feature = "preview")]
    pub fn path(&self) -> &Path {
        &self.file
    }

    /// Writes the layer `data`. A package gets all files that `data` uses; asset paths are then absolute.
    ///
    /// # Errors
    /// A folder that cannot be written to, a full disk, a value that the format cannot hold.
    pub fn save(&self, data: Data, warnings: &mut Warnings) -> Result<(), Error> {
        self.save_verified(data, warnings, |_| Ok(()))
    }

    /// As [`OutputFile::save`]; `verify` sees the finished file under a temporary name before it gets its own.
    ///
    /// # Errors
    /// As [`OutputFile::save`], and those of `verify`. Nothing is written then.
    pub fn save_verified(
        &self,
        mut data: Data,
        warnings: &mut Warnings,
        verify: impl FnOnce(&Path) -> Result<(), Error>,
    ) -> Result<(), Error> {
        match self.format {
            Format::Usda => self.replace(|out| TextWriter::write(&data, out), verify),
            Format::Usdc => {
                remove_unwritable(&mut data, warnings);
                self.replace(|out| write_crate(&data, out), verify)
            }
            Format::Usdz => {
                let stem = self.file.file_stem().and_then(|s| s.to_str()).unwrap_or("layer");
                let bytes = package(data, stem, warnings)?;
                self.replace(|out| Ok(out.write_all(&bytes)?), verify)
            }
        }
    }

    /// Lets `fill` write a temporary file in the folder and `verify` look at it, and renames it to the output.
    fn replace(
        &self,
        fill: impl FnOnce(&mut BufWriter<&File>) -> Result<(), FormatError>,
        verify: impl FnOnce(&Path) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let temporary = self.temporary()?;
        let mut out = BufWriter::with_capacity(1 << 20, temporary.as_file());
        fill(&mut out).map_err(|e| match e {
            FormatError::Io(e) => self.fault(&e),
            other => Error::usd(format!("cannot write {}: {other}", self.shown)).code(ErrorCode::WriteFailed),
        })?;
        out.flush().map_err(|e| self.fault(&e))?;
        drop(out);
        verify(temporary.path())?;
        self.keep(temporary)
    }

    /// A temporary file beside the output, with its permissions.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub fn temporary(&self) -> Result<NamedTempFile, Error> {
        let suffix = format!(".{}", self.file.extension().and_then(|e| e.to_str()).unwrap_or("tmp"));
        let mut builder = tempfile::Builder::new();
        builder.prefix(".usdtailor-").suffix(&suffix);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = fs::metadata(&self.file).map_or(0o666, |m| m.permissions().mode() & 0o777);
            builder.permissions(fs::Permissions::from_mode(mode));
        }
        builder.tempfile_in(&self.folder).map_err(|e| self.fault(&e))
    }

    /// Gives a complete temporary file the name of the output.
    ///
    /// # Errors
    /// A full disk.
    pub fn keep(&self, temporary: NamedTempFile) -> Result<(), Error> {
        temporary.as_file().sync_all().map_err(|e| self.fault(&e))?;
        temporary.persist(&self.file).map_err(|e| self.fault(&e.error))?;
        Ok(())
    }

    /// The error of a write that failed.
    pub fn fault(&self, e: &io::Error) -> Error {
        Error::usd(format!("cannot write {}: {}", self.shown, plain(e)))
            .code(ErrorCode::WriteFailed)
            .remedy("check the folder's permissions and the space on its disk")
    }

    /// The name of the file without its ending.
    pub fn stem(&self) -> String {
        self.file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// The asset path of another file, relative to the output's folder.
    ///
    /// # Errors
    /// A path without a folder, or that is no text.
    pub fn path_to(&self, other: &Path) -> Result<String, Error> {
        Ok(Anchor::Folder(&self.folder).path_to(&absolute(other)?))
    }
}

/// Whether two paths are of the same file, through links of any kind.
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
