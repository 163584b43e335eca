//! A shot as value clips: a file for each frame, a manifest, and a layer that has them.
//!
//! The name of a clip has the hash of its content. So the clips of an earlier shot stay beside the new ones until the layer of the
//! shot is replaced, and whoever opens that layer finds all that it names.

use super::DrivenPrim;
use super::stream::{sampled, type_of, unwritable};
use crate::assets::Anchor;
use crate::codes;
use crate::write::{OutputFile, PREFIX, Unfinished, Unnamed};
use openusd::gf::Vec2d;
use openusd::sdf::{self, AbstractData, AssetPath, Data, Path, PrimSpec, SpecType, Value, Variability};
use std::collections::{BTreeSet, HashMap};
use std::fs;
use std::io;
use std::path::{Path as FilePath, PathBuf};
use tailor_mesh::error::{Error, ErrorCode, plain};
use tailor_mesh::files;
use tempfile::{Builder, TempDir};

/// Ending of the name of the folder of the clips.
const FOLDER: &str = "clips";
/// Begin of the name of the manifest.
const MANIFEST: &str = "manifest";
/// Digits of the number of a clip.
const DIGITS: usize = 5;
/// Digits of the hash in the name of a clip.
const HASH_DIGITS: usize = 16;

/// Clips that are written.
pub struct Clips {
    /// The folder of the clips until the shot is complete.
    temporary: Unfinished<TempDir>,
    folder: PathBuf,
    times: Vec<f64>,
    /// The names of the clips that are written, and last of the manifest.
    written: Vec<String>,
    /// The attributes of each prim that vary.
    varying: Vec<BTreeSet<&'static str>>,
}

impl Clips {
    /// Clips beside the shot `file`, in a folder of its name. `used` finds the first of some files that is an input.
    ///
    /// # Errors
    /// A folder that is there already; with `force`, one that holds more than clips, or inputs.
    pub fn new(
        file: &OutputFile,
        times: &[f64],
        force: bool,
        used: impl Fn(&[PathBuf]) -> Result<Option<usize>, Error>,
    ) -> Result<Self, Error> {
        let folder = file.folder.join(format!("{}.{FOLDER}", file.stem()));
        let fault = |code: ErrorCode, text: &str, remedy: &str| {
            Err(Error::usd(format!("{} {text}", folder.display())).code(code).remedy(remedy))
        };
        if folder.exists() && !force {
            return fault(codes::OUTPUT_EXISTS, "exists already", "use --force to overwrite it");
        }
        let earlier = contents(&folder);
        if let Some(inner) = earlier.iter().find(|path| **path != folder && path.is_dir()) {
            let text = format!("holds the folder {}, which is not a clip", inner.display());
            return fault(codes::OUTPUT_PATH, &text, "move it away, or write to another file");
        }
        if !earlier.iter().all(|path| is_clip_file(path.as_path())) {
            return fault(
                codes::OUTPUT_PATH,
                "is not a folder of clips, or holds more than clips",
                "move it away, or write to another file",
            );
        }
        if let Some(i) = used(&earlier)? {
            let text = format!("holds {}, which is an input", earlier[i].display());
            return fault(codes::OUTPUT_IS_INPUT, &text, "write to another file; an input is never changed");
        }
        // Files are renamed into the folder, so that they have to be on its disk.
        let real = folder.canonicalize().ok();
        let place = real.as_deref().and_then(FilePath::parent).unwrap_or(&file.folder);
        let temporary =
            Unfinished::new(|| Builder::new().prefix(PREFIX).tempdir_in(place)).map_err(|e| file.fault(&e))?;
        Ok(Self { temporary, folder, times: times.to_vec(), written: Vec::new(), varying: Vec::new() })
    }

    /// Writes the meshes at `time`.
    ///
    /// # Errors
    /// A full disk.
    pub fn write(&mut self, time: f64, paths: &[Path], meshes: &[DrivenPrim]) -> Result<(), Error> {
        let mut clip = empty();
        self.varying.resize(paths.len(), BTreeSet::new());
        for (number, (path, moved)) in paths.iter().zip(meshes).enumerate() {
            PrimSpec::over(&mut clip, path).map_err(unwritable)?;
            for (name, value) in moved.all_values() {
                self.varying[number].insert(name);
                sampled(&mut clip, path, name, vec![(time, value)]).map_err(unwritable)?;
            }
        }
        self.save(clip, &format!("frame.{:0DIGITS$}", self.written.len()))
    }

    /// Writes a clip whose name begins with `begin`.
    fn save(&mut self, layer: Data, begin: &str) -> Result<(), Error> {
        let file = self.temporary.path().join(format!("{begin}.usdc"));
        OutputFile::find(&file, |_| Ok(false), false)?.save(layer)?;
        let hash = files::hash(&file).map_err(|e| self.fault(&e))?;
        let name = format!("{begin}.{}.usdc", &hash[..HASH_DIGITS]);
        fs::rename(&file, self.temporary.path().join(&name)).map_err(|e| self.fault(&e))?;
        self.written.push(name);
        Ok(())
    }

    /// Writes the manifest and authors the clips on the meshes.
    ///
    /// # Errors
    /// A full disk.
    pub fn author(&mut self, file: &OutputFile, layer: &mut Data, paths: &[Path]) -> Result<(), Error> {
        let mut manifest = empty();
        for (path, varying) in paths.iter().zip(&self.varying) {
            PrimSpec::over(&mut manifest, path).map_err(unwritable)?;
            for &name in varying {
                let attribute = path.append_property(name).map_err(unwritable)?;
                sdf::AttributeSpec::new(&mut manifest, &attribute, type_of(name), Variability::Varying, false)
                    .map_err(unwritable)?;
            }
        }
        self.save(manifest, MANIFEST)?;
        for path in paths {
            PrimSpec::over(layer, path).map_err(unwritable)?;
            layer.set_field(path, "clips", self.clips(path, file.anchor()));
        }
        Ok(())
    }

    /// Writes the shot `file`. The clips get their names just before it, and those of an earlier shot go after it. Another run on
    /// this shot waits meanwhile.
    ///
    /// # Errors
    /// A full disk. An earlier shot stays then.
    pub fn finish(self, file: &OutputFile, shot: Data) -> Result<(), Error> {
        let Unnamed { temporary, .. } = file.unnamed(shot)?;
        let _turn = file.lock()?;
        let is_new = !self.folder.exists();
        let mut named = Vec::new();
        let saved = self.name_all(&mut named).and_then(|()| file.keep(temporary));
        let unused = match &saved {
            Ok(()) => {
                let is_used = |path: &PathBuf| self.written.iter().any(|name| *path == self.folder.join(name));
                contents(&self.folder).into_iter().filter(|path| is_clip_file(path) && !is_used(path)).collect()
            }
            Err(_) => named,
        };
        for path in unused {
            // A clip too many does no harm.
            let _ = fs::remove_file(path);
        }
        if saved.is_err() && is_new {
            let _ = fs::remove_dir(&self.folder);
        }
        saved
    }

    /// Gives the clips their names. Those that were not there before are added to `named`.
    fn name_all(&self, named: &mut Vec<PathBuf>) -> Result<(), Error> {
        if !self.folder.is_dir() {
            fs::create_dir(&self.folder).map_err(|e| self.fault(&e))?;
        }
        for name in &self.written {
            let path = self.folder.join(name);
            let is_new = !path.exists();
            fs::rename(self.temporary.path().join(name), &path).map_err(|e| self.fault(&e))?;
            named.extend(is_new.then_some(path));
        }
        Ok(())
    }

    fn fault(&self, e: &io::Error) -> Error {
        Error::usd(format!("cannot write {}: {}", self.folder.display(), plain(e)))
            .code(codes::WRITE_FAILED)
            .remedy("check the folder's permissions and the space on its disk")
    }

    fn clips(&self, path: &Path, anchor: Anchor) -> Value {
        let asset = |name: &String| AssetPath::from(anchor.path_to(&self.folder.join(name).to_string_lossy()));
        let (manifest, clips) = self.written.split_last().expect("the manifest is written");
        let pairs = |value: fn(usize, f64) -> [f64; 2]| {
            Value::Vec2dVec(self.times.iter().enumerate().map(|(i, t)| Vec2d::from(value(i, *t))).collect())
        };
        let default = HashMap::from([
            ("assetPaths".to_owned(), Value::AssetPathVec(clips.iter().map(asset).collect())),
            ("manifestAssetPath".to_owned(), Value::AssetPath(asset(manifest))),
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

fn is_clip_file(path: &FilePath) -> bool {
    path.file_name().and_then(|name| name.to_str()).is_some_and(is_clip)
}

/// Whether a file has a name that [`Clips`] gives; earlier versions gave names without a hash.
fn is_clip(name: &str) -> bool {
    let Some(begin) = name.strip_suffix(".usdc") else { return false };
    let is_hash = |hash: &str| hash.len() == HASH_DIGITS && hash.bytes().all(|b| b.is_ascii_hexdigit());
    let begin = begin.rsplit_once('.').filter(|(_, hash)| is_hash(hash)).map_or(begin, |(begin, _)| begin);
    let is_number = |n: &str| n.len() >= DIGITS && n.bytes().all(|b| b.is_ascii_digit());
    begin == MANIFEST || begin.strip_prefix("frame.").is_some_and(is_number)
}

fn empty() -> Data {
    let mut data = Data::new();
    data.create_spec(Path::abs_root(), SpecType::PseudoRoot);
    data
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::names;
    use glam::Vec3;

    /// Clips of one point at some heights, ready to be written.
    fn clips(file: &OutputFile, heights: &[f32]) -> (Clips, Data) {
        let mesh = [Path::new("/mesh").expect("a path")];
        let times: Vec<f64> = (0..heights.len()).map(|i| i as f64).collect();
        let mut clips = Clips::new(file, &times, true, |_| Ok(None)).expect("a folder of clips");
        for (time, height) in times.iter().zip(heights) {
            let points = vec![Vec3::new(0.0, *height, 0.0)];
            let (normals, velocities, tangents, orientations) = (None, None, None, None);
            let (points_name, reach) = (names::POINTS, Some(0.0));
            let moved = DrivenPrim { points, normals, velocities, tangents, orientations, points_name, reach };
            clips.write(*time, &mesh, &[moved]).expect("a clip");
        }
        let mut layer = empty();
        clips.author(file, &mut layer, &mesh).expect("a manifest");
        (clips, layer)
    }

    fn content(folder: &FilePath) -> Vec<(PathBuf, Vec<u8>)> {
        let mut files: Vec<_> =
            contents(folder).into_iter().map(|p| (p.clone(), fs::read(p).expect("a file"))).collect();
        files.sort();
        files
    }

    #[test]
    fn an_earlier_shot_is_whole_until_the_new_one_has_its_name() {
        let folder = TempDir::new().expect("a folder");
        let (out, all) = (folder.path().join("shot.usda"), folder.path().join("shot.clips"));
        let file = || OutputFile::find(&out, |_| Ok(false), true).expect("an output");
        let (first, layer) = clips(&file(), &[1.0, 2.0, 3.0]);
        first.finish(&file(), layer).expect("a shot");
        let (shot, before) = (fs::read(&out).expect("a shot"), content(&all));
        assert_eq!(before.len(), 4);

        // All that happens before the layer gets its name.
        let (second, layer) = clips(&file(), &[1.0, 5.0]);
        second.name_all(&mut Vec::new()).expect("names");
        let between = content(&all);
        assert!(before.iter().all(|file| between.contains(file)) && between.len() > 4);
        assert_eq!(fs::read(&out).expect("a shot"), shot);
        drop(second);

        let (again, _) = clips(&file(), &[1.0, 5.0]);
        again.finish(&file(), layer).expect("a shot");
        assert_eq!(content(&all).len(), 3, "clips of the earlier shot are removed");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 2);
    }

    #[test]
    fn names_of_clips_are_known() {
        for name in [
            "frame.00000.usdc",
            "frame.123456.0123456789abcdef.usdc",
            "manifest.usdc",
            "manifest.0123456789abcdef.usdc",
        ] {
            assert!(is_clip(name), "{name}");
        }
        for name in
            ["frame.1.usdc", "frame.00000.usda", "frame.00000.hand.usdc", "notes.usdc", "manifest.x.usdc", ".usdc"]
        {
            assert!(!is_clip(name), "{name}");
        }
    }
}
