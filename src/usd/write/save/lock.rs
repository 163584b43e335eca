//! Of two runs that write the same output, one waits for the other.

use super::unfinished::{PREFIX, Temporary, Unfinished};
use std::fs::{self, File, Metadata, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use tailor_mesh::files::{folder_of, target};

/// Digits of the hash in the name of a lock.
const DIGITS: usize = 16;

/// A lock on an output, until it is dropped. The system ends it with the process, and some network drives have none.
#[derive(Debug)]
pub struct OutputLock {
    _file: Unfinished<LockFile>,
}

impl OutputLock {
    /// Locks an output. If another run has locked it, `waits` is called, and the run waits for the other.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub fn new(output: &Path, waits: impl Fn()) -> io::Result<Self> {
        let output = target(output)?;
        let name = blake3::hash(output.file_name().unwrap_or_default().as_encoded_bytes()).to_hex();
        let path = folder_of(&output).join(format!("{PREFIX}{}.lock", &name[..DIGITS]));
        loop {
            let file = File::options().create(true).truncate(false).write(true).open(&path)?;
            if matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
                waits();
                file.lock()?;
            }
            // The run that had it has removed it, and others may have made a new one.
            if is_at(&file.metadata()?, &path) {
                return Ok(Self { _file: Unfinished::new(|| Ok(LockFile { _file: file, path }))? });
            }
        }
    }
}

/// The file of a lock, which is removed before it is closed.
#[derive(Debug)]
struct LockFile {
    _file: File,
    path: PathBuf,
}

impl Temporary for LockFile {
    fn place(&self) -> &Path {
        &self.path
    }
}

impl Drop for LockFile {
    fn drop(&mut self) {
        // One that stays locks nothing.
        let _ = fs::remove_file(&self.path);
    }
}

/// Whether an open file is that at a path.
fn is_at(open: &Metadata, path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        fs::metadata(path).is_ok_and(|there| (there.dev(), there.ino()) == (open.dev(), open.ino()))
    }
    #[cfg(not(unix))]
    (path.exists() && open.is_file())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::thread;

    #[test]
    fn one_run_at_a_time_has_the_lock_and_none_stays() {
        let folder = tempfile::tempdir().expect("a folder");
        let output = folder.path().join("shot.usda");
        let (inside, waited) = (AtomicUsize::new(0), AtomicUsize::new(0));
        thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    for _ in 0..20 {
                        let lock = OutputLock::new(&output, || _ = waited.fetch_add(1, Ordering::Relaxed));
                        assert_eq!(inside.fetch_add(1, Ordering::SeqCst), 0, "two runs have it");
                        thread::yield_now();
                        inside.fetch_sub(1, Ordering::SeqCst);
                        drop(lock.expect("a lock"));
                    }
                });
            }
        });
        assert!(waited.into_inner() > 0, "some wait");
        assert_eq!(fs::read_dir(folder.path()).expect("the folder").count(), 0);
    }
}
