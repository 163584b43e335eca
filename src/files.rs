//! Opening files for reading. Only regular files are: a pipe may never be written to, and a device may never end.

use std::fs;
#[cfg(feature = "usd")]
use std::fs::File;
use std::io;
use std::path::Path;

/// Checks that a path is that of a regular file.
///
/// # Errors
/// A path without a file, a folder, a pipe, a socket or a device.
pub fn require_file(path: &Path) -> io::Result<()> {
    let kind = fs::metadata(path)?.file_type();
    if kind.is_file() {
        Ok(())
    } else if kind.is_dir() {
        Err(io::ErrorKind::IsADirectory.into())
    } else {
        Err(io::Error::new(io::ErrorKind::InvalidInput, "it is a pipe or a device, not a regular file"))
    }
}

/// The folder of a file: `.` for a name alone.
#[cfg(feature = "usd")]
pub fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Opens a regular file.
///
/// # Errors
/// As [`require_file`], and a file that may not be read.
#[cfg(feature = "usd")]
pub fn open(path: &Path) -> io::Result<File> {
    require_file(path)?;
    File::open(path)
}

/// The bytes of a regular file.
///
/// # Errors
/// As [`open`].
#[cfg(feature = "usd")]
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    require_file(path)?;
    fs::read(path)
}

/// The hash of the content of a regular file.
///
/// # Errors
/// As [`open`].
#[cfg(feature = "usd")]
pub fn hash(path: &Path) -> io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(open(path)?)?;
    Ok(hasher.finalize().to_hex().to_string())
}

/// The text of a regular file.
///
/// # Errors
/// As [`open`], and a file that is not UTF-8.
pub fn text(path: &Path) -> io::Result<String> {
    require_file(path)?;
    fs::read_to_string(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn devices_and_folders_are_not_opened() {
        for path in ["/dev/zero", "/dev/null", "/"] {
            assert!(require_file(Path::new(path)).is_err(), "{path}");
            assert!(text(Path::new(path)).is_err(), "{path}");
        }
    }
}
