//! The time samples of one attribute of a crate, read from the file one by one.
//!
//! The USD library reads a file whole, and all samples of an attribute at once. Here it gets the tables of the crate alone, in a
//! buffer whose other pages are never touched, and tells where the samples are. Source: OpenUSD, `pxr/usd/sdf/crateFile.h`.

use crate::codes;
use glam::Vec3;
use openusd::sdf::{FieldKey, Path, Value};
use openusd::usdc::CrateFile;
use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::{Path as FilePath, PathBuf};
use tailor_mesh::error::{Error, ErrorKind, plain};
use tailor_mesh::files;

/// Bits of a value that are its place in the file.
const PLACE: u64 = (1 << 48) - 1;
/// The upper 16 bits of a value that is an array, not compressed.
const ARRAY: u64 = 1 << 15;
/// The type of `float3`, in the lower of these bits.
const VEC3F: u64 = 24;
/// The type of doubles.
const DOUBLE: u64 = 9;
/// The type of lists of doubles.
const DOUBLE_VECTOR: u64 = 48;
/// Size of the header of a crate.
const HEADER: usize = 88;

/// Fields by which a layer brings in others: what it holds is then not all.
const ARCS: [&str; 8] =
    ["subLayers", "references", "payload", "inheritPaths", "specializes", "variantSetNames", "clips", "relocates"];

/// A crate that is a whole stage, of which values are read one by one.
pub struct CrateStage {
    path: PathBuf,
    file: File,
    tables: CrateFile,
}

impl CrateStage {
    /// Opens a crate; `None` for other files, and for layers that bring in others.
    pub fn open(path: &FilePath) -> Option<Self> {
        let is_arc = |name: Option<&String>| name.is_none_or(|name| ARCS.contains(&name.as_str()));
        let is_whole =
            |Self { tables, .. }: &Self| !tables.fields.iter().any(|of| is_arc(tables.tokens.get(of.token_index)));
        Self::open_layer(path).filter(is_whole)
    }

    /// Opens a crate, whatever other layers it brings in.
    pub fn open_layer(path: &FilePath) -> Option<Self> {
        let mut file = files::open(path).ok()?;
        let tables = tables(&mut file, &[]).ok()?;
        Some(Self { path: path.to_path_buf(), file, tables })
    }

    /// The prims with time samples of the property `name`.
    pub fn sampled(&self, name: &str) -> Vec<Path> {
        let specs = self.tables.specs.iter();
        let has_samples = |fields: usize| self.field(fields, FieldKey::TimeSamples.as_str()).is_some();
        let sampled = specs.filter(|spec| has_samples(spec.fieldset_index));
        let paths = sampled.filter_map(|spec| self.tables.paths.get(spec.path_index));
        let of_name = |path: &Path| {
            let prim = path.prim_path();
            (prim.append_property(name).ok().as_ref() == Some(path)).then_some(prim)
        };
        paths.filter_map(of_name).collect()
    }

    /// The samples of the property `name` of `prim`; `None` where it has none of type `float3[]`.
    pub fn samples(&self, prim: &Path, name: &str) -> Option<CrateSamples> {
        let field = self.value(&prim.append_property(name).ok()?, FieldKey::TimeSamples.as_str())?;
        let rep = self.tables.fields[field].value_rep;
        let mut file = files::open(&self.path).ok()?;
        let (times, places) = samples(&mut file, rep.payload()).ok()??;
        Some(CrateSamples { path: self.path.clone(), file, times, places })
    }

    /// Whether there is a property `name` of `prim`.
    pub fn has(&self, prim: &Path, name: &str) -> bool {
        prim.append_property(name).is_ok_and(|path| self.tables.paths.contains(&path))
    }

    /// The value of a field that is a whole number or an array of them, or a double.
    pub fn read(&mut self, path: &Path, key: &str) -> Option<Value> {
        let rep = self.tables.fields[self.value(path, key)?].value_rep;
        if rep.is_inlined() {
            return self.tables.value(rep).ok();
        }
        let place = rep.payload();
        let length = match (rep.is_array(), rep.is_compressed()) {
            (false, _) => 8,
            // The number of values and the size of the packed ones come first.
            (true, true) => 16 + number_at(&mut &self.file, place + 8).ok()?,
            (true, false) => 8 + number_at(&mut &self.file, place).ok()?.checked_mul(4)?,
        };
        let with_value = tables(&mut self.file, &[(place, length)]).ok()?;
        with_value.value(rep).ok()
    }

    /// The index of the field `key` of the spec at `path`.
    fn value(&self, path: &Path, key: &str) -> Option<usize> {
        let index = self.tables.paths.iter().position(|own| own == path)?;
        let spec = self.tables.specs.iter().find(|spec| spec.path_index == index)?;
        self.field(spec.fieldset_index, key)
    }

    /// The index of the field `key` in a set of fields.
    fn field(&self, fieldset: usize, key: &str) -> Option<usize> {
        let mut fields = self.tables.fieldsets.get(fieldset..)?.iter().map_while(|field| *field);
        let name = |field: usize| self.tables.tokens.get(self.tables.fields.get(field)?.token_index);
        fields.find(|&field| name(field).is_some_and(|name| name == key))
    }
}

/// The samples of an attribute of type `float3[]`.
pub struct CrateSamples {
    path: PathBuf,
    file: File,
    times: Vec<f64>,
    places: Vec<u64>,
}

impl CrateSamples {
    /// The times of the samples.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The places of the samples in the file.
    pub fn places(&self) -> &[u64] {
        &self.places
    }

    /// The number of values in the first sample.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn first_len(&self) -> Result<usize, Error> {
        let mut file = &self.file;
        let place = self.places.first().copied().unwrap_or(0);
        number_at(&mut file, place).map(|n| n as usize).map_err(|e| self.fault(&e))
    }

    /// Sample `i`.
    ///
    /// # Errors
    /// A file that cannot be read, or was cut.
    pub fn read(&mut self, i: usize) -> Result<Vec<Vec3>, Error> {
        read_vectors(&mut self.file, self.places[i]).map_err(|e| self.fault(&e))
    }

    fn fault(&self, e: &io::Error) -> Error {
        let text = format!("cannot read its frames: {}", plain(e));
        Error::new(ErrorKind::Usd, self.path.display(), text).code(codes::CACHE_FILE).remedy("cache it again")
    }
}

/// The tables of a crate, and of its values those in some ranges, by start and length.
fn tables(file: &mut File, values: &[(u64, u64)]) -> io::Result<CrateFile> {
    let invalid = || io::Error::from(io::ErrorKind::InvalidData);
    let size = usize::try_from(file.metadata()?.len()).map_err(|_| invalid())?;
    if size < HEADER {
        return Err(invalid());
    }
    // Zeroed memory takes no room until it is written to.
    let mut bytes = vec![0; size];
    let mut fill = |bytes: &mut [u8], start: usize, length: usize| -> io::Result<()> {
        let end = start.checked_add(length).filter(|end| *end <= size).ok_or_else(invalid)?;
        file.seek(SeekFrom::Start(start as u64))?;
        file.read_exact(&mut bytes[start..end])
    };
    fill(&mut bytes, 0, HEADER)?;
    let number = |bytes: &[u8], at: usize| -> Option<usize> {
        usize::try_from(u64::from_le_bytes(bytes.get(at..at.checked_add(8)?)?.try_into().ok()?)).ok()
    };
    let contents = number(&bytes, 16).ok_or_else(invalid)?;
    fill(&mut bytes, contents, 8)?;
    let count = number(&bytes, contents).filter(|n| *n <= 64).ok_or_else(invalid)?;
    fill(&mut bytes, contents + 8, 32 * count)?;
    for entry in (0..count).map(|i| contents + 8 + 32 * i) {
        let (start, length) = number(&bytes, entry + 16).zip(number(&bytes, entry + 24)).ok_or_else(invalid)?;
        fill(&mut bytes, start, length)?;
    }
    for &(start, length) in values {
        let (start, length) = (usize::try_from(start), usize::try_from(length));
        fill(&mut bytes, start.map_err(|_| invalid())?, length.map_err(|_| invalid())?)?;
    }
    CrateFile::open(bytes).map_err(|_| invalid())
}

/// Times and places of samples that start at `place`; `None` if they are not arrays of `float3`.
fn samples(file: &mut File, place: u64) -> io::Result<Option<(Vec<f64>, Vec<u64>)>> {
    let invalid = || io::Error::from(io::ErrorKind::InvalidData);
    let times_at = place.wrapping_add(number_at(&mut &*file, place)?);
    let times_rep = number_at(&mut &*file, times_at)?;
    let is_times = times_rep >> 48 == ARRAY | DOUBLE || times_rep >> 48 & 0xff == DOUBLE_VECTOR;
    if !is_times {
        return Ok(None);
    }
    let times: Vec<f64> = numbers(file, times_rep & PLACE)?.into_iter().map(f64::from_bits).collect();
    let values_at = (times_at + 8).wrapping_add(number_at(&mut &*file, times_at + 8)?);
    let reps = numbers(file, values_at)?;
    if reps.len() != times.len() {
        return Err(invalid());
    }
    let is_plain = |rep: &u64| rep >> 48 == ARRAY | VEC3F;
    Ok(reps.iter().all(is_plain).then(|| (times, reps.iter().map(|rep| rep & PLACE).collect())))
}

fn number_at(file: &mut &File, place: u64) -> io::Result<u64> {
    let mut bytes = [0; 8];
    file.seek(SeekFrom::Start(place))?;
    file.read_exact(&mut bytes)?;
    Ok(u64::from_le_bytes(bytes))
}

/// The number of values at `place`, of `size` bytes each, if the file is long enough.
fn count_at(file: &File, place: u64, size: u64) -> io::Result<usize> {
    let count = number_at(&mut &*file, place)?;
    let left = file.metadata()?.len().saturating_sub(place);
    let fits = count.checked_mul(size).is_some_and(|bytes| bytes <= left);
    if fits { Ok(count as usize) } else { Err(io::Error::from(io::ErrorKind::UnexpectedEof)) }
}

fn numbers(file: &mut File, place: u64) -> io::Result<Vec<u64>> {
    let mut values = vec![0u64; count_at(file, place, 8)?];
    file.read_exact(bytemuck::cast_slice_mut(&mut values))?;
    Ok(values)
}

fn read_vectors(file: &mut File, place: u64) -> io::Result<Vec<Vec3>> {
    let mut values = vec![Vec3::ZERO; count_at(file, place, 12)?];
    file.read_exact(bytemuck::cast_slice_mut(&mut values))?;
    Ok(values)
}
