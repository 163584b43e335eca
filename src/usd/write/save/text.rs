//! Layers as text.
//!
//! The USD library writes a large float with all of its digits. They are replaced by the shortest number with an exponent that is read
//! as the same value, as OpenUSD writes it. Dictionaries are indented as OpenUSD does.

use super::indent::Indented;
use crate::write::crates::any;
use bytemuck::cast_slice;
use openusd::sdf::{Data, FormatError, Value};
use openusd::usda::TextWriter;
use std::cell::RefCell;
use std::collections::HashSet;
use std::io::{self, Write};
use std::slice::from_ref;

/// Digits of the smallest float that is written without a decimal point, which is 1e16.
const DIGITS: usize = 17;
/// Digits of the largest integer.
const MOST_DIGITS: usize = 20;

/// Writes a layer as text.
///
/// # Errors
/// A value that text cannot hold, variants within variants, a failure of `out`.
pub fn write_text<W: Write>(data: &Data, out: &mut W) -> Result<(), FormatError> {
    // The USD library would leave them out.
    if data.iter().any(|(path, _)| path.as_str().matches('{').count() > 1) {
        return Err(io::Error::other("it has variants within variants, which .usdc can hold").into());
    }
    let out = &mut Indented::new(out);
    // Nearly no layer has such floats, and looking at each letter takes as long as writing.
    let mut values = data.iter().flat_map(|(_, spec)| spec.fields.iter().map(|(_, value)| value));
    if !values.any(|value| any(value, &may_be_long)) {
        return TextWriter::write(data, out);
    }
    let mut out = Shortened::new(out, integers(data));
    TextWriter::write(data, &mut out)?;
    Ok(out.finish()?)
}

/// A layer as text.
///
/// # Errors
/// A value that text cannot hold.
pub fn text_of(data: &Data) -> Result<String, FormatError> {
    let mut text = Vec::new();
    write_text(data, &mut text)?;
    String::from_utf8(text).map_err(|e| io::Error::other(e).into())
}

/// Whether a value, without those inside it, may be written with more digits than are needed.
fn may_be_long(value: &Value) -> bool {
    let f32s = |numbers: &[f32]| numbers.iter().any(|number| is_long(f64::from(*number)));
    let f64s = |numbers: &[f64]| numbers.iter().any(|number| is_long(*number));
    macro_rules! holds {
        ($($test:ident: $($one:ident $all:ident),*;)*) => {
            match value {
                Value::Float(number) => f32s(&[*number]),
                Value::FloatVec(numbers) => f32s(numbers),
                Value::Double(number) => is_long(*number),
                Value::DoubleVec(numbers) => f64s(numbers),
                Value::TimeCode(time) => is_long(time.0),
                Value::TimeCodeVec(times) => times.iter().any(|time| is_long(time.0)),
                Value::TimeSamples(samples) => samples.iter().any(|(time, _)| is_long(*time)),
                Value::LayerOffsetVec(all) => all.iter().any(|of| is_long(of.offset) || is_long(of.scale)),
                $($(Value::$one(one) => $test(cast_slice(from_ref(one))), Value::$all(all) => $test(cast_slice(all)),)*)*
                // They have offsets of times, or are text already.
                Value::ReferenceListOp(_) | Value::PayloadListOp(_) | Value::Payload(_) => true,
                Value::UnregisteredValue(_) | Value::UnregisteredValueListOp(_) => true,
                _ => false,
            }
        };
    }
    holds! {
        f32s: Vec2f Vec2fVec, Vec3f Vec3fVec, Vec4f Vec4fVec, Quatf QuatfVec;
        f64s: Vec2d Vec2dVec, Vec3d Vec3dVec, Vec4d Vec4dVec, Quatd QuatdVec, Matrix2d Matrix2dVec, Matrix3d Matrix3dVec,
            Matrix4d Matrix4dVec;
    }
}

fn is_long(number: f64) -> bool {
    number.is_finite() && number.abs() >= 1e16
}

/// The large integers of a layer, without their sign. They stay as they are.
fn integers(data: &Data) -> HashSet<String> {
    let found = RefCell::new(HashSet::new());
    let add = |number: u64| {
        if number >= 10_u64.pow(DIGITS as u32 - 1) {
            found.borrow_mut().insert(number.to_string());
        }
    };
    let note = |value: &Value| {
        match value {
            Value::Int64(number) => add(number.unsigned_abs()),
            Value::Uint64(number) => add(*number),
            Value::Int64Vec(numbers) => numbers.iter().for_each(|number| add(number.unsigned_abs())),
            Value::Uint64Vec(numbers) => numbers.iter().for_each(|number| add(*number)),
            _ => {}
        }
        false
    };
    for (_, value) in data.iter().flat_map(|(_, spec)| spec.fields.iter()) {
        any(value, &note);
    }
    found.into_inner()
}

/// Where a text is.
#[derive(Clone, Copy, PartialEq)]
enum Within {
    /// Outside of names and texts.
    Code,
    /// In a text; after a backslash or not.
    Text {
        is_escaped: bool,
    },
    /// In a path.
    Path,
    /// After so many signs that begin an asset path.
    AssetBegin(usize),
    Asset,
    /// In an asset path that holds `@`, after so many of those.
    LongAsset(usize),
}

impl Within {
    fn after(self, byte: u8) -> Self {
        match (self, byte) {
            (Self::Code | Self::AssetBegin(2), b'"') => Self::Text { is_escaped: false },
            (Self::Code | Self::AssetBegin(2), b'<') => Self::Path,
            (Self::Code, b'@') => Self::AssetBegin(1),
            (Self::Code | Self::AssetBegin(2), _) if byte != b'@' => Self::Code,
            (Self::Text { is_escaped: false }, b'"') | (Self::Path, b'>') | (Self::Asset, b'@') => Self::Code,
            (Self::Text { is_escaped }, _) => Self::Text { is_escaped: !is_escaped && byte == b'\\' },
            (Self::AssetBegin(1), b'@') => Self::AssetBegin(2),
            (Self::AssetBegin(2), _) => Self::LongAsset(0),
            (Self::AssetBegin(_), _) => Self::Asset,
            (Self::LongAsset(2), b'@') => Self::Code,
            (Self::LongAsset(count), b'@') => Self::LongAsset(count + 1),
            (Self::LongAsset(_), _) => Self::LongAsset(0),
            (other, _) => other,
        }
    }
}

/// Writes large floats in short, as the text comes.
struct Shortened<'a, W: Write> {
    out: &'a mut W,
    integers: HashSet<String>,
    within: Within,
    /// Whether a number may begin here.
    is_begin: bool,
    /// The digits of a number that has not ended.
    digits: String,
}

impl<'a, W: Write> Shortened<'a, W> {
    fn new(out: &'a mut W, integers: HashSet<String>) -> Self {
        Self { out, integers, within: Within::Code, is_begin: true, digits: String::new() }
    }

    /// Ends the number before `next`.
    fn end_number(&mut self, next: u8, to: &mut Vec<u8>) {
        let digits = std::mem::take(&mut self.digits);
        let is_float = digits.len() >= DIGITS
            && !(digits.len() <= MOST_DIGITS && self.integers.contains(&digits))
            && (next.is_ascii_whitespace() || b",)]}:;".contains(&next));
        match digits.parse::<f64>() {
            Ok(float) if is_float => to.extend(format!("{float:e}").replace('e', "e+").bytes()),
            _ => to.extend(digits.bytes()),
        }
    }

    fn finish(mut self) -> io::Result<()> {
        let mut rest = Vec::new();
        self.end_number(b'\n', &mut rest);
        self.out.write_all(&rest)
    }
}

impl<W: Write> Write for Shortened<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut to = Vec::with_capacity(bytes.len() + self.digits.len());
        for &byte in bytes {
            let is_code = self.within == Within::Code;
            if is_code && byte.is_ascii_digit() && (self.is_begin || !self.digits.is_empty()) {
                self.digits.push(char::from(byte));
                self.is_begin = false;
                continue;
            }
            if !self.digits.is_empty() {
                self.end_number(byte, &mut to);
            }
            self.is_begin = byte.is_ascii_whitespace() || b"([{,-".contains(&byte);
            self.within = self.within.after(byte);
            to.push(byte);
        }
        self.out.write_all(&to)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shortened(parts: &[&str], integers: &[&str]) -> String {
        let mut text = Vec::new();
        let mut out = Shortened::new(&mut text, integers.iter().map(|&n| n.to_owned()).collect());
        parts.iter().for_each(|part| out.write_all(part.as_bytes()).expect("memory"));
        out.finish().expect("memory");
        String::from_utf8(text).expect("text")
    }

    #[test]
    fn layers_with_large_floats_are_known() {
        let inside = |value: Value| Value::Dictionary([("a".to_owned(), value)].into());
        for (value, expected) in [
            (Value::FloatVec(vec![1.0, -1e16]), true),
            (Value::Vec3fVec(vec![[0.0, 1.0, 1e20].into()]), true),
            (Value::Vec2d([1e15, 1e17].into()), true),
            (Value::TimeSamples(vec![(1e17, Value::Bool(true))]), true),
            (Value::TimeSamples(vec![(1.0, inside(Value::Double(1e300)))]), true),
            (Value::DoubleVec(vec![9e15, f64::NAN, f64::INFINITY]), false),
            (Value::Int64(i64::MAX), false),
            (Value::Vec3fVec(vec![[0.0, 1.0, 1e15].into()]), false),
        ] {
            assert_eq!(any(&value, &may_be_long), expected, "{value:?}");
        }
    }

    #[test]
    fn large_floats_have_an_exponent() {
        let short = |text: &str| shortened(&[text], &["12345678901234567"]);
        assert_eq!(short("double a = 100000000000000000000\n"), "double a = 1e+20\n");
        assert_eq!(short("(-12500000000000000, 3.0, 10000000000000000)"), "(-1.25e+16, 3.0, 1e+16)");
        assert_eq!(short("{ 100000000000000000000: 1.0 }"), "{ 1e+20: 1.0 }");
        assert_eq!(short(&f64::MAX.to_string()), "1.7976931348623157e+308");
        for kept in [
            "int64 a = 12345678901234567",
            "[1, 9999999999999999, 0.00000000000000000001]",
            "string a = \"\\\" 100000000000000000000 \"",
            "rel a = </b{c=100000000000000000000}d>",
            "asset[] a = [@@, @/b 100000000000000000000 c@, @@@ 100000000000000000000 @b @@@]",
            "float b100000000000000000000 = 1.0",
            "float primvars:100000000000000000000 = 1.0",
        ] {
            assert_eq!(short(kept), kept);
        }
        assert_eq!(short("[@@, 100000000000000000000]"), "[@@, 1e+20]");
        assert_eq!(shortened(&["a = 10000000000", "0000000000", ", b"], &[]), "a = 1e+20, b");
    }
}
