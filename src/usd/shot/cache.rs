//! Caches of moved points.

use super::bound::MeshAtBind;
use super::conversion::StageMetrics;
use super::crate_samples::{CrateSamples, CrateStage};
use super::numpy::NumpyFrames;
use super::space::Motion;
use crate::codes;
use crate::names;
use crate::read::{
    OrUnreadable, StageOrigin, all_prims, is_a, prim_at, property_names, stage_metadata, value, vectors, with_ancestors,
};
use crate::values::number;
use glam::Vec3;
use openusd::sdf::{FieldKey, Path, Specifier, Value, ValueTypeName};
use openusd::usd::{Prim, PrimPredicate, Stage, TimeCode};
use serde::Deserialize;
use std::path::{Path as FilePath, PathBuf};
use tailor_mesh::error::{Error, ErrorKind, Warning};

/// The metadata of a cache that a shot has too: frames and time codes per second.
pub const RATE: [&str; 2] = ["framesPerSecond", "timeCodesPerSecond"];

/// The values of [`RATE`] in the metadata of a stage.
pub fn rates(metadata: &[(String, Value)]) -> [Option<f64>; 2] {
    RATE.map(|key| metadata.iter().find(|(k, _)| k == key).and_then(|(_, value)| number(value)))
}

/// A cache, and the mesh in it.
#[derive(Clone, Debug, Default)]
pub struct CacheFile {
    /// A USD file with time-sampled points, `.npz` or `.npy`.
    pub file: PathBuf,
    /// Path of the mesh in it; by default that of the mesh which it moves, or the only one with its points.
    pub prim: Option<String>,
    /// The space of its points; by default what the transforms of a USD file say, and otherwise that of the mesh which it moves.
    pub space: Option<CacheSpace>,
}

/// The space of the points of a cache.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum CacheSpace {
    /// That of the stage.
    World,
    /// That of the mesh which the cache moves.
    Local,
}

/// The mesh at one time.
pub struct Frame {
    /// \[time codes\]
    pub time: f64,
    pub points: Vec<Vec3>,
    /// \[units per second\]
    pub velocities: Option<Vec<Vec3>>,
}

/// The points of a mesh over time, read one frame at a time.
pub struct Cache {
    file: PathBuf,
    times: Vec<f64>,
    /// The values of [`RATE`], where the cache states them.
    pub rate: [Option<f64>; 2],
    /// The up axis and unit that its stage states.
    pub metrics: StageMetrics,
    /// From its points to its stage; none where it does not say.
    pub motion: Option<Motion>,
    points: usize,
    frames: Frames,
    /// The notes about its layers that were converted.
    pub notes: Vec<Warning>,
}

/// Where the frames are.
enum Frames {
    /// A crate, of which frames are read alone.
    Crate { points: CrateSamples, velocities: Option<CrateSamples> },
    /// Any other stage.
    Stage { stage: Box<Stage>, prim: Path, has_velocities: bool },
    /// A NumPy array.
    Numpy(NumpyFrames),
}

impl Cache {
    /// Opens a cache that moves `mesh`.
    ///
    /// # Errors
    /// A file that is not a cache; a mesh with other faces.
    pub fn open(cache: &CacheFile, mesh: &MeshAtBind) -> Result<Self, Error> {
        let file = &cache.file;
        let extension = file.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        let opened = match extension.as_str() {
            "npz" | "npy" => {
                let frames = NumpyFrames::open(file)?;
                let (times, points) = (frames.times().to_vec(), frames.points());
                Self {
                    file: file.clone(),
                    times,
                    rate: [None; 2],
                    metrics: StageMetrics::default(),
                    motion: None,
                    points,
                    frames: Frames::Numpy(frames),
                    notes: Vec::new(),
                }
            }
            "usd" | "usda" | "usdc" | "usdz" => Self::of_stage(cache, mesh)?,
            _ => {
                let fault =
                    Error::usd(format!("{} is not a cache that can be read", file.display())).code(codes::CACHE_FILE);
                return Err(fault.remedy("give a USD file, .npz or .npy; convert an Alembic with usdcat"));
            }
        };
        if opened.times.is_empty() {
            return Err(opened
                .fault("it has no frames")
                .code(codes::CACHE_FRAMES)
                .remedy("cache the points of the simulation mesh over time"));
        }
        let points = mesh.points.len();
        if opened.points != points {
            let text = format!("it has {} points, and {} has {}", opened.points, mesh.path, points);
            return Err(opened
                .fault(&text)
                .code(codes::CACHE_MISMATCH)
                .remedy("simulate this garment again, or drive the one that was simulated"));
        }
        Ok(opened)
    }

    /// The bytes that its file takes on the disk; none where its frames may be in several files.
    pub fn bytes_on_disk(&self) -> Option<u64> {
        let file = self.file.metadata().ok().filter(|_| !matches!(self.frames, Frames::Stage { .. }))?;
        #[cfg(unix)]
        // A sparse file has fewer blocks than its size tells.
        return Some(file.len().min(512 * std::os::unix::fs::MetadataExt::blocks(&file)));
        #[cfg(not(unix))]
        Some(file.len())
    }

    /// A fault of the file.
    pub fn fault(&self, text: &str) -> Error {
        Error::new(ErrorKind::Usd, self.file.display(), text).code(codes::CACHE_FILE)
    }

    /// The times of the frames, ascending. \[time codes\]
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Refuses times that do not ascend, and gaps between frames unless they are accepted.
    ///
    /// # Errors
    /// Such times, with the first place.
    pub fn check_times(&self, gaps: bool) -> Result<(), Error> {
        let steps: Vec<f64> = self.times.windows(2).map(|t| t[1] - t[0]).collect();
        if let Some(i) = steps.iter().position(|step| step.is_nan() || *step <= 0.0) {
            return Err(self
                .fault(&format!("its times do not ascend after {}", self.times[i]))
                .code(codes::CACHE_FRAMES)
                .remedy("sort its frames"));
        }
        let mut sorted = steps.clone();
        sorted.sort_by(f64::total_cmp);
        // The lower one of two in the middle, so that a gap among three frames is one.
        let Some(&usual) = sorted.get(sorted.len().saturating_sub(1) / 2) else { return Ok(()) };
        let missing = |step: &f64| *step > 1.5 * usual;
        let Some(i) = steps.iter().position(missing).filter(|_| !gaps) else { return Ok(()) };
        let count = steps.iter().filter(|step| missing(step)).count();
        let text = format!(
            "frames are missing between {} and {}, and at {count} places in all",
            self.times[i],
            self.times[i + 1]
        );
        Err(self.fault(&text).code(codes::CACHE_FRAMES).remedy("cache them again, or accept gaps with --gaps"))
    }

    /// Whether its frames have velocities.
    pub fn has_velocities(&self) -> bool {
        matches!(self.frames, Frames::Crate { velocities: Some(_), .. } | Frames::Stage { has_velocities: true, .. })
    }

    /// Whether frames can only be read one after another.
    pub fn is_in_order(&self) -> bool {
        matches!(self.frames, Frames::Numpy(_))
    }

    /// Reads frame `i`; see [`Cache::is_in_order`].
    ///
    /// # Errors
    /// A frame without a value, or with points or velocities of another number or that are not finite.
    pub fn read(&mut self, i: usize) -> Result<Frame, Error> {
        let time = self.times[i];
        let (points, velocities) = match &mut self.frames {
            Frames::Crate { points, velocities } => {
                (points.read(i)?, velocities.as_mut().map(|v| v.read(i)).transpose()?)
            }
            Frames::Numpy(frames) => (frames.read(i)?, None),
            Frames::Stage { stage, prim, has_velocities } => {
                let prim = prim_at(stage, prim)?;
                let points = vectors_at(&prim, names::POINTS, time)?;
                let velocities = has_velocities.then(|| vectors_at(&prim, names::VELOCITIES, time)).transpose()?;
                (points, velocities)
            }
        };
        self.check_values(time, "points", &points)?;
        if let Some(velocities) = &velocities {
            self.check_values(time, "velocities", velocities)?;
        }
        Ok(Frame { time, points, velocities })
    }

    /// Refuses values of a frame that are not one for each point, or not finite.
    fn check_values(&self, time: f64, name: &str, values: &[Vec3]) -> Result<(), Error> {
        let fault = |text: String| Err(self.fault(&text).code(codes::CACHE_FRAMES).remedy("cache this frame again"));
        if values.len() != self.points {
            return fault(format!("frame {time} has {} {name} instead of {}", values.len(), self.points));
        }
        match values.iter().position(|value| !value.is_finite()) {
            Some(v) => fault(format!("the {name} of frame {time} are not finite at point {v}")),
            None => Ok(()),
        }
    }

    fn of_stage(cache: &CacheFile, mesh: &MeshAtBind) -> Result<Self, Error> {
        if let Some(cache) = CrateStage::open(&cache.file).and_then(|layer| Self::of_crate(layer, cache, mesh)) {
            return cache;
        }
        let file = &cache.file;
        let origin = StageOrigin::new(file, None, &[]);
        let stage = origin.open()?;
        let path = chosen(&sampled_meshes(&stage, file, mesh)?, cache, mesh)?;
        let prim = prim_at(&stage, &path)?;
        let first = prim.attribute(names::FACE_VERTEX_INDICES).time_sample_times().or_unreadable(&path)?;
        let time = first.first().map(|time| TimeCode::new(*time));
        check_faces(value(&prim, names::FACE_VERTEX_INDICES, time)?, &path, file, mesh)?;
        let metadata = stage_metadata(&stage)?;
        let rate = rates(&metadata);
        let mut times = prim.attribute(names::POINTS).time_sample_times().or_unreadable(&path)?;
        if has_clips(&prim)? {
            // A template has times of files that are not there.
            let is_there = |time: &f64| Ok(vectors(&prim, names::POINTS, Some(TimeCode::new(*time)))?.map(|_| *time));
            times = times.iter().filter_map(|time| is_there(time).transpose()).collect::<Result<_, Error>>()?;
        }
        let velocities = prim.attribute(names::VELOCITIES).time_sample_times().or_unreadable(&path)?;
        let points = match times.first() {
            Some(first) => vectors_at(&prim, names::POINTS, *first)?.len(),
            None => 0,
        };
        let has_velocities = !times.is_empty() && velocities == times;
        let metrics = StageMetrics::of(&metadata);
        // Overs alone are meant for a layer over the garment, whose transforms they have there.
        let motion = prim.is_defined().or_unreadable(&path)?.then(|| Motion::of(&prim, None)).transpose()?;
        let frames = Frames::Stage { stage: Box::new(stage), prim: path, has_velocities };
        let notes = origin.read.notes();
        Ok(Self { file: file.clone(), times, rate, metrics, motion, points, frames, notes })
    }

    /// A cache in one crate without transforms, whose frames are read from the file one by one; `None` if they cannot be.
    fn of_crate(mut layer: CrateStage, cache: &CacheFile, mesh: &MeshAtBind) -> Option<Result<Self, Error>> {
        let path = match chosen(&layer.sampled(names::POINTS), cache, mesh) {
            Ok(path) => path,
            Err(e) => return Some(Err(e)),
        };
        if with_ancestors(&path).any(|path| layer.has(&path, names::XFORM_OP_ORDER)) {
            return None;
        }
        let is_def = |path: Path| layer.read(&path, "specifier") == Some(Value::Specifier(Specifier::Def));
        let motion = with_ancestors(&path).all(is_def).then(Motion::default);
        let points = layer.samples(&path, names::POINTS)?;
        let velocities = layer.samples(&path, names::VELOCITIES).filter(|v| v.times() == points.times());
        let indices = path.append_property(names::FACE_VERTEX_INDICES).ok()?;
        let corners = layer.read(&indices, FieldKey::Default.as_str());
        if let Err(e) = check_faces(corners, &path, &cache.file, mesh) {
            return Some(Err(e));
        }
        let stated = |key: &str| Some((key.to_owned(), layer.read(&Path::abs_root(), key)?));
        let keys = RATE.into_iter().chain([names::UP_AXIS, names::METERS_PER_UNIT]);
        let metadata: Vec<_> = keys.filter_map(stated).collect();
        let count = match points.first_len() {
            Ok(count) => count,
            Err(e) => return Some(Err(e)),
        };
        let times = points.times().to_vec();
        let frames = Frames::Crate { points, velocities };
        let (rate, metrics) = (rates(&metadata), StageMetrics::of(&metadata));
        Some(Ok(Self {
            file: cache.file.clone(),
            times,
            rate,
            metrics,
            motion,
            points: count,
            frames,
            notes: Vec::new(),
        }))
    }
}

fn vectors_at(prim: &Prim, name: &str, time: f64) -> Result<Vec<Vec3>, Error> {
    vectors(prim, name, Some(TimeCode::new(time)))?.ok_or_else(|| {
        let fault = Error::usd(format!("{}.{name} has no value at time {time}", prim.path()));
        fault.code(codes::CACHE_FRAMES).remedy("cache this frame again")
    })
}

/// The meshes of a stage with points over time.
fn sampled_meshes(stage: &Stage, file: &FilePath, mesh: &MeshAtBind) -> Result<Vec<Path>, Error> {
    let mut meshes = Vec::new();
    for path in all_prims(stage, file, PrimPredicate::DEFAULT, false)? {
        let prim = prim_at(stage, &path)?;
        if !is_a(&prim, names::MESH)? {
            continue;
        }
        declare_points(&prim)?;
        if prim.attribute(names::POINTS).num_time_samples().or_unreadable(&path)? > 0 {
            meshes.push(path);
        }
    }
    // An over without a type, as a layer over the garment has it, is a mesh only below the garment.
    let own = prim_at(stage, &mesh.path)?;
    if own.is_valid().or_unreadable(&mesh.path)? {
        declare_points(&own)?;
    }
    let is_over = own.attribute(names::POINTS).num_time_samples().is_ok_and(|n| n > 0);
    if is_over && !meshes.contains(&mesh.path) {
        meshes.push(mesh.path.clone());
    }
    Ok(meshes)
}

/// Whether a prim may have its values from clips.
fn has_clips(prim: &Prim) -> Result<bool, Error> {
    for path in with_ancestors(prim.path()) {
        if prim_at(prim.stage(), &path)?.get_metadata::<Value>("clips").or_unreadable(&path)?.is_some() {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Declares points and velocities of a mesh whose clips declare them in their manifest alone. OpenUSD has them by the schema of meshes.
fn declare_points(prim: &Prim) -> Result<(), Error> {
    if !has_clips(prim)? {
        return Ok(());
    }
    let declared = property_names(prim)?;
    let types = [(names::POINTS, ValueTypeName::POINT3F_ARRAY), (names::VELOCITIES, ValueTypeName::VECTOR3F_ARRAY)];
    for (name, kind) in types.into_iter().filter(|(name, _)| declared.iter().all(|own| own != name)) {
        // Only the layer in memory changes.
        prim.create_attribute(name, kind).or_unreadable(prim.path())?;
    }
    Ok(())
}

/// The mesh of the cache: the one that is named, that at the path of `mesh`, or the only one.
fn chosen(meshes: &[Path], cache: &CacheFile, mesh: &MeshAtBind) -> Result<Path, Error> {
    let file = cache.file.display();
    let listed = || meshes.iter().map(Path::as_str).collect::<Vec<_>>().join(", ");
    if let Some(wanted) = &cache.prim {
        let found = meshes.iter().find(|path| path.as_str() == wanted);
        return found.cloned().ok_or_else(|| {
            Error::usd(format!("{wanted} of {file} has no points over time"))
                .code(codes::CACHE_MISMATCH)
                .remedy(format!("the meshes with points over time are: {}", listed()))
        });
    }
    if meshes.contains(&mesh.path) {
        return Ok(mesh.path.clone());
    }
    match meshes {
        [one] => Ok(one.clone()),
        [] => Err(Error::usd(format!("{file} has no mesh with points over time"))
            .code(codes::CACHE_MISMATCH)
            .remedy("cache the points of the simulation mesh over time")),
        _ => Err(Error::usd(format!("{file} has {} meshes with points over time", meshes.len()))
            .code(codes::CACHE_MISMATCH)
            .remedy(format!("choose one by --cache-prim: {}", listed()))),
    }
}

/// Refuses a mesh with other triangles. Programs reverse them and begin them at other corners. A cache without faces has points alone.
fn check_faces(corners: Option<Value>, prim: &Path, file: &FilePath, mesh: &MeshAtBind) -> Result<(), Error> {
    let Some(Value::IntVec(corners)) = corners else { return Ok(()) };
    let sorted = |mut triangle: [i64; 3]| {
        triangle.sort_unstable();
        triangle
    };
    let cached = corners.as_chunks().0.iter().map(|triangle| sorted(triangle.map(i64::from)));
    let own = mesh.corners.as_chunks().0.iter().map(|triangle| sorted(triangle.map(i64::from)));
    if corners.len() == mesh.corners.len() && cached.eq(own) {
        return Ok(());
    }
    let text = match corners.len() == mesh.corners.len() {
        true => format!("has its faces in another order than {}", mesh.path),
        false => format!("has {} corners of faces, and {} has {}", corners.len(), mesh.path, mesh.corners.len()),
    };
    Err(Error::new(ErrorKind::Usd, file.display(), format!("{prim} {text}"))
        .code(codes::CACHE_MISMATCH)
        .remedy("cache the mesh as it was written"))
}
