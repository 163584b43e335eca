//! A cache that is played on a mesh in memory: any frame, at any time.

use super::bound::MeshAtBind;
use super::cache::{Cache, CacheFile, Frame};
use super::check_first;
use super::conversion::{Conversion, StageMetrics};
use super::space::{Clock, Motion, TIME_CODES};
use crate::read::Source;
use glam::Vec3;
use openusd::sdf::Path;
use tailor_mesh::error::Error;
use tailor_mesh::garment::Mesh;

/// A cache that moves a mesh. One frame is in memory at a time.
pub struct Playback {
    file: CacheFile,
    mesh: MeshAtBind,
    cache: Cache,
    conversion: Conversion,
    /// The frame after the last one that was read.
    next: usize,
}

impl Playback {
    /// Opens a cache that moves `mesh`, which is at `path` of the garment's stage. Frames may be missing.
    ///
    /// # Errors
    /// A file that is not a cache; a cache of another mesh, or with points in another order.
    pub fn open(file: &CacheFile, path: &str, mesh: &Mesh, source: &Source) -> Result<Self, Error> {
        let path = Path::new(path).map_err(|e| Error::usd(format!("{path} is not a path: {e}")))?;
        let counts = mesh.faces.ids().map(|face| mesh.faces.valence(face));
        let corners = mesh.faces.corners().iter().map(|v| v.index() as u32).collect();
        let model = &source.model;
        let metrics = StageMetrics::of(&model.stage_metadata);
        let mesh = MeshAtBind::new(path, mesh.points.as_slice().to_vec(), counts, corners, metrics);
        let mut cache = Cache::open(file, &mesh)?;
        cache.check_times(true)?;
        let mut first = cache.read(0)?;
        let garment = Motion { at_bind: model.transforms.to_world, ..Motion::default() };
        let clock = Clock::new(cache.rate, &model.stage_metadata);
        let conversion = Conversion::new(&cache, file.space, &mesh, garment, clock);
        conversion.apply(&mut first)?;
        check_first(&mesh, &first, &file.file)?;
        Ok(Self { file: file.clone(), mesh, cache, conversion, next: 1 })
    }

    /// The times of the frames, ascending. \[time codes\]
    pub fn times(&self) -> &[f64] {
        self.cache.times()
    }

    /// Frames of a second.
    pub fn rate(&self) -> f64 {
        let [frames, codes] = self.cache.rate;
        let codes = codes.or(frames).unwrap_or(TIME_CODES);
        let times = self.times();
        let span = times[times.len() - 1] - times[0];
        if span > 0.0 { codes * (times.len() - 1) as f64 / span } else { codes }
    }

    /// The points of the mesh in a frame.
    ///
    /// # Errors
    /// A frame that cannot be read, or has points that are not finite.
    pub fn points(&mut self, frame: usize) -> Result<Vec<Vec3>, Error> {
        let mut read = self.read(frame)?;
        self.conversion.apply(&mut read)?;
        Ok(read.points)
    }

    /// Reads a frame. Where frames are read in order, those between are skipped, and an earlier one begins anew.
    fn read(&mut self, frame: usize) -> Result<Frame, Error> {
        if self.cache.is_in_order() {
            if frame < self.next {
                self.cache = Cache::open(&self.file, &self.mesh)?;
                self.next = 0;
            }
            for skipped in self.next..frame {
                self.cache.read(skipped)?;
            }
        }
        self.next = frame + 1;
        self.cache.read(frame)
    }
}
