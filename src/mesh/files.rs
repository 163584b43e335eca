//! Opening files for reading. Only regular files are: a pipe may never be written to, and a device may never end.

use std::fs::{self, File, Metadata};
use std::io::{self, Read};
use std::path::Path;
use std::path::PathBuf;

/// Largest text that is read. \[bytes\]
const MAX_TEXT: u64 = 1 << 28;

/// Checks that a path is that of a regular file.
///
/// # Errors
/// As [`metadata`].
pub fn require_file(path: &Path) -> io::Result<()> {
    metadata(path).map(drop)
}

/// The size and times of a regular file.
///
/// # Errors
/// A path without a file, a folder, a pipe, a socket or a device.
pub fn metadata(path: &Path) -> io::Result<Metadata> {
    let metadata = fs::metadata(path)?;
    let kind = metadata.file_type();
    if kind.is_file() {
        Ok(metadata)
    } else if kind.is_dir() {
        Err(io::ErrorKind::IsADirectory.into())
    } else {
        Err(io::Error::new(io::ErrorKind::InvalidInput, "it is a pipe or a device, not a regular file"))
    }
}

/// Checks that the content of a regular file fits into the memory: a sparse file may be of any size.
///
/// # Errors
/// A file that does not; as [`metadata`].
pub fn require_memory(path: &Path) -> io::Result<()> {
    let size = metadata(path)?.len();
    let fits = usize::try_from(size).is_ok_and(|size| Vec::<u8>::new().try_reserve_exact(size).is_ok());
    if fits { Ok(()) } else { Err(io::Error::new(io::ErrorKind::InvalidInput, "it is larger than the memory")) }
}

/// The folder of a file: `.` for a name alone.
pub fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Opens a regular file.
///
/// # Errors
/// As [`require_file`], and a file that may not be read.
pub fn open(path: &Path) -> io::Result<File> {
    require_file(path)?;
    File::open(path)
}

/// The bytes of a regular file.
///
/// # Errors
/// As [`open`], and a file that is larger than the memory.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    require_memory(path)?;
    fs::read(path)
}

/// The hash of the content of a regular file, up to the size that it states: files of `/proc` may have no end.
///
/// # Errors
/// As [`open`].
pub fn hash(path: &Path) -> io::Result<String> {
    let file = open(path)?;
    let size = file.metadata()?.len();
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(file.take(size))?;
    Ok(hasher.finalize().to_hex().to_string())
}

/// The path of the file that is written by way of `path`: the target of a link is replaced, not the link.
///
/// # Errors
/// A link to no file; a folder, a pipe or a device.
pub fn target(path: &Path) -> io::Result<PathBuf> {
    match path.canonicalize() {
        Ok(target) => require_file(&target).map(|()| target),
        Err(_) if path.is_symlink() => {
            Err(io::Error::new(io::ErrorKind::NotFound, "it is a link to a file that does not exist"))
        }
        Err(_) => Ok(path.to_path_buf()),
    }
}

/// The text of a regular file.
///
/// # Errors
/// As [`open`], and a file that is not UTF-8, or larger than 256 MB.
pub fn text(path: &Path) -> io::Result<String> {
    require_file(path)?;
    let mut text = String::new();
    File::open(path)?.take(MAX_TEXT + 1).read_to_string(&mut text)?;
    match text.len() as u64 > MAX_TEXT {
        true => Err(io::Error::new(io::ErrorKind::InvalidInput, "it is larger than 256 MB")),
        false => Ok(text),
    }
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

    #[cfg(target_os = "linux")]
    #[test]
    fn a_file_is_hashed_up_to_its_size() {
        // It states a size of 0, as all files there do.
        assert_eq!(hash(Path::new("/proc/uptime")).expect("a hash"), blake3::hash(b"").to_hex().to_string());
    }

    #[cfg(unix)]
    #[test]
    fn a_text_without_bound_is_not_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("sparse.tailor");
        File::create(&file).and_then(|sparse| sparse.set_len(200 << 30)).expect("a sparse file");
        assert!(text(&file).is_err_and(|e| e.to_string().contains("larger than 256 MB")));
    }

    #[cfg(unix)]
    #[test]
    fn the_target_of_a_link_is_written() {
        let folder = tempfile::tempdir().expect("a folder");
        let [file, link, dangling] = ["file", "link", "dangling"].map(|name| folder.path().join(name));
        fs::write(&file, "").expect("a file");
        std::os::unix::fs::symlink(&file, &link).expect("a link");
        std::os::unix::fs::symlink("nowhere", &dangling).expect("a link");
        assert_eq!(target(&link).expect("a target"), file.canonicalize().expect("a file"));
        assert_eq!(target(&folder.path().join("new")).expect("a new file"), folder.path().join("new"));
        for bad in [dangling.as_path(), Path::new("/dev/null"), folder.path()] {
            assert!(target(bad).is_err(), "{}", bad.display());
        }
    }
}
