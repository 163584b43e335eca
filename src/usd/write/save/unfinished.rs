//! Files and folders that are being written under temporary names.
//!
//! A program that a signal ends drops nothing, so that temporary files would stay. All that exist are therefore on a list
//! of the process, by which [`remove_unfinished`] removes them.

use std::fs;
use std::io::{self, Write};
use std::ops::{Deref, DerefMut};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tailor_mesh::files::{self, folder_of};
use tempfile::{Builder, NamedTempFile, TempDir};

/// The temporary files and folders of this process. It is locked while one is made, named or removed.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Begin of the names of temporary files and folders.
pub const PREFIX: &str = ".usdtailor-";

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the temporary files and folders of all writes that have not ended, for a program that is about to exit. Those
/// writes, and later ones, wait for the end of the process.
pub fn remove_unfinished() {
    let paths = unfinished();
    for path in paths.iter() {
        // A failure has nobody left to report it to.
        let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    }
    std::mem::forget(paths);
}

/// A temporary file or folder, which is removed when it is dropped.
pub trait Temporary {
    /// Its path.
    fn place(&self) -> &Path;
}

impl Temporary for NamedTempFile {
    fn place(&self) -> &Path {
        self.path()
    }
}

impl Temporary for TempDir {
    fn place(&self) -> &Path {
        self.path()
    }
}

/// A temporary file or folder on the list.
#[derive(Debug)]
pub struct Unfinished<T: Temporary> {
    /// None once it has its name.
    temporary: Option<T>,
    path: PathBuf,
}

impl<T: Temporary> Unfinished<T> {
    /// Makes a temporary file or folder.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn new(make: impl FnOnce() -> io::Result<T>) -> io::Result<Self> {
        let mut list = unfinished();
        let temporary = make()?;
        let path = temporary.place().to_path_buf();
        list.push(path.clone());
        Ok(Self { temporary: Some(temporary), path })
    }

    /// Lets `name` give it the name under which it stays.
    ///
    /// # Errors
    /// Those of `name`. It is removed then.
    pub fn finish(mut self, name: impl FnOnce(T) -> io::Result<()>) -> io::Result<()> {
        let mut list = unfinished();
        let named = self.temporary.take().map_or(Ok(()), name);
        list.retain(|path| *path != self.path);
        named
    }
}

impl Unfinished<NamedTempFile> {
    /// Gives the file its name. A file that has this name already is replaced only if `replace`.
    ///
    /// # Errors
    /// A full disk; `AlreadyExists` without `replace`. The temporary file is removed then.
    pub fn persist(self, name: &Path, replace: bool) -> io::Result<()> {
        self.as_file().sync_all()?;
        self.finish(|temporary| {
            let named = if replace { temporary.persist(name) } else { temporary.persist_noclobber(name) };
            named.map(drop).map_err(|e| e.error)
        })
    }
}

/// A temporary file beside `file`, with its extension and its permissions.
///
/// # Errors
/// A folder that cannot be written to.
pub fn temporary_beside(file: &Path) -> io::Result<Unfinished<NamedTempFile>> {
    let suffix = format!(".{}", file.extension().and_then(|e| e.to_str()).unwrap_or("tmp"));
    let mut builder = Builder::new();
    builder.prefix(PREFIX).suffix(&suffix);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // A new file has those of any; temporary files are private to their owner.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let temporary = Unfinished::new(|| builder.tempfile_in(folder_of(file)))?;
    // The mask of the process, which new files have, is not for one that is there.
    if let Ok(there) = fs::metadata(file) {
        // Some network drives keep none.
        let _ = temporary.as_file().set_permissions(there.permissions());
    }
    Ok(temporary)
}

/// A folder for files that another program writes.
///
/// # Errors
/// No folder for temporary files, or one that cannot be written to.
pub fn temporary_folder() -> io::Result<Unfinished<TempDir>> {
    Unfinished::new(|| Builder::new().prefix(PREFIX).tempdir())
}

/// Writes a file completely or not at all. One that is there already is replaced only if `replace`; a link is followed.
///
/// # Errors
/// A folder that cannot be written to, a full disk; `AlreadyExists` without `replace`.
pub fn write_whole(file: &Path, bytes: &[u8], replace: bool) -> io::Result<()> {
    let file = files::target(file)?;
    let mut temporary = temporary_beside(&file)?;
    temporary.write_all(bytes)?;
    temporary.persist(&file, replace)
}

impl<T: Temporary> Deref for Unfinished<T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.temporary.as_ref().expect("it is taken by the last call alone")
    }
}

impl<T: Temporary> DerefMut for Unfinished<T> {
    fn deref_mut(&mut self) -> &mut T {
        self.temporary.as_mut().expect("it is taken by the last call alone")
    }
}

impl<T: Temporary + Write> Write for Unfinished<T> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        (**self).write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        (**self).flush()
    }
}

impl<T: Temporary> Drop for Unfinished<T> {
    fn drop(&mut self) {
        if let Some(temporary) = self.temporary.take() {
            let mut list = unfinished();
            drop(temporary);
            list.retain(|path| *path != self.path);
        }
    }
}
