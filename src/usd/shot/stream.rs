//! Writes a shot: a layer over the garment with moved points, frame by frame.
//!
//! The crate writer takes all values of a layer at once. So the points go into the file first, behind the room for its header; the
//! writer continues after them, with a short stand-in for each array, and the places of the stand-ins are then replaced by those of
//! the arrays. Source: OpenUSD, `pxr/usd/sdf/crateFile.h` (the layout of the file).

use super::bound::Bound;
use super::cache::{Cache, RATE};
use super::clips::Clips;
use super::crate_samples::CrateStage;
use super::{DriveOptions, DrivenPrim};
use crate::assets::same_file;
use crate::codes;
use crate::names;
use crate::read::first_used;
use crate::write::{Format, OutputFile, Unfinished, add_empty_text, write_crate};
use glam::Vec3;
use openusd::gf::Vec3f;
use openusd::sdf::{self, AbstractData, Data, FieldKey, LayerOffset, Path, PrimSpec, SpecType, Value};
use openusd::sdf::{ValueTypeName, Variability};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path as FilePath, PathBuf};
use tailor_mesh::error::Error;
use tempfile::NamedTempFile;

/// Size of the header of a crate.
const HEADER: u64 = 88;
/// The upper 16 bits of a value that is a `float3` array, not compressed.
const ARRAY: u64 = 1 << 63 | 24 << 48;
/// First number of a stand-in.
const SALT: f32 = 1.234_567e-30;

/// Writes the frames of a shot.
pub struct ShotWriter {
    file: OutputFile,
    layer: Data,
    paths: Vec<Path>,
    /// Time samples of the long arrays of each prim by attribute, as their places in `out`.
    arrays: Vec<Arrays>,
    /// Time samples of the short attributes of each prim.
    values: Vec<BTreeMap<&'static str, sdf::TimeSampleMap>>,
    out: Frames,
}

/// The samples of attributes.
type Arrays = BTreeMap<&'static str, Vec<(f64, Place)>>;

/// Where the frames go.
enum Frames {
    /// Into the shot itself.
    Stream { out: BufWriter<Unfinished<NamedTempFile>>, position: u64 },
    /// Into memory, for text.
    Memory(Vec<Vec<Vec3f>>),
    /// Into a file each.
    Clips(Clips),
}

/// The place of an array: a position in a file, or an index.
type Place = u64;

impl ShotWriter {
    /// A writer of the shot of some options.
    ///
    /// # Errors
    /// An output that may not be written.
    pub fn new(options: &DriveOptions, bound: &Bound, cache: &Cache) -> Result<Self, Error> {
        let times = cache.times();
        let is_used = |file: &FilePath| Ok(used(options, bound, &[file.to_path_buf()])?.is_some());
        let file = OutputFile::find(&options.output, is_used, options.force)?;
        if file.format == Format::Usdz {
            return Err(Error::usd(format!("{} is a package, which takes no shot", options.output.display()))
                .code(codes::OUTPUT_PATH)
                .remedy("write .usdc, and package it with usdzip"));
        }
        let layer = layer(options, bound, &file, times, cache.rate)?;
        let fault = |e: io::Error| file.fault(&e);
        let out = match file.format {
            _ if options.clips => {
                let is_used = |files: &[PathBuf]| used(options, bound, files);
                Frames::Clips(Clips::new(&file, times, options.force, is_used)?)
            }
            Format::Usda => Frames::Memory(Vec::new()),
            _ => {
                let mut out = BufWriter::with_capacity(1 << 20, file.temporary()?);
                out.write_all(&[0; HEADER as usize]).map_err(fault)?;
                Frames::Stream { out, position: HEADER }
            }
        };
        let paths: Vec<Path> = bound.meshes.iter().map(|mesh| mesh.path.clone()).collect();
        let arrays = paths.iter().map(|_| BTreeMap::new()).collect();
        let values = paths.iter().map(|_| BTreeMap::new()).collect();
        let mut writer = Self { file, layer, paths, arrays, values, out };
        for mesh in &bound.meshes {
            PrimSpec::over(&mut writer.layer, &mesh.path).map_err(unwritable)?;
            if mesh.is_skinned {
                unbind(&mut writer.layer, &mesh.path).map_err(unwritable)?;
            }
            let is_driven = |name: &str| name == names::VELOCITIES && cache.has_velocities();
            for (name, kind) in mesh.stale.iter().filter(|(name, _)| !is_driven(name)) {
                block(&mut writer.layer, &mesh.path, name, kind).map_err(unwritable)?;
            }
        }
        Ok(writer)
    }

    /// Writes the meshes at `time`; times ascend.
    ///
    /// # Errors
    /// A full disk.
    pub fn write(&mut self, time: f64, meshes: &[DrivenPrim]) -> Result<(), Error> {
        if let Frames::Clips(clips) = &mut self.out {
            return clips.write(time, &self.paths, meshes);
        }
        for (number, moved) in meshes.iter().enumerate() {
            for (name, value) in moved.values() {
                self.values[number].entry(name).or_default().push((time, value));
            }
            for (name, values) in moved.arrays() {
                let place = self.array(values)?;
                self.arrays[number].entry(name).or_default().push((time, place));
            }
        }
        Ok(())
    }

    fn array(&mut self, values: &[Vec3]) -> Result<Place, Error> {
        match &mut self.out {
            Frames::Stream { out, position } => {
                let place = *position;
                let bytes: &[u8] = bytemuck::cast_slice(values);
                let padding = bytes.len().next_multiple_of(8) - bytes.len();
                let written = out
                    .write_all(&(values.len() as u64).to_le_bytes())
                    .and_then(|()| out.write_all(bytes))
                    .and_then(|()| out.write_all(&[0; 8][..padding]));
                written.map_err(|e| self.file.fault(&e))?;
                *position += 8 + (bytes.len() + padding) as u64;
                Ok(place)
            }
            Frames::Memory(arrays) => {
                let values: &[Vec3f] = bytemuck::cast_slice(values);
                arrays.push(values.to_vec());
                Ok(arrays.len() as u64 - 1)
            }
            Frames::Clips(_) => Ok(0),
        }
    }

    /// Completes the shot and gives it its name.
    ///
    /// # Errors
    /// A full disk.
    pub fn finish(mut self) -> Result<(), Error> {
        match std::mem::replace(&mut self.out, Frames::Memory(Vec::new())) {
            Frames::Memory(mut arrays) => {
                self.author(|place| Value::Vec3fVec(std::mem::take(&mut arrays[place as usize])))?;
                self.file.save(self.layer).map(drop)
            }
            Frames::Clips(mut clips) => {
                clips.author(&self.file, &mut self.layer, &self.paths)?;
                clips.finish(&self.file, self.layer)
            }
            Frames::Stream { out, position } => {
                let (mut places, written) = (Vec::new(), self.arrays.clone());
                self.author(|place| {
                    places.push(place);
                    stand_in(places.len() - 1)
                })?;
                let temporary = out.into_inner().map_err(|e| self.file.fault(e.error()))?;
                append_structure(temporary.as_file(), position, &mut self.layer, &places)
                    .map_err(|e| self.file.fault(&e))?;
                if !reads_back(temporary.path(), self.paths.iter().zip(&written)) {
                    let e = io::Error::other("it does not read back as it was written");
                    return Err(self.file.fault(&e));
                }
                self.file.keep(temporary)
            }
        }
    }

    /// Authors the time samples, each by the value of its place.
    fn author(&mut self, mut value: impl FnMut(Place) -> Value) -> Result<(), Error> {
        let all = self.paths.iter().zip(self.arrays.iter_mut().zip(&mut self.values));
        for (path, (arrays, values)) in all {
            for (name, samples) in std::mem::take(arrays) {
                let samples = samples.into_iter().map(|(time, place)| (time, value(place))).collect();
                sampled(&mut self.layer, path, name, samples).map_err(unwritable)?;
            }
            for (name, samples) in std::mem::take(values) {
                sampled(&mut self.layer, path, name, samples).map_err(unwritable)?;
            }
        }
        Ok(())
    }
}

/// Whether a shot has its arrays at the times and places where they were written. It is not read whole.
fn reads_back<'a>(shot: &FilePath, mut written: impl Iterator<Item = (&'a Path, &'a Arrays)>) -> bool {
    let Some(opened) = CrateStage::open_layer(shot) else { return false };
    written.all(|(path, arrays)| {
        arrays.iter().all(|(name, samples)| {
            let Some(read) = opened.samples(path, name) else { return false };
            samples.iter().copied().eq(read.times().iter().copied().zip(read.places().iter().copied()))
        })
    })
}

/// The first of some files that the garment or the cache uses.
fn used(options: &DriveOptions, bound: &Bound, files: &[PathBuf]) -> Result<Option<usize>, Error> {
    let is_layer = |file: &PathBuf| bound.layers.iter().any(|layer| same_file(layer, file));
    if let Some(layer) = files.iter().position(is_layer) {
        return Ok(Some(layer));
    }
    Ok(first_used(&options.render, files)?.or(first_used(&options.cache.file, files)?))
}

/// The error of a shot that the USD library does not write.
pub fn unwritable(e: impl std::fmt::Display) -> Error {
    Error::usd(format!("the shot cannot be written: {e}")).code(codes::WRITE_FAILED)
}

/// Unbinds a mesh from its skeleton, which would move the points of the cache again: an explicit list without a target.
fn unbind(layer: &mut Data, prim: &Path) -> openusd::Result<()> {
    let path = prim.append_property(names::SKEL_SKELETON)?;
    sdf::RelationshipSpec::new(layer, &path, Variability::Varying, false)?;
    layer.set_field(&path, FieldKey::TargetPaths.as_str(), sdf::PathListOp::explicit([]).into());
    Ok(())
}

/// Blocks an attribute.
fn block(layer: &mut Data, prim: &Path, name: &str, kind: &ValueTypeName) -> openusd::Result<()> {
    let path = prim.append_property(name)?;
    sdf::AttributeSpec::new(layer, &path, kind.clone(), Variability::Varying, false)?;
    layer.set_field(&path, FieldKey::Default.as_str(), Value::ValueBlock);
    Ok(())
}

/// The type of an attribute of a driven mesh.
pub fn type_of(name: &str) -> ValueTypeName {
    match name {
        names::POINTS | names::POSITIONS => ValueTypeName::POINT3F_ARRAY,
        names::ORIENTATIONS => ValueTypeName::QUATH_ARRAY,
        names::NORMALS => ValueTypeName::NORMAL3F_ARRAY,
        names::VELOCITIES | names::TANGENTS => ValueTypeName::VECTOR3F_ARRAY,
        _ => ValueTypeName::FLOAT3_ARRAY,
    }
}

/// Authors the samples of an attribute.
pub fn sampled(layer: &mut Data, prim: &Path, name: &str, samples: sdf::TimeSampleMap) -> openusd::Result<()> {
    let path = prim.append_property(name)?;
    sdf::AttributeSpec::new(layer, &path, type_of(name), Variability::Varying, false)?;
    layer.set_field(&path, FieldKey::TimeSamples.as_str(), Value::TimeSamples(samples));
    Ok(())
}

/// The shot without its samples: a layer over the garment with its metadata and the range of times.
fn layer(
    options: &DriveOptions,
    bound: &Bound,
    file: &OutputFile,
    times: &[f64],
    rate: [Option<f64>; 2],
) -> Result<Data, Error> {
    let root = Path::abs_root();
    let mut data = Data::new();
    data.create_spec(root.clone(), SpecType::PseudoRoot);
    let garment = file.path_to(&options.render)?;
    AbstractData::set_field(&mut data, &root, FieldKey::SubLayers.as_str(), Value::StringVec(vec![garment]));
    let offsets = Value::LayerOffsetVec(vec![LayerOffset::IDENTITY]);
    AbstractData::set_field(&mut data, &root, FieldKey::SubLayerOffsets.as_str(), offsets);
    for (key, value) in &bound.metadata {
        AbstractData::set_field(&mut data, &root, key, value.clone());
    }
    let range = [("startTimeCode", times.first().copied()), ("endTimeCode", times.last().copied())];
    for (key, number) in RATE.into_iter().zip(rate).chain(range) {
        if let Some(number) = number {
            AbstractData::set_field(&mut data, &root, key, Value::Double(number));
        }
    }
    Ok(data)
}

/// The stand-in of an array.
fn stand_in(index: usize) -> Value {
    let [low, high] = [index & 0xffff, index >> 16].map(|part| part as f32);
    Value::Vec3fVec(vec![[SALT, low, high].into()])
}

/// Writes the layer after the arrays, which end at `position`, and points it to them.
fn append_structure(file: &File, position: u64, layer: &mut Data, places: &[u64]) -> io::Result<()> {
    let mut out = AfterArrays { file, arrays_end: position, is_begun: false };
    let mut buffered = Vec::new();
    out.rewind()?;
    add_empty_text(layer);
    write_crate(layer, &mut out).map_err(io::Error::other)?;
    // All but the header and the arrays is short.
    let mut file = file;
    file.seek(SeekFrom::Start(position))?;
    file.read_to_end(&mut buffered)?;
    let replaced = point_to(&mut buffered, position, places);
    if replaced != places.len() {
        return Err(io::Error::other("the crate has an unexpected layout; please report it"));
    }
    file.seek(SeekFrom::Start(position))?;
    file.write_all(&buffered)
}

/// Replaces the values that point to stand-ins by values that point to arrays. Returns their number.
fn point_to(bytes: &mut [u8], start: u64, places: &[u64]) -> usize {
    let number = |bytes: &[u8], at: usize| Some(u64::from_le_bytes(bytes.get(at..at + 8)?.try_into().ok()?));
    let part = |bytes: &[u8], at: usize| Some(f32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
    let stand_in = |bytes: &[u8], value: u64| {
        let at = usize::try_from((value & !(0xffff << 48)).checked_sub(start)?).ok()?;
        let is_one = number(bytes, at)? == 1 && part(bytes, at + 8)?.to_bits() == SALT.to_bits();
        is_one.then_some(part(bytes, at + 12)? as usize | (part(bytes, at + 16)? as usize) << 16)
    };
    let mut replaced = 0;
    let mut at = 0;
    while let Some(value) = number(bytes, at) {
        let index = if value >> 48 == ARRAY >> 48 { stand_in(bytes, value) } else { None };
        match index.and_then(|index| places.get(index)) {
            Some(place) => {
                bytes[at..at + 8].copy_from_slice(&(ARRAY | place).to_le_bytes());
                replaced += 1;
                at += 8;
            }
            None => at += 1,
        }
    }
    replaced
}

/// A file that the crate writer continues after the arrays: behind the header comes their end.
struct AfterArrays<'a> {
    file: &'a File,
    arrays_end: u64,
    is_begun: bool,
}

impl Write for AfterArrays<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for AfterArrays<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        // The writer keeps room for the header by seeking behind it, first of all.
        match to {
            SeekFrom::Start(behind) if behind > 0 && !self.is_begun => {
                self.is_begun = true;
                self.file.seek(SeekFrom::Start(self.arrays_end))
            }
            to => self.file.seek(to),
        }
    }
}
