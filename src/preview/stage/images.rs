//! Images of the materials of a garment, which pages ask for by their numbers.

use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;
use tailor_usd::Look;

/// Largest file. \[bytes\]
const LARGEST: u64 = 256 << 20;

/// Media types that browsers draw, by the ends of names.
const TYPES: [(&str, &str); 4] =
    [("png", "image/png"), ("jpg", "image/jpeg"), ("jpeg", "image/jpeg"), ("webp", "image/webp")];

/// The image files of a garment, each once.
#[derive(Debug, Default)]
pub struct Images(Vec<PathBuf>);

impl Images {
    /// The images of looks that a browser can draw.
    pub fn of<'a>(looks: impl Iterator<Item = &'a Look>) -> Self {
        let mut files: Vec<PathBuf> =
            looks.filter_map(|look| look.texture.clone()).filter(|file| media_type(file).is_some()).collect();
        files.sort_unstable();
        files.dedup();
        Self(files)
    }

    /// The address of a look's image. It is another one after the file has changed.
    pub fn address(&self, look: &Look) -> Option<String> {
        let file = look.texture.as_ref()?;
        let number = self.0.iter().position(|each| each == file)?;
        let changed = fs::metadata(file).ok()?.modified().ok()?;
        let time = changed.duration_since(UNIX_EPOCH).map_or(0, |time| time.as_nanos());
        Some(format!("image/{number}?{time}"))
    }

    /// The media type and the content of the image of a number; none if it cannot be read.
    pub fn read(&self, number: usize) -> Option<(&'static str, Vec<u8>)> {
        let path = self.0.get(number)?;
        // A pipe would wait for ever.
        let about = fs::metadata(path).ok()?;
        if !about.is_file() || about.len() > LARGEST {
            return None;
        }
        let mut content = Vec::new();
        File::open(path).ok()?.take(LARGEST).read_to_end(&mut content).ok()?;
        Some((media_type(path)?, content))
    }
}

fn media_type(file: &Path) -> Option<&'static str> {
    let end = file.extension()?.to_str()?.to_ascii_lowercase();
    TYPES.iter().find(|(name, _)| *name == end).map(|&(_, media_type)| media_type)
}
