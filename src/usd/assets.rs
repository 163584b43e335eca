//! Asset paths: the file that a layer refers to, and the path by which another layer refers to it.

use crate::error::{Error, ErrorCode};
use openusd::sdf::{AssetPath, Value};
use openusd::usd::{SpecSite, Stage};
use std::path::{Component, Path, PathBuf};

/// The token for the number of a texture tile.
const UDIM: &str = "<UDIM>";

/// The anchor of the asset paths of a layer.
#[derive(Clone, Copy, Debug)]
pub enum Anchor<'a> {
    /// The folder of the layer (canonical): paths are relative to it.
    Folder(&'a Path),
    /// None, as the folder is unknown or will change: paths are absolute.
    Root,
}

impl Anchor<'_> {
    /// The asset path of the file `target` (absolute).
    pub fn path_to(self, target: &str) -> String {
        match self {
            Self::Folder(folder) => relative(folder, Path::new(target)).unwrap_or_else(|| target.to_owned()),
            Self::Root => target.to_owned(),
        }
    }

    /// The value with its resolved asset paths written for this anchor.
    pub fn restated(self, value: Value) -> Value {
        value.map_asset_paths(&mut |asset| match asset.resolved_path() {
            Some(file) if Path::new(file).is_absolute() => AssetPath::new(self.path_to(file)),
            _ => AssetPath::new(asset.asset_path()),
        })
    }
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
    let mut file = PathBuf::new();
    for component in folder.join(path).components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir => {
                file.pop();
            }
            other => file.push(other),
        }
    }
    file.to_str().map(str::to_owned)
}

/// The tiles of a path with `<UDIM>`, sorted; their names are UTF-8.
pub fn tiles(pattern: &Path) -> Vec<PathBuf> {
    let Some((before, after)) = pattern.file_name().and_then(|n| n.to_str()).and_then(|n| n.split_once(UDIM)) else {
        return Vec::new();
    };
    let is_tile = |name: &str| {
        name.strip_prefix(before)
            .and_then(|rest| rest.strip_suffix(after))
            .is_some_and(|n| n.len() == 4 && n.bytes().all(|b| b.is_ascii_digit()))
    };
    let entries = pattern.parent().and_then(|folder| folder.read_dir().ok());
    let mut files: Vec<_> = entries
        .into_iter()
        .flatten()
        .flatten()
        .filter(|entry| entry.file_name().to_str().is_some_and(is_tile))
        .map(|entry| entry.path())
        .collect();
    files.sort();
    files
}

/// A path without links in its folders; the file itself may be a link.
///
/// # Errors
/// A path without a folder that exists, or that is no text.
pub fn absolute(file: &Path) -> Result<String, Error> {
    let fault = || Error::usd(format!("cannot find the folder of {}", file.display())).code(ErrorCode::OutputPath);
    let folder = match file.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let folder = folder.canonicalize().map_err(|_| fault())?;
    let path = folder.join(file.file_name().ok_or_else(fault)?);
    path.to_str().map(str::to_owned).ok_or_else(fault)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_relative_to_the_folder() {
        let seen = |folder: &str, target: &str| relative(Path::new(folder), Path::new(target)).unwrap();
        assert_eq!(seen("/a/b", "/a/b/coat.usda"), "./coat.usda");
        assert_eq!(seen("/a/b", "/a/b/c/coat.usda"), "./c/coat.usda");
        assert_eq!(seen("/a/b", "/a/in/coat.usda"), "../in/coat.usda");
        assert_eq!(seen("/a/b", "/c.usdz[tex/x.png]"), "../../c.usdz[tex/x.png]");
    }
}
