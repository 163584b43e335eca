//! A shot as value clips: a file for each frame, a manifest, and a layer that has them.

use super::DrivenMesh;
use super::stream::{ATTRIBUTES, extent, sampled, type_of, unwritable};
use crate::error::{Error, ErrorCode, plain};
use crate::usd::names;
use crate::usd::write::{OutputFile, PREFIX, Unfinished};
use openusd::gf::Vec2d;
use openusd::sdf::{self, AbstractData, AssetPath, Data, Path, PrimSpec, SpecType, Value, Variability};
use std::collections::HashMap;
use std::fs;
use std::io;
use std::path::{Path as FilePath, PathBuf};
use tempfile::{Builder, TempDir};

/// Ending of the name of the folder of the clips.
const FOLDER: &str = "clips";
/// Name of the manifest.
const MANIFEST: &str = "manifest.usdc";
/// Digits of the number of a clip.
const DIGITS: usize = 5;

/// Clips that are written.
pub struct Clips {
    /// The folder under a temporary name, until all clips are in it.
    temporary: Unfinished<TempDir>,
    folder: PathBuf,
    /// The folder's name, relative to the shot.
    name: String,
    times: Vec<f64>,
    written: usize,
    /// Whether the folder of an earlier shot is replaced.
    force: bool,
    /// The attributes that vary.
    varying: [bool; 3],
}

impl Clips {
    /// Clips beside the shot `file`, in a folder of its name. `used` finds the first of some files that is an input.
    ///
    /// # Errors
    /// A folder that cannot be made, or is there already; with `force`, one that holds more than clips, or inputs.
    pub fn new(
        file: &OutputFile,
        times: &[f64],
        force: bool,
        used: impl Fn(&[PathBuf]) -> Result<Option<usize>, Error>,
    ) -> Result<Self, Error> {
        let name = format!("{}.{FOLDER}", file.stem());
        let folder = file.folder.join(&name);
        let fault = |code: ErrorCode, text: &str, remedy: &str| {
            Err(Error::usd(format!("{} {text}", folder.display())).code(code).remedy(remedy))
        };
        if folder.exists() && !force {
            return fault(ErrorCode::OutputExists, "exists already", "use --force to overwrite it");
        }
        let earlier = contents(&folder);
        if !earlier.iter().all(|path| path.file_name().and_then(|name| name.to_str()).is_some_and(is_clip)) {
            return fault(
                ErrorCode::OutputPath,
                "is not a folder of clips, or holds more than clips",
                "move it away, or write to another file",
            );
        }
        if let Some(i) = used(&earlier)? {
            let text = format!("holds {}, which is an input", earlier[i].display());
            return fault(ErrorCode::OutputIsInput, &text, "write to another file; an input is never changed");
        }
        let temporary =
            Unfinished::new(|| Builder::new().prefix(PREFIX).tempdir_in(&file.folder)).map_err(|e| file.fault(&e))?;
        Ok(Self { temporary, folder, name, times: times.to_vec(), written: 0, force, varying: [false; 3] })
    }

    /// Writes the meshes at `time`.
    ///
    /// # Errors
    /// A full disk.
    pub fn write(&mut self, time: f64, paths: &[Path], meshes: &[DrivenMesh]) -> Result<(), Error> {
        let mut clip = empty();
        for (path, moved) in paths.iter().zip(meshes) {
            PrimSpec::over(&mut clip, path).map_err(|e| unwritable(&e))?;
            for (kind, values) in moved.arrays().into_iter().enumerate() {
                let Some(values) = values else { continue };
                self.varying[kind] = true;
                let values: &[openusd::gf::Vec3f] = bytemuck::cast_slice(values);
                let samples = vec![(time, Value::Vec3fVec(values.to_vec()))];
                sampled(&mut clip, path, ATTRIBUTES[kind], samples).map_err(|e| unwritable(&e))?;
            }
            sampled(&mut clip, path, names::EXTENT, vec![(time, extent(&moved.points))]).map_err(|e| unwritable(&e))?;
        }
        self.save(clip, &clip_name(self.written))?;
        self.written += 1;
        Ok(())
    }

    fn save(&self, layer: Data, name: &str) -> Result<(), Error> {
        OutputFile::find(&self.temporary.path().join(name), |_| Ok(false), false)?.save(layer).map(drop)
    }

    /// Writes the manifest, gives the folder its name, and authors the clips on the meshes.
    ///
    /// # Errors
    /// A full disk.
    pub fn author(self, layer: &mut Data, paths: &[Path]) -> Result<(), Error> {
        let mut manifest = empty();
        for path in paths {
            PrimSpec::over(&mut manifest, path).map_err(|e| unwritable(&e))?;
            let varying = ATTRIBUTES.iter().zip(self.varying).filter(|(_, varying)| *varying).map(|(name, _)| *name);
            for name in varying.chain([names::EXTENT]) {
                let attribute = path.append_property(name).map_err(|e| unwritable(&e))?;
                sdf::AttributeSpec::new(&mut manifest, &attribute, type_of(name), Variability::Varying, false)
                    .map_err(|e| unwritable(&e))?;
            }
        }
        self.save(manifest, MANIFEST)?;
        for path in paths {
            PrimSpec::over(layer, path).map_err(|e| unwritable(&e))?;
            layer.set_field(path, "clips", self.clips(path));
        }
        self.rename()
    }

    /// Replaces the folder of an earlier shot.
    fn rename(self) -> Result<(), Error> {
        let fault = |e: io::Error| {
            Error::usd(format!("cannot write {}: {}", self.folder.display(), plain(&e)))
                .code(ErrorCode::WriteFailed)
                .remedy("check the folder's permissions")
        };
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // Temporary folders are private to their owner.
            fs::set_permissions(self.temporary.path(), fs::Permissions::from_mode(0o755)).map_err(fault)?;
        }
        let folder = &self.folder;
        let named = self.temporary.finish(|temporary| {
            if self.force && folder.exists() {
                fs::remove_dir_all(folder)?;
            }
            // A folder that came up in the meantime and holds files is not replaced.
            fs::rename(temporary.path(), folder)
        });
        named.map_err(fault)
    }

    fn clips(&self, path: &Path) -> Value {
        let asset = |name: String| AssetPath::from(format!("./{}/{name}", self.name));
        let pairs = |value: fn(usize, f64) -> [f64; 2]| {
            Value::Vec2dVec(self.times.iter().enumerate().map(|(i, t)| Vec2d::from(value(i, *t))).collect())
        };
        let default = HashMap::from([
            ("assetPaths".to_owned(), Value::AssetPathVec((0..self.written).map(|i| asset(clip_name(i))).collect())),
            ("manifestAssetPath".to_owned(), Value::AssetPath(asset(MANIFEST.to_owned()))),
            ("primPath".to_owned(), Value::String(path.as_str().to_owned())),
            ("active".to_owned(), pairs(|i, time| [time, i as f64])),
            ("times".to_owned(), pairs(|_, time| [time, time])),
        ]);
        Value::Dictionary(HashMap::from([("default".to_owned(), Value::Dictionary(default))]))
    }
}

/// The contents of the folder of an earlier shot: its files, or the path itself if it is not a folder.
fn contents(folder: &FilePath) -> Vec<PathBuf> {
    match folder.read_dir() {
        Ok(entries) => entries.flatten().map(|entry| entry.path()).collect(),
        Err(_) if folder.exists() => vec![folder.to_path_buf()],
        Err(_) => Vec::new(),
    }
}

/// Whether a file has a name that [`Clips`] gives.
fn is_clip(name: &str) -> bool {
    let number = name.strip_prefix("frame.").and_then(|rest| rest.strip_suffix(".usdc"));
    name == MANIFEST || number.is_some_and(|n| n.len() >= DIGITS && n.bytes().all(|b| b.is_ascii_digit()))
}

fn clip_name(number: usize) -> String {
    format!("frame.{number:0DIGITS$}.usdc")
}

fn empty() -> Data {
    let mut data = Data::new();
    data.create_spec(Path::abs_root(), SpecType::PseudoRoot);
    data
}
