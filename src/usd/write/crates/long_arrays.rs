//! Crates in memory with uncompressed integer arrays.
//!
//! The crate writer spends four fifths of its time on compressing long arrays, which the reader of a crate in memory would
//! decompress at once. So the writer gets a short stand-in for each long array. The long arrays are then appended to its
//! crate, with a list of fields that points to them; nothing else moves. Source: OpenUSD, `pxr/usd/sdf/crateFile.h`
//! (the layout of the file).

use super::encode;
use crate::codes;
use openusd::sdf::{AbstractData, Data, Value};
use std::collections::BTreeSet;
use std::mem;
use tailor_mesh::error::Error;

/// Length from which arrays are long. The writer compresses arrays of 16 numbers or more; stand-ins have 4.
const LONG: usize = 256;

/// The fault of a crate without the stand-ins, which is a fault of this program.
const UNEXPECTED: &str = "the crate in memory has an unexpected layout; please report it";

/// `data` as a crate. Its long arrays of `int` are moved out of it.
///
/// # Errors
/// A value that a crate cannot hold.
pub fn encode_plainly(data: &mut Data) -> Result<Vec<u8>, Error> {
    let (arrays, salt) = take_out(data);
    let bytes = encode(data)?;
    if arrays.is_empty() {
        return Ok(bytes);
    }
    put_back(bytes, &arrays, salt).ok_or_else(|| Error::usd(UNEXPECTED).code(codes::WRITE_FAILED))
}

/// Replaces the long arrays of `data` by stand-ins `[salt, index, 0, 0]`; returns the arrays and the salt, which no other
/// array of four begins with.
fn take_out(data: &mut Data) -> (Vec<Vec<i32>>, i32) {
    let paths = data.spec_paths();
    let mut taken = BTreeSet::new();
    let mut long = Vec::new();
    for path in &paths {
        for (key, value) in data.spec(path).into_iter().flat_map(|spec| &spec.fields) {
            match value {
                Value::IntVec(array) if array.len() >= LONG => long.push((path.clone(), key.clone())),
                Value::IntVec(array) if array.len() == 4 => drop(taken.insert(array[0])),
                _ => {}
            }
        }
    }
    let salt = (0..).find(|n| !taken.contains(n)).expect("fewer arrays than numbers");
    let mut arrays = Vec::with_capacity(long.len());
    for (path, key) in long {
        let stand_in = Value::IntVec(vec![salt, arrays.len() as i32, 0, 0]);
        let value = data.spec_mut(&path).and_then(|spec| spec.fields.iter_mut().find(|(k, _)| *k == key));
        if let Some((_, value)) = value
            && let Value::IntVec(array) = mem::replace(value, stand_in)
        {
            arrays.push(array);
        }
    }
    (arrays, salt)
}

/// A section of a crate.
struct Section {
    /// Position of its entry in the table of contents.
    entry: usize,
    start: usize,
    size: usize,
}

/// The crate with the long arrays instead of the stand-ins; none if its layout is not as expected.
fn put_back(mut bytes: Vec<u8>, arrays: &[Vec<i32>], salt: i32) -> Option<Vec<u8>> {
    let contents = usize::try_from(number(&bytes, 16)?).ok()?;
    let fields = find_section(&bytes, contents, b"FIELDS\0")?;
    let table = bytes.get(contents..)?.to_vec();
    let section = bytes.get(fields.start..fields.start + fields.size)?.to_vec();
    bytes.truncate(contents);
    let places: Vec<u64> = arrays.iter().map(|array| append(&mut bytes, array)).collect();
    let new = pointed(&bytes, &section, &places, salt)?;
    align(&mut bytes);
    let start = bytes.len();
    bytes.extend_from_slice(&new);
    align(&mut bytes);
    let new_contents = bytes.len();
    bytes.extend_from_slice(&table);
    let entry = new_contents + fields.entry - contents;
    bytes.get_mut(entry + 16..entry + 24)?.copy_from_slice(&(start as u64).to_le_bytes());
    bytes.get_mut(entry + 24..entry + 32)?.copy_from_slice(&(new.len() as u64).to_le_bytes());
    bytes.get_mut(16..24)?.copy_from_slice(&(new_contents as u64).to_le_bytes());
    Some(bytes)
}

fn number(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(bytes.get(at..at.checked_add(8)?)?.try_into().ok()?))
}

fn find_section(bytes: &[u8], contents: usize, name: &[u8]) -> Option<Section> {
    let count = usize::try_from(number(bytes, contents)?).ok()?;
    let entry =
        (0..count).map(|i| contents + 8 + 32 * i).find(|&e| bytes.get(e..).is_some_and(|b| b.starts_with(name)))?;
    let part = |at: usize| number(bytes, entry + at).and_then(|n| usize::try_from(n).ok());
    Some(Section { entry, start: part(16)?, size: part(24)? })
}

fn align(bytes: &mut Vec<u8>) {
    bytes.resize(bytes.len().next_multiple_of(8), 0);
}

/// Appends an array, its length and its numbers; returns its position.
fn append(bytes: &mut Vec<u8>, array: &[i32]) -> u64 {
    align(bytes);
    let place = bytes.len() as u64;
    bytes.extend_from_slice(&(array.len() as u64).to_le_bytes());
    array.iter().for_each(|n| bytes.extend_from_slice(&n.to_le_bytes()));
    place
}

/// The upper 16 bits of a field's value that is an uncompressed array of `int`.
const PLAIN_INTS: u64 = 1 << 63 | 3 << 48;
/// The bits of a field's value that are its position in the file.
const PLACE: u64 = (1 << 48) - 1;

/// The section of fields, with the positions of the long arrays instead of those of their stand-ins.
fn pointed(bytes: &[u8], section: &[u8], places: &[u64], salt: i32) -> Option<Vec<u8>> {
    let count = usize::try_from(number(section, 0)?).ok()?;
    // The number of fields and their names come first.
    let values = 16 + usize::try_from(number(section, 8)?).ok()?;
    let packed = section.get(values + 8..)?;
    // The byte before the block is the number of further blocks.
    let mut unpacked = lz4_flex::decompress(packed.get(1..)?, 8 * count).ok()?;
    let mut done = 0;
    for value in unpacked.chunks_exact_mut(8) {
        let old = u64::from_le_bytes(value.try_into().ok()?);
        if old & !PLACE != PLAIN_INTS {
            continue;
        }
        if let Some(index) = stand_in(bytes, (old & PLACE) as usize, salt) {
            value.copy_from_slice(&(PLAIN_INTS | places.get(index)?).to_le_bytes());
            done += 1;
        }
    }
    let packed = lz4_flex::compress(&unpacked);
    let mut new = section[..values].to_vec();
    new.extend_from_slice(&(packed.len() as u64 + 1).to_le_bytes());
    new.push(0);
    new.extend_from_slice(&packed);
    (done == places.len()).then_some(new)
}

/// The index of the long array whose stand-in is at `place`; none where there is another array.
fn stand_in(bytes: &[u8], place: usize, salt: i32) -> Option<usize> {
    let part = |at: usize| Some(i32::from_le_bytes(bytes.get(place + at..place + at + 4)?.try_into().ok()?));
    let found = number(bytes, place)? == 4 && part(8)? == salt;
    if found { usize::try_from(part(12)?).ok() } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openusd::sdf::{AttributeSpec, Path, PrimSpec, Specifier, ValueTypeName, Variability};
    use openusd::usdc::CrateData;

    /// A prim with one attribute for each array.
    fn data(arrays: &[Vec<i32>]) -> Data {
        let mut data = Data::new();
        data.create_spec(Path::abs_root(), openusd::sdf::SpecType::PseudoRoot);
        let prim = Path::new("/Coat").expect("a path");
        PrimSpec::new(&mut data, &prim, Specifier::Def, "Mesh").expect("a prim");
        for (i, array) in arrays.iter().enumerate() {
            let path = prim.append_property(format!("a{i}").as_str()).expect("a path");
            AttributeSpec::new(&mut data, &path, ValueTypeName::INT_ARRAY, Variability::Varying, false)
                .expect("an attribute");
            AbstractData::set_field(&mut data, &path, "default", Value::IntVec(array.clone()));
        }
        data
    }

    #[test]
    fn every_array_comes_back() {
        let long = |seed: i32| (0..1000).map(|i| (i * seed) % 777 - 300).collect::<Vec<i32>>();
        // Among them are equal arrays, and short ones that look like stand-ins.
        let arrays =
            [long(3), vec![], vec![0, 0, 0, 0], long(5), vec![1, 1, 0, 0], long(3), vec![7; 255], vec![7; 256]];
        let bytes = encode_plainly(&mut data(&arrays)).expect("a crate");
        let read = CrateData::open(bytes, true).expect("a crate that can be read");
        for (i, array) in arrays.iter().enumerate() {
            let path = Path::new(&format!("/Coat.a{i}")).expect("a path");
            let value = read.get_field(&path, "default").expect("a value").into_owned();
            assert_eq!(value, Value::IntVec(array.clone()), "{path}");
        }
    }

    #[test]
    fn a_crate_that_is_not_as_expected_is_refused() {
        let mut data = data(&[vec![1; 500]]);
        let (arrays, salt) = take_out(&mut data);
        let bytes = encode(&data).expect("a crate");
        let contents = number(&bytes, 16).expect("a place") as usize;
        assert!((0..contents).all(|end| put_back(bytes[..end].to_vec(), &arrays, salt).is_none()));
        assert!(put_back(bytes.clone(), &arrays, salt + 1).is_none());
        assert!(put_back(bytes, &arrays, salt).is_some());
    }
}
