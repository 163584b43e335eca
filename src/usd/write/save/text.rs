//! Layers as text.
//!
//! The USD library writes a large float with all of its digits. They are replaced by the shortest number with an exponent that is read
//! as the same value, as OpenUSD writes it. Dictionaries are indented as OpenUSD does.

use super::indent::Indented;
use crate::codes;
use openusd::sdf::{AbstractData, Data, FormatError, Value};
use openusd::usda::TextWriter;
use std::io::{self, Write};
use tailor_mesh::error::Error;

/// Digits of the smallest float that is written without a decimal point, which is 1e16.
const DIGITS: usize = 17;

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
    // Nearly no layer has such floats.
    if !data.iter().any(|(_, spec)| spec.fields.iter().any(|(_, value)| is_long(value))) {
        return TextWriter::write(data, out);
    }
    let mut data = data.clone();
    for path in data.spec_paths() {
        for (_, value) in data.spec_mut(&path).into_iter().flat_map(|spec| &mut spec.fields) {
            shorten(value)?;
        }
    }
    TextWriter::write(&data, out)
}

/// A layer as text.
///
/// # Errors
/// A value that text cannot hold.
pub fn text_of(data: &Data) -> Result<Vec<u8>, Error> {
    let mut text = Vec::new();
    let fault = |e| Error::usd(format!("the layer cannot be written as text: {e}")).code(codes::WRITE_FAILED);
    write_text(data, &mut text).map_err(fault)?;
    Ok(text)
}

/// Whether a value of floats, or a sample of them, is written with more digits than are needed.
fn is_long(value: &Value) -> bool {
    let f32s = |numbers: &[f32]| numbers.iter().any(|number| number.is_finite() && number.abs() >= 1e16);
    let f64s = |numbers: &[f64]| numbers.iter().any(|number| number.is_finite() && number.abs() >= 1e16);
    macro_rules! holds {
        ($($test:ident: $($one:ident $all:ident),*;)*) => {
            match value {
                Value::TimeSamples(samples) => samples.iter().any(|(_, value)| is_long(value)),
                $($(Value::$one(one) => $test(bytemuck::cast_slice(std::slice::from_ref(one))),
                    Value::$all(all) => $test(bytemuck::cast_slice(all)),)*)*
                _ => false,
            }
        };
    }
    holds! {
        f32s: Float FloatVec, Vec2f Vec2fVec, Vec3f Vec3fVec, Vec4f Vec4fVec, Quatf QuatfVec;
        f64s: Double DoubleVec, Vec2d Vec2dVec, Vec3d Vec3dVec, Vec4d Vec4dVec, Quatd QuatdVec, Matrix2d Matrix2dVec,
            Matrix3d Matrix3dVec, Matrix4d Matrix4dVec;
    }
}

/// Puts the text of a value with long floats in its place, in which they are short. The library writes such a text as it is.
fn shorten(value: &mut Value) -> Result<(), FormatError> {
    if let Value::TimeSamples(samples) = value {
        return samples.iter_mut().try_for_each(|(_, value)| shorten(value));
    }
    if is_long(value) {
        let text = TextWriter::value_to_string(value)?;
        *value = Value::UnregisteredValue(text.split_inclusive(['(', '[', ',', ' ', ')', ']']).map(short).collect());
    }
    Ok(())
}

/// A number with the sign after it, or such a sign alone, with an exponent where it is long.
fn short(text: &str) -> String {
    let number = text.trim_end_matches(['(', '[', ',', ' ', ')', ']']);
    let digits = number.trim_start_matches('-');
    let is_long = digits.len() >= DIGITS && digits.bytes().all(|byte| byte.is_ascii_digit());
    match number.parse::<f64>() {
        Ok(float) if is_long => format!("{float:e}").replace('e', "e+") + &text[number.len()..],
        _ => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_with_large_floats_are_known() {
        for (value, expected) in [
            (Value::FloatVec(vec![1.0, -1e16]), true),
            (Value::Vec3fVec(vec![[0.0, 1.0, 1e20].into()]), true),
            (Value::Vec2d([1e15, 1e17].into()), true),
            (Value::TimeSamples(vec![(1.0, Value::Double(1e300))]), true),
            (Value::DoubleVec(vec![9e15, f64::NAN, f64::INFINITY]), false),
            (Value::Int64(i64::MAX), false),
            (Value::Vec3fVec(vec![[0.0, 1.0, 1e15].into()]), false),
        ] {
            assert_eq!(is_long(&value), expected, "{value:?}");
        }
    }

    #[test]
    fn large_floats_have_an_exponent() {
        let text = |mut value: Value| {
            shorten(&mut value).expect("a value of text");
            TextWriter::value_to_string(&value).expect("a value of text")
        };
        for (value, expected) in [
            (Value::Double(1e20), "1e+20"),
            (Value::Vec3d([-1.25e16, 3.0, 1e16].into()), "(-1.25e+16, 3.0, 1e+16)"),
            (Value::Double(f64::MAX), "1.7976931348623157e+308"),
            (Value::DoubleVec(vec![1.0, 9_999_999_999_999_998.0, 1e17]), "[1.0, 9999999999999998.0, 1e+17]"),
            (Value::Matrix2d([1e20, 0.0, 0.0, -1e20].into()), "((1e+20, 0.0), (0.0, -1e+20))"),
            (Value::Int64(12_345_678_901_234_567), "12345678901234567"),
            (Value::String("100000000000000000000".into()), "\"100000000000000000000\""),
        ] {
            assert_eq!(text(value), expected);
        }
    }
}
