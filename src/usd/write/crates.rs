//! Crate files, with workarounds for faults of the crate writer.

use crate::codes;
use openusd::sdf::{AbstractData, Data, FormatError, Path, Value};
use openusd::usdc::CrateWriter;
use std::io::{Cursor, Seek, SeekFrom, Write};
use tailor_mesh::error::{Error, Warning, Warnings};

/// Position of the minor version in a crate.
const MINOR_VERSION: u64 = 9;

/// The minor version for readers before OpenUSD 24.11. It has all values but those of [`needs_new_version`].
const OLD_MINOR_VERSION: u8 = 8;

/// Writes `data` as a crate of the oldest version that has its values.
///
/// # Errors
/// A value that a crate cannot hold, a failure of `out`.
pub fn write_crate<W: Write + Seek>(data: &Data, out: &mut W) -> Result<(), FormatError> {
    let start = out.stream_position()?;
    CrateWriter::write(data, out)?;
    let new = data.iter().any(|(_, spec)| spec.fields.iter().any(|(_, v)| any(v, &needs_new_version)));
    if !new {
        let end = out.stream_position()?;
        out.seek(SeekFrom::Start(start + MINOR_VERSION))?;
        out.write_all(&[OLD_MINOR_VERSION])?;
        out.seek(SeekFrom::Start(end))?;
    }
    Ok(())
}

/// Adds an empty text to the metadata of a layer that becomes a file. OpenUSD looks for the empty token, as the name of the root, when it
/// saves over a crate, and the crate writer leaves it out.
pub fn add_empty_text(data: &mut Data) {
    let free = ["comment", "documentation", "owner"].into_iter().find(|key| !data.has_field(&Path::abs_root(), key));
    free.into_iter().for_each(|key| data.set_field(&Path::abs_root(), key, Value::String(String::new())));
}

/// `data` as a crate in memory.
///
/// # Errors
/// A value that a crate cannot hold.
pub fn encode(data: &Data) -> Result<Vec<u8>, Error> {
    let mut out = Cursor::new(Vec::new());
    write_crate(data, &mut out)
        .map_err(|e| Error::usd(format!("the layer cannot be written as a crate: {e}")).code(codes::WRITE_FAILED))?;
    Ok(out.into_inner())
}

/// Removes single `half2` values, which the crate writer writes wrongly, and warns of them.
pub fn remove_unwritable(data: &mut Data) -> Warnings {
    let mut warnings = Warnings::default();
    let is_half2 = |v: &Value| matches!(v, Value::Vec2h(_));
    for path in data.spec_paths() {
        let Some(spec) = data.spec_mut(&path) else { continue };
        spec.fields.retain(|(key, value)| {
            let unwritable = any(value, &is_half2);
            if unwritable {
                let why = "a single half2 cannot be written to a crate";
                let warning = Warning::not_carried(format!("{key} of {path}"), why);
                warnings.push(warning.remedy("Write .usda instead"));
            }
            !unwritable
        });
    }
    warnings
}

fn needs_new_version(value: &Value) -> bool {
    matches!(
        value,
        Value::TimeCode(_)
            | Value::TimeCodeVec(_)
            | Value::PathExpression(_)
            | Value::PathExpressionVec(_)
            | Value::Relocates(_)
            | Value::UnregisteredValue(_)
            | Value::UnregisteredValueListOp(_)
            | Value::UnregisteredDictionary(_)
    )
}

/// Whether `test` holds for the value or one inside it.
pub fn any(value: &Value, test: &impl Fn(&Value) -> bool) -> bool {
    let inside = match value {
        Value::Dictionary(entries) | Value::UnregisteredDictionary(entries) => entries.values().any(|v| any(v, test)),
        Value::TimeSamples(samples) => samples.iter().any(|(_, v)| any(v, test)),
        Value::ValueVec(values) => values.iter().any(|v| any(v, test)),
        _ => false,
    };
    inside || test(value)
}
