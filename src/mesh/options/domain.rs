//! The values that an option takes, and their checks.

use super::Given;
use super::bind::{LARGEST, fits_garment, subset_of};
use crate::codes;
use crate::error::Error;
use crate::garment::Mesh;
use serde::Serialize;

/// The values that an option takes. `usual` is the range of a slider; values beyond it may be given.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "camelCase", rename_all_fields = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Domain {
    /// True or false.
    Flag,
    /// A number without a unit of length.
    Number {
        /// The least value.
        least: f32,
        /// The largest value; none without a limit.
        most: Option<f32>,
        /// True if 0 is allowed beside the range.
        or_zero: bool,
        /// The usual range.
        usual: [f32; 2],
        /// A step that can be seen.
        step: f32,
    },
    /// A whole number from 0.
    Whole {
        /// The largest value.
        most: u32,
        /// End of the usual range.
        usual: u32,
    },
    /// A length, of either sign if the usual range begins below 0.
    Length {
        /// The usual range. \[mean edge lengths of the garment\]
        usual: [f32; 2],
        /// The length that 0 stands for; 0 if it is not a length. \[mean edge lengths of the garment\]
        automatic: f32,
        /// The most that it is, however large the faces are. \[m\]
        automatic_most: Option<f32>,
        /// The largest length. \[sizes of the garment\]
        largest: f32,
    },
    /// One of several words.
    Choice {
        /// The words.
        words: &'static [&'static str],
    },
    /// Some of several words.
    Words {
        /// The words.
        words: &'static [&'static str],
    },
    /// One of several fabrics, or a fabric of the recipe.
    Fabric {
        /// The fabrics.
        words: &'static [&'static str],
    },
    /// The path of a prim, or empty.
    PrimPath,
    /// The path of a file, or empty.
    File,
    /// Prims, by path or by name beside the mesh.
    Prims,
    /// A UV set, or empty.
    UvSet,
    /// A painted float primvar, a set, or empty.
    Weights,
    /// Subsets, or expressions of derived sets.
    Sets {
        /// The kinds of their elements: `edge`, `point`, `face`.
        of: &'static [&'static str],
        /// True if one is needed at least.
        required: bool,
    },
    /// Operators of the recipe.
    Operators,
}

/// The sizes of a garment that automatic lengths follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The mean length of its edges. \[mesh units\]
    pub mean_edge: f32,
    /// Metres in a mesh unit.
    pub meters: f64,
}

impl Domain {
    /// A length up to [`LARGEST`]; `usual` and `automatic` are those of [`Domain::Length`].
    pub const fn length(usual: [f32; 2], automatic: f32) -> Self {
        Self::Length { usual, automatic, automatic_most: None, largest: LARGEST }
    }

    /// True for lengths in mesh units.
    pub const fn is_length(&self) -> bool {
        matches!(self, Self::Length { .. })
    }

    /// True for lengths of either sign.
    pub fn is_signed_length(&self) -> bool {
        matches!(self, Self::Length { usual, .. } if usual[0] < 0.0)
    }

    /// The length that 0 stands for, if it does. \[mesh units\]
    pub fn automatic_length(&self, scale: Scale) -> Option<f32> {
        let Self::Length { automatic, automatic_most, .. } = *self else { return None };
        let most = automatic_most.map_or(f32::INFINITY, |most| (f64::from(most) / scale.meters) as f32);
        (automatic > 0.0).then(|| (automatic * scale.mean_edge).min(most))
    }

    /// Checks a value without a garment.
    ///
    /// # Errors
    /// A value that the option does not take, with the values that it takes.
    pub(super) fn check(&self, key: &str, given: Given) -> Result<(), Error> {
        match (self, given) {
            (Self::Number { least, most, or_zero, .. }, Given::Number(value)) => {
                let is_within = value.is_finite() && value >= *least && most.is_none_or(|most| value <= most);
                let fits = is_within || *or_zero && value == 0.0;
                if fits { Ok(()) } else { Err(out_of_range(key, &value.to_string(), &self.range())) }
            }
            (Self::Whole { most, .. }, Given::Whole(value)) if value > *most => {
                Err(out_of_range(key, &value.to_string(), &self.range()))
            }
            (Self::Length { usual, .. }, Given::Number(value)) => length(key, value, usual[0] < 0.0),
            (Self::Choice { words }, Given::Text(word)) => one_of(key, word, words),
            (Self::Words { words }, Given::Names(given)) => given.iter().try_for_each(|word| one_of(key, word, words)),
            (Self::PrimPath, Given::Text(path)) => prim_path(key, path),
            (Self::Prims, Given::Names([])) => Err(Error::recipe(key, "it names no prim")
                .code(codes::WRONG_PRIM)
                .remedy("name a mesh, curves, points or a PointInstancer")),
            (Self::Prims, Given::Names(paths)) => paths.iter().try_for_each(|path| prim_or_name(key, path)),
            (Self::Sets { of, required: true }, Given::Names([])) => Err(no_set(key, of)),
            _ => Ok(()),
        }
    }

    /// Checks a length or names against a garment. Sets that are not its subsets are derived, and checked where they are.
    ///
    /// # Errors
    /// A length that is too large for it, and names that it lacks or has with another type.
    pub(super) fn bind(&self, key: &str, given: Given, garment: &Mesh) -> Result<(), Error> {
        match (self, given) {
            (Self::Length { largest, .. }, Given::Number(value)) => fits_garment(key, value, *largest, garment),
            (Self::Sets { of, .. }, Given::Names(names)) => {
                let mut subsets = names.iter().filter(|name| garment.subset(name).is_some());
                subsets.try_for_each(|name| subset_of(garment, key, name, of))
            }
            _ => Ok(()),
        }
    }

    /// The values in words, after "give".
    fn range(&self) -> String {
        match self {
            Self::Number { least, most, or_zero, .. } => {
                let most = most.map_or_else(|| "or more".to_owned(), |most| format!("to {most}"));
                let zero = if *or_zero && *least > 0.0 { ", or 0" } else { "" };
                format!("{least} {most}{zero}")
            }
            Self::Whole { most, .. } => format!("0 to {most}"),
            _ => String::new(),
        }
    }
}

fn out_of_range(key: &str, value: &str, range: &str) -> Error {
    Error::recipe(key, format!("{value} is out of range")).remedy(format!("give {range}"))
}

fn length(key: &str, value: f32, signed: bool) -> Result<(), Error> {
    if value.is_finite() && (signed || value >= 0.0) {
        return Ok(());
    }
    let remedy = if signed {
        "give a number of mesh units, or a length such as -1mm"
    } else {
        "give a positive number of mesh units, a length such as 8mm, or 0 for automatic"
    };
    Err(Error::recipe(key, format!("{value} is not a length")).remedy(remedy))
}

fn one_of(key: &str, word: &str, words: &[&str]) -> Result<(), Error> {
    if words.contains(&word) {
        return Ok(());
    }
    Err(Error::recipe(key, format!("\"{word}\" is not known")).remedy(format!("use one of: {}", words.join(", "))))
}

/// Whether names of prims follow one another, as in `Coat/buttons`.
fn are_names(path: &str) -> bool {
    let is_name = |part: &str| !part.is_empty() && part.chars().all(|letter| letter.is_alphanumeric() || letter == '_');
    path.split('/').all(is_name)
}

fn prim_or_name(key: &str, path: &str) -> Result<(), Error> {
    if are_names(path.strip_prefix('/').unwrap_or(path)) {
        return Ok(());
    }
    let fault = Error::recipe(key, format!("\"{path}\" is not the path or name of a prim")).code(codes::WRONG_PRIM);
    Err(fault.remedy("write it as /Coat/buttons, or as buttons where it is beside the mesh"))
}

fn prim_path(key: &str, path: &str) -> Result<(), Error> {
    if path.is_empty() || path.strip_prefix('/').is_some_and(are_names) {
        return Ok(());
    }
    let fault = Error::recipe(key, format!("\"{path}\" is not an absolute prim path")).code(codes::WRONG_PRIM);
    Err(fault.remedy("write it as /Body/hips, or leave it empty"))
}

fn no_set(key: &str, of: &[&str]) -> Error {
    let kinds = of.join(" or ");
    let fault = Error::recipe(key, format!("it names no {kinds} subset")).code(codes::UNKNOWN_SUBSET);
    fault.remedy(format!("name one of the {kinds} subsets of the mesh"))
}
