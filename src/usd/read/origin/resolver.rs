//! Finding and opening the files of a stage.

use super::content::ReadFiles;
use super::text::readable;
use crate::files::{require_file, require_memory};
use crate::usd::assets::{normalized, same_file};
use openusd::ar::{self, DefaultResolver, ResolvedPath, Resolver};
use std::borrow::Cow;
use std::io::{self, Cursor};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Begin of a layer that is text.
const TEXT: &[u8] = b"#usda";
/// Levels of braces in a text. Reading takes memory that grows with the square of the levels of prims.
const MAX_LEVELS: usize = 1000;

/// The separator of a layer's path and its arguments.
pub const ARGUMENTS: &str = ":SDF_FORMAT_ARGS:";

/// Finds files where OpenUSD finds them, and opens regular files only.
///
/// [`DefaultResolver`] names a file by its path without links. OpenUSD keeps links, so that a layer which is opened through
/// a link has its neighbours beside the link.
#[derive(Default)]
pub struct Files {
    resolver: DefaultResolver,
    read: Arc<ReadFiles>,
}

impl Files {
    /// Reads the same content of each file as all others with this `read`.
    pub fn of(read: &Arc<ReadFiles>) -> Self {
        Self { read: Arc::clone(read), ..Self::default() }
    }
}

impl Resolver for Files {
    fn create_identifier(&self, asset_path: &str, anchor: Option<&ResolvedPath>) -> String {
        let found = self.resolver.create_identifier(asset_path, anchor);
        as_written(asset_path, anchor).filter(|path| Path::new(path).exists()).unwrap_or(found)
    }

    fn resolve(&self, asset_path: &str) -> Option<ResolvedPath> {
        // A package is opened here already, to see what is in it.
        if asset_path.ends_with(']') {
            return require_file(&package_file(Path::new(asset_path)))
                .ok()
                .and_then(|()| self.resolver.resolve(asset_path));
        }
        let found = self.resolver.resolve(asset_path)?;
        let named = normalized(&std::path::absolute(asset_path).ok()?);
        Some(if same_file(&named, &found) { ResolvedPath::new(named) } else { found })
    }

    fn resolve_for_new_asset(&self, asset_path: &str) -> Option<ResolvedPath> {
        self.resolver.resolve_for_new_asset(asset_path)
    }

    fn open_asset(&self, resolved_path: &ResolvedPath) -> io::Result<Box<dyn ar::Asset>> {
        let package = package_file(resolved_path);
        let is_packed = package != **resolved_path;
        if is_packed || is_package(&package) {
            // It is read whole.
            require_memory(&package)?;
            self.read.package(&package)?;
        }
        if is_package(Path::new(resolved_path.to_str().unwrap_or_default().trim_end_matches(']'))) {
            return self.resolver.open_asset(resolved_path);
        }
        let bytes =
            if is_packed { self.resolver.open_asset(resolved_path)?.read_all()? } else { self.read.read(&package)? };
        if !bytes.starts_with(TEXT) {
            return Ok(shared(bytes));
        }
        check_levels(&bytes)?;
        Ok(match readable(&bytes) {
            Cow::Borrowed(_) => shared(bytes),
            Cow::Owned(text) => shared(text),
        })
    }

    fn is_context_dependent_path(&self, asset_path: &str) -> bool {
        self.resolver.is_context_dependent_path(asset_path)
    }

    fn in_memory_identifier<'a>(&self, asset_path: &'a str) -> Cow<'a, str> {
        self.resolver.in_memory_identifier(asset_path)
    }

    fn identity(&self) -> String {
        self.resolver.identity()
    }

    fn cache_id(&self) -> Option<u64> {
        self.resolver.cache_id()
    }
}

fn shared(bytes: Vec<u8>) -> Box<dyn ar::Asset> {
    Box::new(Cursor::new(ar::AssetBuffer::Shared(ar::AssetBuffer::Owned(bytes).into_shared())))
}

fn is_package(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("usdz"))
}

/// Refuses a text of too many levels of braces.
fn check_levels(text: &[u8]) -> io::Result<()> {
    let mut level = 0_usize;
    for byte in text {
        match byte {
            b'{' => level += 1,
            b'}' => level = level.saturating_sub(1),
            _ => {}
        }
        if level > MAX_LEVELS {
            return Err(io::Error::other(format!("it is nested in more than {MAX_LEVELS} levels of braces")));
        }
    }
    Ok(())
}

/// The file of a path, which is the package for a path into one.
pub fn package_file(path: &Path) -> PathBuf {
    match path.to_str().and_then(|path| path.strip_suffix(']')).and_then(|path| path.split_once('[')) {
        Some((package, _)) => PathBuf::from(package),
        None => path.to_path_buf(),
    }
}

/// The path that an asset path in the layer `anchor` is by its text; none in and into packages.
fn as_written(asset_path: &str, anchor: Option<&ResolvedPath>) -> Option<String> {
    let anchor = anchor.and_then(|anchor| anchor.to_str());
    let is_packed = |path: &str| path.ends_with(']') || path.to_ascii_lowercase().ends_with(".usdz");
    if asset_path.is_empty() || asset_path.ends_with(']') || anchor.is_some_and(is_packed) {
        return None;
    }
    // Separators of Windows in relative paths are read everywhere.
    let path = if Path::new(asset_path).is_absolute() { asset_path.to_owned() } else { asset_path.replace('\\', "/") };
    let path = match anchor.and_then(|anchor| Path::new(anchor).parent()) {
        Some(folder) => folder.join(path),
        None => std::path::absolute(path).ok()?,
    };
    normalized(&path).to_str().map(str::to_owned)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::fs;
    use std::os::unix::fs::symlink;

    #[test]
    fn neighbours_of_a_link_are_beside_the_link() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().canonicalize().expect("it is there").join(name);
        for name in ["real", "shown"] {
            fs::create_dir(at(name)).expect("a folder");
            fs::write(at(name).join("layer.usda"), name).expect("a file");
        }
        fs::write(at("real/top.usda"), "#usda 1.0\n").expect("a file");
        symlink("../real/top.usda", at("shown/top.usda")).expect("a link");
        let files = Files::default();
        let top = files.resolve(at("shown/top.usda").to_str().expect("text")).expect("it is there");
        assert_eq!(&*top, at("shown/top.usda"));
        for path in ["./layer.usda", "layer.usda", "../shown/layer.usda"] {
            assert_eq!(Path::new(&files.create_identifier(path, Some(&top))), at("shown/layer.usda"), "{path}");
        }
    }

    #[test]
    fn levels_are_bounded() {
        let nested = |levels: usize| "{".repeat(levels) + &"}".repeat(levels) + "{}";
        assert!(check_levels(nested(MAX_LEVELS).as_bytes()).is_ok());
        assert!(check_levels(nested(MAX_LEVELS + 1).as_bytes()).is_err());
    }

    #[test]
    fn devices_are_not_opened() {
        let files = Files::default();
        assert!(files.open_asset(&ResolvedPath::new("/dev/zero")).is_err());
        assert!(files.resolve("/dev/zero[a.usda]").is_none());
    }
}
