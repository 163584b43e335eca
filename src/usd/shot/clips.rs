//! A shot as value clips: a file for each frame, a manifest, and a layer that has them.

use super::Moved;
use super::stream::{ATTRIBUTES, extent, sampled, type_of, unwritable};
use crate::error::{Error, ErrorCode, Warnings, plain};
use crate::usd::names;
use crate::usd::write::OutputFile;
use openusd::gf::Vec2d;
use openusd::sdf::{self, AbstractData, AssetPath, Data, Path, PrimSpec, SpecType, Value, Variability};
use std::collections::HashMap;
use std::fs;
use std::io;
use std::path::PathBuf;
use tempfile::TempDir;

/// Ending of the name of the folder of the clips.
const FOLDER: &str = "clips";
/// Digits of the number of a clip.
const DIGITS: usize = 5;

/// Clips that are written.
pub struct Clips {
    /// The folder under a temporary name, until all clips are in it.
    temporary: TempDir,
    folder: PathBuf,
    /// The folder's name, relative to the shot.
    name: String,
    times: Vec<f64>,
    written: usize,
    /// The attributes that vary.
    varying: [bool; 3],
}

impl Clips {
    /// Clips beside the shot `file`, in a folder of its name.
    ///
    /// # Errors
    /// A folder that cannot be made, or is there already.
    pub fn new(file: &OutputFile, times: &[f64], force: bool) -> Result<Self, Error> {
        let name = format!("{}.{FOLDER}", file.stem());
        let folder = file.folder.join(&name);
        if folder.exists() && !force {
            return Err(Error::usd(format!("{} exists already", folder.display()))
                .code(ErrorCode::OutputExists)
                .remedy("use --force to overwrite it"));
        }
        let temporary =
            tempfile::Builder::new().prefix(".usdtailor-").tempdir_in(&file.folder).map_err(|e| file.fault(&e))?;
        Ok(Self { temporary, folder, name, times: times.to_vec(), written: 0, varying: [false; 3] })
    }

    /// Writes the meshes at `time`.
    ///
    /// # Errors
    /// A full disk.
    pub fn write(&mut self, time: f64, paths: &[Path], meshes: &[Moved]) -> Result<(), Error> {
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
        OutputFile::find(&self.temporary.path().join(name), &[], false)?.save(layer, &mut Warnings::default())
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
        self.save(manifest, "manifest.usdc")?;
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
        if self.folder.exists() {
            fs::remove_dir_all(&self.folder).map_err(fault)?;
        }
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // Temporary folders are private to their owner.
            fs::set_permissions(self.temporary.path(), fs::Permissions::from_mode(0o755)).map_err(fault)?;
        }
        fs::rename(self.temporary.path(), &self.folder).map_err(fault)
    }

    fn clips(&self, path: &Path) -> Value {
        let asset = |name: String| AssetPath::from(format!("./{}/{name}", self.name));
        let pairs = |value: fn(usize, f64) -> [f64; 2]| {
            Value::Vec2dVec(self.times.iter().enumerate().map(|(i, t)| Vec2d::from(value(i, *t))).collect())
        };
        let default = HashMap::from([
            ("assetPaths".to_owned(), Value::AssetPathVec((0..self.written).map(|i| asset(clip_name(i))).collect())),
            ("manifestAssetPath".to_owned(), Value::AssetPath(asset("manifest.usdc".to_owned()))),
            ("primPath".to_owned(), Value::String(path.as_str().to_owned())),
            ("active".to_owned(), pairs(|i, time| [time, i as f64])),
            ("times".to_owned(), pairs(|_, time| [time, time])),
        ]);
        Value::Dictionary(HashMap::from([("default".to_owned(), Value::Dictionary(default))]))
    }
}

fn clip_name(number: usize) -> String {
    format!("frame.{number:0DIGITS$}.usdc")
}

fn empty() -> Data {
    let mut data = Data::new();
    data.create_spec(Path::abs_root(), SpecType::PseudoRoot);
    data
}
