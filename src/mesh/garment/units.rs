//! Units of length.

use serde::de::{Deserializer, Error, Unexpected, Visitor};
use std::fmt;

/// Units that a length may be given in, with their size. \[m\]
const NAMED: [(&str, f64); 6] =
    [("mm", 1e-3), ("cm", 1e-2), ("in", 0.0254), ("inch", 0.0254), ("ft", 0.3048), ("m", 1.0)];
/// The same, for messages.
pub const UNITS: &str = "mm, cm, m, in, inch or ft";

/// The metres of a text such as `8mm` or `0.8 cm`; none for other texts.
pub fn meters_of(text: &str) -> Option<f64> {
    let (number, meters) = NAMED.iter().find_map(|(unit, meters)| Some((text.trim().strip_suffix(unit)?, meters)))?;
    let number: f64 = number.trim_end().parse().ok()?;
    number.is_finite().then_some(number * meters)
}

/// A length in words, in the unit that suits it.
pub fn in_words(meters: f64) -> String {
    match meters.abs() {
        size if size >= 1.0 => format!("{meters:.2} m"),
        size if size >= 0.01 => format!("{:.2} cm", 100.0 * meters),
        _ => format!("{:.2} mm", 1000.0 * meters),
    }
}

/// Reads an option that is a length in mesh units. A text with a unit is understood and gives no number: whoever knows the
/// mesh has to replace it before.
pub fn deserialize_length<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f32, D::Error> {
    deserializer.deserialize_any(Length)
}

struct Length;

impl Visitor<'_> for Length {
    type Value = f32;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number, or a length with its unit such as \"8mm\"")
    }

    fn visit_i64<E: Error>(self, v: i64) -> Result<f32, E> {
        Ok(v as f32)
    }

    fn visit_u64<E: Error>(self, v: u64) -> Result<f32, E> {
        Ok(v as f32)
    }

    fn visit_f64<E: Error>(self, v: f64) -> Result<f32, E> {
        Ok(v as f32)
    }

    fn visit_str<E: Error>(self, v: &str) -> Result<f32, E> {
        if meters_of(v).is_some() { Ok(f32::NAN) } else { Err(E::invalid_type(Unexpected::Str(v), &self)) }
    }
}

/// The size of a mesh's unit of length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// `metersPerUnit` of the stage.
    pub meters_per_unit: f64,
    /// Stage units in one unit of the mesh's own space: the scale of its transform, the geometric mean of the axes.
    pub scale: f64,
}

impl Units {
    /// Metres in one unit of the mesh.
    pub fn meters(&self) -> f64 {
        self.meters_per_unit * self.scale
    }
}

impl Default for Units {
    /// Centimetres, USD's fallback.
    fn default() -> Self {
        Self { meters_per_unit: 0.01, scale: 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_units() {
        let near = |text: &str, meters: f64| (meters_of(text).unwrap_or(f64::NAN) - meters).abs() < 1e-12;
        assert!(
            near("8mm", 0.008)
                && near(" 0.8 cm", 0.008)
                && near("1in", 0.0254)
                && near("4 inch", 0.1016)
                && near("-2m", -2.0)
        );
        for text in ["8", "mm", "8 m m", "8km", "infm", "nan mm", ""] {
            assert_eq!(meters_of(text), None, "{text}");
        }
        assert_eq!(in_words(0.0178), "1.78 cm");
        assert_eq!(in_words(0.0051), "5.10 mm");
    }
}
