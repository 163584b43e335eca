//! The size of a shot. A small file may say that it has any number of frames.

use super::DriveOptions;
use super::bound::{Bound, BoundPrim};
use super::cache::Cache;
use tailor_mesh::error::Error;

/// A shot that is written whatever its cache is. \[bytes\]
const ALWAYS: u64 = 1 << 30;
/// Largest shot by default. \[sizes of its cache on the disk\]
const MOST_CACHES: u64 = 1000;

/// Refuses a shot that is much larger than its cache, or than it may be, before its first frame is written.
///
/// # Errors
/// Such a shot.
pub fn check_size(options: &DriveOptions, bound: &Bound, cache: &Cache) -> Result<(), Error> {
    let frames = cache.times().len() as u64;
    let of_frame: u64 = bound.meshes.iter().map(|mesh| mesh.bytes(cache.has_velocities())).sum();
    let size = of_frame.saturating_mul(frames);
    let by_default = || cache.bytes_on_disk().map(|bytes| MOST_CACHES.saturating_mul(bytes).max(ALWAYS));
    let Some(limit) = options.max_size.or_else(by_default).filter(|limit| size > *limit) else { return Ok(()) };
    let in_words = |bytes: u64| format!("{:.1} MB", bytes as f64 / 1e6);
    let text = format!("its {frames} frames make a shot of {}, which may have {}", in_words(size), in_words(limit));
    let remedy = format!("see if it has so many, and allow the shot by --max-size {}M", size.div_ceil(1 << 20));
    Err(cache.fault(&text).code(tailor::codes::TOO_LARGE).remedy(remedy))
}

impl BoundPrim {
    /// The bytes of its values in a frame.
    fn bytes(&self, has_velocities: bool) -> u64 {
        let normals = self.normals.as_ref().map_or(0, |normals| normals.values.len());
        let tangents = self.tangents.as_ref().map_or(0, Vec::len);
        let rotations = self.orientations.as_ref().map_or(0, Vec::len);
        let vectors = self.points * (1 + usize::from(has_velocities)) + normals + tangents;
        (12 * vectors + 8 * rotations) as u64
    }
}
