//! Files: their formats, the check that they may be written, and writing them completely or not at all.

mod held;
mod indent;
mod lock;
mod opened;
mod text;
mod unfinished;

pub use held::HeldOutput;
pub use lock::OutputLock;
pub use opened::check_whole;
pub use text::text_of;
pub use unfinished::{PREFIX, Unfinished, remove_unfinished, temporary_beside, temporary_folder, write_whole};

use super::crates::{add_empty_text, remove_unwritable, write_crate};
use super::package::package;
use crate::assets::{Anchor, as_named, unreadable, writable};
use crate::codes;
use openusd::sdf::{Data, FormatError};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tailor_mesh::error::{Error, ErrorCode, Warnings, plain};
use tailor_mesh::files::folder_of;
use tempfile::NamedTempFile;
use text::write_text;

/// Largest text that is opened once it is written: to read text takes longer than to write it. \[bytes\]
const MOST_TEXT: u64 = 16 << 20;

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
                .code(codes::OUTPUT_PATH)
                .remedy("the name of the output decides its format")),
        }
    }
}

/// A file that may be written.
#[derive(Clone, Debug)]
pub struct OutputFile {
    /// The path as the user named it.
    shown: String,
    /// Its folder as OpenUSD knows it, to which asset paths are relative.
    pub folder: PathBuf,
    /// Its path, without links.
    file: PathBuf,
    /// Its name without the ending, as the user named it.
    stem: String,
    /// Whether a file that is there already is replaced.
    force: bool,
    /// Its format.
    pub format: Format,
}

/// A complete file that has no name yet.
pub struct Unnamed {
    pub temporary: Unfinished<NamedTempFile>,
    /// The files that a package has a copy of.
    pub packed: Vec<PathBuf>,
    pub warnings: Warnings,
}

impl OutputFile {
    /// Checks that `out` may be written. `is_used` tells whether an existing file is an input.
    ///
    /// # Errors
    /// An unknown format, a missing folder, a link to no file, an existing file (unless `force`), and one that is used.
    pub fn find(out: &Path, is_used: impl Fn(&Path) -> Result<bool, Error>, force: bool) -> Result<Self, Error> {
        let shown = out.display().to_string();
        let format = Format::of(out)?;
        let fault = |code: ErrorCode, text: &str, remedy: &str| {
            Err(Error::usd(format!("{shown} {text}")).code(code).remedy(remedy))
        };
        // The target of a link is replaced, not the link.
        let file = out.canonicalize().unwrap_or_else(|_| out.to_path_buf());
        if let Ok(there) = fs::metadata(&file) {
            if is_used(&file)? {
                let remedy = "write to another file; the input is never changed";
                return fault(codes::OUTPUT_IS_INPUT, "is the input, or a file that the input uses", remedy);
            }
            if !there.is_file() {
                return fault(codes::OUTPUT_PATH, "is not a file", "choose another output");
            }
            if !force {
                return Err(exists_already(&shown));
            }
        } else if out.is_symlink() {
            let remedy = "remove the link, or name the file itself";
            return fault(codes::OUTPUT_PATH, "is a link to a file that does not exist", remedy);
        }
        let real_folder = folder_of(&file).canonicalize().ok().filter(|f| f.is_dir()).ok_or_else(|| {
            Error::usd(format!("cannot write {shown}: there is no folder {}", folder_of(&file).display()))
                .code(codes::OUTPUT_PATH)
                .remedy("create the folder first")
        })?;
        let named = as_named(out)?;
        // By a path from its own folder, such a name would be that of a layer in memory.
        let is_memory = file.file_name().is_some_and(|name| name.to_string_lossy().starts_with("anon:"));
        if let Some(what) = unreadable(&named).or(is_memory.then_some("`anon:`")) {
            return fault(codes::OUTPUT_PATH, &format!("has {what} in its path"), "name it otherwise for OpenUSD");
        }
        let named = PathBuf::from(named);
        let file = real_folder.join(file.file_name().expect("a path with a known extension has a file name"));
        let stem = named.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { shown, folder: folder_of(&named).to_path_buf(), file, stem, force, format })
    }

    /// True if there is a file already.
    pub fn exists(&self) -> bool {
        self.file.exists()
    }

    /// Its path, without links.
    pub fn path(&self) -> &Path {
        &self.file
    }

    /// Writes the layer `data`. A package gets the files that `data` uses, which are returned; asset paths are then absolute.
    /// Warns of what the format cannot hold, and of files that are not packed.
    ///
    /// # Errors
    /// A folder that cannot be written to, a full disk, a value that the format cannot hold.
    pub fn save(&self, data: Data) -> Result<(Vec<PathBuf>, Warnings), Error> {
        let Unnamed { temporary, packed, warnings } = self.unnamed(data)?;
        self.keep(temporary)?;
        Ok((packed, warnings))
    }

    /// As [`OutputFile::save`], and the file waits in `held` for its name.
    ///
    /// # Errors
    /// As [`OutputFile::save`].
    pub fn hold(&self, data: Data, held: &HeldOutput) -> Result<(Vec<PathBuf>, Warnings), Error> {
        let Unnamed { temporary, packed, warnings } = self.unnamed(data)?;
        held.put(self.clone(), temporary);
        Ok((packed, warnings))
    }

    /// Writes the layer `data` under a temporary name, and opens it once.
    ///
    /// # Errors
    /// As [`OutputFile::save`], and a file that does not read back.
    pub fn unnamed(&self, mut data: Data) -> Result<Unnamed, Error> {
        let (mut packed, mut warnings) = (Vec::new(), Warnings::default());
        let temporary = match self.format {
            Format::Usda => self.filled(|out| write_text(&data, out))?,
            Format::Usdc => {
                warnings = remove_unwritable(&mut data);
                add_empty_text(&mut data);
                self.filled(|out| write_crate(&data, out))?
            }
            Format::Usdz => {
                let package = warnings.absorb(package(&mut data, &self.stem)?);
                packed = package.files;
                self.filled(|out| Ok(out.write_all(&package.bytes)?))?
            }
        };
        if self.format != Format::Usda || temporary.as_file().metadata().is_ok_and(|file| file.len() <= MOST_TEXT) {
            opened::check(&data, temporary.path())?;
        }
        Ok(Unnamed { temporary, packed, warnings })
    }

    /// Does what [`OutputFile::save`] does, without a file.
    ///
    /// # Errors
    /// A value that the format cannot hold, a file that cannot be packed.
    pub fn rehearse(&self, mut data: Data) -> Result<(Vec<PathBuf>, Warnings), Error> {
        match self.format {
            Format::Usda => {
                write_text(&data, &mut io::sink()).map_err(|e| self.unfit(&e))?;
                Ok((Vec::new(), Warnings::default()))
            }
            Format::Usdc => Ok((Vec::new(), remove_unwritable(&mut data))),
            Format::Usdz => package(&mut data, &self.stem).map(|(package, warnings)| (package.files, warnings)),
        }
    }

    /// The error of a value that the format cannot hold.
    fn unfit(&self, e: &FormatError) -> Error {
        Error::usd(format!("cannot write {}: {e}", self.shown)).code(codes::WRITE_FAILED)
    }

    /// A temporary file with what `fill` writes.
    fn filled(
        &self,
        fill: impl FnOnce(&mut BufWriter<&File>) -> Result<(), FormatError>,
    ) -> Result<Unfinished<NamedTempFile>, Error> {
        let temporary = self.temporary()?;
        let mut out = BufWriter::with_capacity(1 << 20, temporary.as_file());
        fill(&mut out).map_err(|e| match e {
            FormatError::Io(e) => self.fault(&e),
            other => self.unfit(&other),
        })?;
        out.flush().map_err(|e| self.fault(&e))?;
        drop(out);
        Ok(temporary)
    }

    /// A temporary file beside the output, with its permissions.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub fn temporary(&self) -> Result<Unfinished<NamedTempFile>, Error> {
        temporary_beside(&self.file).map_err(|e| self.fault(&e))
    }

    /// Gives a complete temporary file the name of the output.
    ///
    /// # Errors
    /// A full disk; a file that another program has written there in the meantime, unless it may be replaced.
    pub fn keep(&self, temporary: Unfinished<NamedTempFile>) -> Result<(), Error> {
        temporary.persist(&self.file, self.force).map_err(|e| match e.kind() {
            io::ErrorKind::AlreadyExists => exists_already(&self.shown),
            _ => self.fault(&e),
        })
    }

    /// Locks the output against other runs, for which it waits.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub fn lock(&self) -> Result<OutputLock, Error> {
        OutputLock::new(&self.file, || {}).map_err(|e| self.fault(&e))
    }

    /// The error of a write that failed.
    pub fn fault(&self, e: &io::Error) -> Error {
        Error::usd(format!("cannot write {}: {}", self.shown, plain(e)))
            .code(codes::WRITE_FAILED)
            .remedy("check the folder's permissions and the space on its disk")
    }

    /// The name of the file without its ending.
    pub fn stem(&self) -> &str {
        &self.stem
    }

    /// The anchor of the asset paths of the output.
    pub fn anchor(&self) -> Anchor<'_> {
        Anchor::Folder { named: &self.folder, real: folder_of(&self.file) }
    }

    /// The asset path of another file, relative to the output's folder.
    ///
    /// # Errors
    /// A path without a folder, or that is not text.
    pub fn path_to(&self, other: &Path) -> Result<String, Error> {
        writable(self.anchor().path_to(&as_named(other)?))
    }
}

fn exists_already(shown: &str) -> Error {
    Error::usd(format!("{shown} exists already")).code(codes::OUTPUT_EXISTS).remedy("use --force to overwrite it")
}
