//! Points in NumPy files: an array of shape (frames, points, 3), alone (`.npy`) or in an archive (`.npz`).
//!
//! In an archive it is called `points`, or is the only array of that shape. An array `times` has the times of the frames, as floats or
//! integers; they are numbered from 1 without it. Source: NumPy enhancement proposal 1, *A Simple File Format for NumPy Arrays*.

use crate::codes;
use flate2::read::DeflateDecoder;
use glam::Vec3;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use tailor_mesh::error::{Error, ErrorKind, plain};
use tailor_mesh::files;
use zip::{CompressionMethod, ZipArchive};

/// Longest header of an array that is read. \[bytes\]
const MAX_HEADER: usize = 1 << 16;
/// Most frames of a cache: eleven hours at 24 frames a second.
const MAX_FRAMES: usize = 1_000_000;
/// Most bytes that one packed byte stands for (RFC 1951: 258 for two bits).
const MAX_PACKING: u64 = 1032;

/// The type of the numbers of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Number {
    F32,
    F64,
    /// An integer of so many bytes.
    Int(usize),
    /// One without a sign.
    Uint(usize),
}

impl Number {
    /// The type of a `descr`.
    fn of(descr: &str) -> Option<Self> {
        let (kind, size) = (descr.get(..2)?, descr.get(2..)?.parse().ok()?);
        match (kind, size) {
            ("<f", 4) => Some(Self::F32),
            ("<f", 8) => Some(Self::F64),
            ("<i", 2 | 4 | 8) | ("|i", 1) => Some(Self::Int(size)),
            ("<u", 2 | 4 | 8) | ("|u", 1) => Some(Self::Uint(size)),
            _ => None,
        }
    }

    fn size(self) -> usize {
        match self {
            Self::F32 => 4,
            Self::F64 => 8,
            Self::Int(size) | Self::Uint(size) => size,
        }
    }

    fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }
}

/// An integer in at most eight little-endian bytes.
fn integer(bytes: &[u8], is_signed: bool) -> f64 {
    let mut wide = [0; 8];
    wide[..bytes.len()].copy_from_slice(bytes);
    let unsigned = u64::from_le_bytes(wide);
    if !is_signed {
        return unsigned as f64;
    }
    let unused = 64 - 8 * bytes.len() as u32;
    (((unsigned << unused) as i64) >> unused) as f64
}

/// The header of an array.
#[derive(Debug, PartialEq)]
struct Header {
    number: Number,
    shape: Vec<usize>,
}

impl Header {
    /// Whether an array of this shape has a value, and all of them fit into `bytes`.
    fn fits(&self, bytes: u64) -> bool {
        let size = self.shape.iter().try_fold(self.number.size(), |size, &n| size.checked_mul(n));
        size.is_some_and(|size| size > 0 && size as u64 <= bytes)
    }
}

/// Frames of points.
pub struct NumpyFrames {
    path: PathBuf,
    times: Vec<f64>,
    points: usize,
    number: Number,
    data: Box<dyn Read + Send>,
    next: usize,
}

impl NumpyFrames {
    /// Opens `.npy` or `.npz`.
    ///
    /// # Errors
    /// A file that is neither, or has no array of points.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let fault = |text: String| {
            Error::new(ErrorKind::Usd, path.display(), text)
                .code(codes::CACHE_FILE)
                .remedy("save it as numpy.savez(file, points=array of shape (frames, points, 3))")
        };
        let unread = |e: io::Error| fault(format!("cannot be read: {}", plain(&e)));
        let is_archive = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("npz"));
        let (header, data, times) = match is_archive {
            true => archived(path).map_err(unread)?.ok_or_else(|| fault("it has no array of points".into()))?,
            false => {
                let file = files::open(path).map_err(unread)?;
                let size = file.metadata().map_err(unread)?.len();
                let mut data: Box<dyn Read + Send> = Box::new(BufReader::new(file));
                (header(&mut data, size).map_err(unread)?, data, None)
            }
        };
        let [frames, points, 3] = header.shape[..] else {
            return Err(fault(format!("its array has the shape {:?}", header.shape)));
        };
        if !header.number.is_float() {
            return Err(fault("its points are integers".into()));
        }
        if frames > MAX_FRAMES {
            return Err(fault(format!("it has {frames} frames, and a cache has at most {MAX_FRAMES}")));
        }
        let times = times.unwrap_or_else(|| (1..=frames).map(|frame| frame as f64).collect());
        if times.len() != frames {
            return Err(fault(format!("it has {} times and {frames} frames", times.len())));
        }
        Ok(Self { path: path.to_path_buf(), times, points, number: header.number, data, next: 0 })
    }

    /// The times of the frames.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The number of points.
    pub fn points(&self) -> usize {
        self.points
    }

    /// Frame `i`; frames are read in order.
    ///
    /// # Errors
    /// A file that cannot be read, or was cut.
    pub fn read(&mut self, i: usize) -> Result<Vec<Vec3>, Error> {
        let fault = |e: io::Error| {
            let text = format!("frame {} cannot be read: {}", i + 1, plain(&e));
            Error::new(ErrorKind::Usd, self.path.display(), text).code(codes::CACHE_FILE).remedy("save it again")
        };
        if i != self.next {
            return Err(Error::internal("NumPy frames are read in order"));
        }
        self.next += 1;
        vectors(&mut self.data, self.points, self.number).map_err(fault)
    }
}

/// The array of points of an archive with its header, and the times.
type Archived = (Header, Box<dyn Read + Send>, Option<Vec<f64>>);

fn archived(path: &Path) -> io::Result<Option<Archived>> {
    let mut archive = ZipArchive::new(BufReader::new(files::open(path)?)).map_err(io::Error::other)?;
    let (mut points, mut times) = (None, None);
    for i in 0..archive.len() {
        let entry = archive.by_index_raw(i).map_err(io::Error::other)?;
        let name = entry.name().map_err(io::Error::other)?.trim_end_matches(".npy").to_owned();
        let (start, size, method) = (entry.data_start(), entry.compressed_size(), entry.compression());
        drop(entry);
        let Some(start) = start else { continue };
        let mut file = files::open(path)?;
        file.seek(SeekFrom::Start(start))?;
        let packed = BufReader::new(file.take(size));
        let (mut data, size): (Box<dyn Read + Send>, u64) = match method {
            CompressionMethod::Stored => (Box::new(packed), size),
            CompressionMethod::Deflated => (Box::new(DeflateDecoder::new(packed)), size.saturating_mul(MAX_PACKING)),
            _ => continue,
        };
        let header = match header(&mut data, size) {
            Err(e) if name == "times" => return Err(io::Error::other(format!("its times: {}", plain(&e)))),
            Err(_) => continue,
            Ok(header) => header,
        };
        match header.shape[..] {
            [count] if name == "times" && count > MAX_FRAMES => {
                return Err(io::Error::other(format!("it has {count} times, and a cache has at most {MAX_FRAMES}")));
            }
            [count] if name == "times" => times = Some(numbers(&mut data, count, header.number)?),
            _ if name == "times" => {
                return Err(io::Error::other(format!("its times have the shape {:?}", header.shape)));
            }
            [_, _, 3] if header.number.is_float() && (name == "points" || points.is_none()) => {
                points = Some((header, data));
            }
            _ => {}
        }
    }
    Ok(points.map(|(header, data)| (header, data, times)))
}

/// Reads the header of an array that is at most `bytes` long.
fn header(data: &mut impl Read, bytes: u64) -> io::Result<Header> {
    let invalid = |text: &str| io::Error::new(io::ErrorKind::InvalidData, text.to_owned());
    let mut start = [0; 8];
    data.read_exact(&mut start)?;
    if &start[..6] != b"\x93NUMPY" {
        return Err(invalid("it is not a NumPy array"));
    }
    let mut size = vec![0; if start[6] == 1 { 2 } else { 4 }];
    data.read_exact(&mut size)?;
    let size = size.iter().rev().fold(0usize, |n, byte| n << 8 | usize::from(*byte));
    if size > MAX_HEADER {
        return Err(invalid("its header is too long"));
    }
    let mut text = vec![0; size];
    data.read_exact(&mut text)?;
    let header = parsed(&String::from_utf8_lossy(&text));
    let header = header.ok_or_else(|| invalid("it is not an array of floats or integers in C order"))?;
    if header.fits(bytes) { Ok(header) } else { Err(invalid("it has no value, or is cut")) }
}

/// The header in the text of a Python dictionary such as `{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }`.
fn parsed(text: &str) -> Option<Header> {
    let after = |key: &str| text.split_once(&format!("'{key}':")).map(|(_, rest)| rest.trim_start());
    let number = Number::of(after("descr")?.split('\'').nth(1)?)?;
    if !after("fortran_order")?.starts_with("False") {
        return None;
    }
    let shape = after("shape")?.strip_prefix('(')?.split_once(')')?.0;
    let sizes = shape.split(',').map(str::trim).filter(|size| !size.is_empty());
    Some(Header { number, shape: sizes.map(|size| size.parse().ok()).collect::<Option<_>>()? })
}

fn numbers(data: &mut impl Read, count: usize, number: Number) -> io::Result<Vec<f64>> {
    let mut all = Vec::new();
    // Bounded by the data and not by the count that a header claims.
    let wanted = (count as u64).saturating_mul(number.size() as u64);
    if data.take(wanted).read_to_end(&mut all)? as u64 != wanted {
        return Err(io::Error::from(io::ErrorKind::UnexpectedEof));
    }
    Ok(match number {
        Number::F32 => all.as_chunks().0.iter().map(|b| f64::from(f32::from_le_bytes(*b))).collect(),
        Number::F64 => all.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect(),
        Number::Int(size) => all.chunks_exact(size).map(|b| integer(b, true)).collect(),
        Number::Uint(size) => all.chunks_exact(size).map(|b| integer(b, false)).collect(),
    })
}

fn vectors(data: &mut impl Read, count: usize, number: Number) -> io::Result<Vec<Vec3>> {
    let all = numbers(data, 3 * count, number)?;
    Ok(all.chunks_exact(3).map(|p| Vec3::new(p[0] as f32, p[1] as f32, p[2] as f32)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_of_arrays_are_understood() {
        let text = "{'descr': '<f4', 'fortran_order': False, 'shape': (24, 5950, 3), }   \n";
        assert_eq!(parsed(text), Some(Header { number: Number::F32, shape: vec![24, 5950, 3] }));
        assert_eq!(parsed(&text.replace("(24, 5950, 3)", "(7,)")).map(|h| h.shape), Some(vec![7]));
        for bad in [">i4", ">f4", "<f2", "|b1", "|O", "<c8"] {
            assert_eq!(parsed(&text.replace("<f4", bad)), None);
        }
        assert_eq!(parsed(&text.replace("False", "True")), None);
    }

    #[test]
    fn integers_are_numbers() {
        let all = |descr: &str, bytes: &[u8]| {
            let number = Number::of(descr).expect("a known type");
            numbers(&mut &bytes[..], bytes.len() / number.size(), number).expect("whole numbers")
        };
        for (descr, size) in [("|i1", 1), ("<i2", 2), ("<i4", 4), ("<i8", 8)] {
            let bytes: Vec<u8> = [-3_i64, 0, 100].iter().flat_map(|n| n.to_le_bytes()[..size].to_vec()).collect();
            assert_eq!(all(descr, &bytes), [-3.0, 0.0, 100.0], "{descr}");
        }
        assert_eq!(all("|u1", &[1, 255]), [1.0, 255.0]);
        assert_eq!(all("<u4", &[255; 4]), [f64::from(u32::MAX)]);
    }

    #[test]
    fn a_shape_beyond_its_file_is_refused() {
        let of = |shape: &[usize]| Header { number: Number::F64, shape: shape.to_vec() };
        assert!(of(&[2, 5, 3]).fits(240) && !of(&[2, 5, 3]).fits(239));
        assert!(!of(&[usize::MAX, 2, 3]).fits(u64::MAX));
        assert!(!of(&[usize::MAX, 0, 3]).fits(u64::MAX), "frames without points are not frames");
    }

    #[test]
    fn a_short_file_is_an_error() {
        let data = [0u8; 20];
        assert!(vectors(&mut &data[..], 2, Number::F32).is_err());
        assert!(numbers(&mut &data[..], usize::MAX, Number::F64).is_err());
        assert_eq!(vectors(&mut &data[..], 1, Number::F32).expect("a point"), [Vec3::ZERO]);
    }
}
