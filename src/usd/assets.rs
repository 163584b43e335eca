//! Asset paths: the file that a layer refers to, and the path by which another layer refers to it.

use crate::codes;
use openusd::sdf::{AssetPath, Value};
use openusd::usd::{SpecSite, Stage};
use std::path::{Component, Path, PathBuf};
use tailor_mesh::error::Error;
use tailor_mesh::files::folder_of;

/// The token for the number of a texture tile.
const UDIM: &str = "<UDIM>";

/// The anchor of the asset paths of a layer.
#[derive(Clone, Copy, Debug)]
pub enum Anchor<'a> {
    /// The folder of the layer as OpenUSD knows it by the name of the layer, and the folder without links: paths are relative where
    /// they lead to the same file from both.
    Folder { named: &'a Path, real: &'a Path },
    /// None, as the folder is unknown or will change: paths are absolute.
    Root,
}

impl<'a> Anchor<'a> {
    /// The anchor of a layer in a folder that is named without links.
    pub fn real(folder: &'a Path) -> Self {
        Self::Folder { named: folder, real: folder }
    }

    /// The asset path of the file `target` (absolute).
    pub fn path_to(self, target: &str) -> String {
        let path = match self {
            Self::Folder { named, real } => {
                let leads_there =
                    |path: &String| named == real || same_place(&normalized(&real.join(path)), Path::new(target));
                relative(named, Path::new(target)).filter(leads_there)
            }
            Self::Root => None,
        };
        path.unwrap_or_else(|| target.to_owned())
    }

    /// The value with its resolved asset paths written for this anchor.
    pub fn restated(self, value: Value) -> Value {
        value.map_asset_paths(&mut |asset| match asset.resolved_path() {
            Some(file) if Path::new(file).is_absolute() => AssetPath::new(self.path_to(&file_path(file))),
            _ => AssetPath::new(asset.asset_path()),
        })
    }
}

/// The separator of a layer's path and its arguments.
pub const ARGUMENTS: &str = ":SDF_FORMAT_ARGS:";

/// Arguments behind the path of a text layer that is handed over as a crate: the library takes a file `.usda` for text, and
/// looks at the content of `.usd`.
pub const BY_CONTENT: &str = ":SDF_FORMAT_ARGS:by=content.usd";

/// A path that was resolved, as the file has it.
pub fn file_path(resolved: &str) -> String {
    resolved.replace(BY_CONTENT, "")
}

/// `target` as seen from `folder`, starting with `./` or `../`; none when they share no root.
pub fn relative(folder: &Path, target: &Path) -> Option<String> {
    let (from, to): (Vec<_>, Vec<_>) = (folder.components().collect(), target.components().collect());
    let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    if shared == 0 {
        return None;
    }
    let mut parts = vec![".."; from.len() - shared];
    if parts.is_empty() {
        parts.push(".");
    }
    for component in &to[shared..] {
        match component {
            Component::Normal(name) => parts.push(name.to_str()?),
            _ => return None,
        }
    }
    Some(parts.join("/"))
}

/// The value with more asset paths resolved than composition does: `./` and `../` paths to missing files, and texture
/// tiles that exist, are resolved from the folder of the strongest layer in `sites`.
pub fn resolved(value: Value, stage: &Stage, sites: &[SpecSite]) -> Value {
    let folder = || {
        let layer = stage.layer(&sites.first()?.layer)?;
        let file = layer.resolved_path()?;
        if file.contains('[') { None } else { Path::new(file).parent().map(Path::to_path_buf) }
    };
    value.map_asset_paths(&mut |mut asset| {
        if asset.resolved_path().is_none()
            && let Some(file) = folder().and_then(|folder| anchored(&folder, asset.asset_path()))
        {
            asset.set_resolved_path(file);
        }
        asset
    })
}

fn anchored(folder: &Path, path: &str) -> Option<String> {
    let explicit = path.starts_with("./") || path.starts_with("../");
    let tiles = || path.contains(UDIM) && !tiles(&folder.join(path)).is_empty();
    if !explicit && !tiles() {
        return None;
    }
    normalized(&folder.join(path)).to_str().map(str::to_owned)
}

/// A path without `.` and `..`, which are taken out of its text. Links are not looked at.
///
/// Source: OpenUSD, `TfNormPath`.
pub fn normalized(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir => _ = plain.pop(),
            other => plain.push(other),
        }
    }
    plain
}

/// The tiles of a path with `<UDIM>`, sorted; their names are UTF-8.
pub fn tiles(pattern: &Path) -> Vec<PathBuf> {
    let Some((before, after)) = pattern.file_name().and_then(|n| n.to_str()).and_then(|n| n.split_once(UDIM)) else {
        return Vec::new();
    };
    numbered(pattern, before, after, |number| number.len() == 4 && number.bytes().all(|b| b.is_ascii_digit()))
}

/// The files of a pattern of value clips, in which `#` stands for the digits of a frame, sorted.
pub fn frames(pattern: &Path) -> Vec<PathBuf> {
    let name = pattern.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let (Some(first), Some(last)) = (name.find('#'), name.rfind('#')) else { return Vec::new() };
    let is_frame =
        |number: &str| !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit() || b == b'.' || b == b'-');
    numbered(pattern, &name[..first], &name[last + 1..], is_frame)
}

/// The files beside `pattern` of which `is_number` accepts the part of the name between `before` and `after`.
fn numbered(pattern: &Path, before: &str, after: &str, is_number: impl Fn(&str) -> bool) -> Vec<PathBuf> {
    let is_one =
        |name: &str| name.strip_prefix(before).and_then(|rest| rest.strip_suffix(after)).is_some_and(&is_number);
    let entries = pattern.parent().and_then(|folder| folder.read_dir().ok());
    let mut files: Vec<_> = entries
        .into_iter()
        .flatten()
        .flatten()
        .filter(|entry| entry.file_name().to_str().is_some_and(is_one))
        .map(|entry| entry.path())
        .collect();
    files.sort();
    files
}

/// The absolute path by which OpenUSD knows the file that is named `file`: links are kept, and `..` is taken out of the text.
/// Where that gives another folder than the system's, as after a link to a folder, the path of the folder is without links.
///
/// # Errors
/// A path without a folder that exists, or that is not text.
pub fn as_named(file: &Path) -> Result<String, Error> {
    let fault = || Error::usd(format!("cannot find the folder of {}", file.display())).code(codes::OUTPUT_PATH);
    let folder = folder_of(file);
    let real = folder.canonicalize().map_err(|_| fault())?;
    let named = std::path::absolute(folder).map(|folder| normalized(&folder)).map_err(|_| fault())?;
    let folder = if named.canonicalize().is_ok_and(|named| named == real) { named } else { real };
    let path = folder.join(file.file_name().ok_or_else(fault)?);
    path.to_str().map(str::to_owned).ok_or_else(fault)
}

/// The part of a path that no asset path can be read back with: control characters, or `@@@`, which ends one.
pub fn unwritable(path: &str) -> Option<&'static str> {
    match () {
        () if path.contains(char::is_control) => Some("a control character, such as a tab or the end of a line,"),
        () if path.contains("@@@") => Some("@@@"),
        () => None,
    }
}

/// The part of a path that OpenUSD does not open a file by.
pub fn unreadable(path: &str) -> Option<&'static str> {
    match () {
        () if path.contains(ARGUMENTS) => Some("`:SDF_FORMAT_ARGS:`"),
        // OpenUSD takes it for a slash on every system.
        () if cfg!(unix) && path.contains('\\') => Some("a backslash"),
        () => unwritable(path),
    }
}

/// The asset path of a layer, unless OpenUSD could not open the layer by it.
///
/// # Errors
/// A path that is [`unreadable`].
pub fn writable(path: String) -> Result<String, Error> {
    let Some(what) = unreadable(&path) else { return Ok(path) };
    Err(Error::usd(format!("{path:?} has {what} in its name, which a USD file cannot refer to"))
        .remedy("rename the file or its folder"))
}

/// A file, whatever the path by which it is named.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Identity {
    /// The numbers of the device and of the file on it.
    #[cfg(unix)]
    Number(u64, u64),
    /// The path without links.
    #[cfg(not(unix))]
    Path(PathBuf),
}

impl Identity {
    /// The file at a path; none without one.
    pub fn of(path: &Path) -> Option<Self> {
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt;
            path.metadata().ok().map(|file| Self::Number(file.dev(), file.ino()))
        }
        #[cfg(not(unix))]
        path.canonicalize().ok().map(Self::Path)
    }
}

/// Whether two paths are of the same file, through links of any kind.
pub fn same_file(a: &Path, b: &Path) -> bool {
    Identity::of(a).is_some_and(|a| Identity::of(b) == Some(a))
}

/// Whether two paths are of the same file, or would be if there was one.
fn same_place(a: &Path, b: &Path) -> bool {
    if a.exists() || b.exists() {
        return same_file(a, b);
    }
    let parents = || a.parent().zip(b.parent()).is_some_and(|(a, b)| same_place(a, b));
    a.file_name() == b.file_name() && parents()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn paths_hold_through_links_too() {
        let folder = tempfile::tempdir().expect("a folder");
        let root = folder.path().canonicalize().expect("it is there");
        std::fs::create_dir_all(root.join("far/deep/out")).expect("folders");
        std::os::unix::fs::symlink(root.join("far/deep"), root.join("near")).expect("a link");
        std::fs::write(root.join("near/coat.usda"), "").expect("a file");
        std::fs::write(root.join("other.usda"), "").expect("a file");
        let (named, real) = (root.join("near/out"), root.join("far/deep/out"));
        let path = |target: &str| {
            Anchor::Folder { named: &named, real: &real }.path_to(root.join(target).to_str().expect("text"))
        };
        assert_eq!(path("near/coat.usda"), "../coat.usda");
        assert_eq!(path("near/out/clips/new.usdc"), "./clips/new.usdc");
        for target in ["other.usda", "missing/x.png"] {
            assert_eq!(path(target), root.join(target).to_str().expect("text"));
        }
    }

    #[test]
    fn paths_are_relative_to_the_folder() {
        let seen = |folder: &str, target: &str| relative(Path::new(folder), Path::new(target)).unwrap();
        assert_eq!(seen("/a/b", "/a/b/coat.usda"), "./coat.usda");
        assert_eq!(seen("/a/b", "/a/b/c/coat.usda"), "./c/coat.usda");
        assert_eq!(seen("/a/b", "/a/in/coat.usda"), "../in/coat.usda");
        assert_eq!(seen("/a/b", "/c.usdz[tex/x.png]"), "../../c.usdz[tex/x.png]");
    }
}
