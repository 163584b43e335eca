//! Checks that options of all kinds share. Every fault names the option and the remedy.

use crate::error::{Error, ErrorCode};
use crate::garment::{Garment, Interpolation, Primvar, Values};

/// The largest length of an operator or a cloth. \[diagonals of the garment's box\]
const LARGEST: f32 = 0.5;
/// The longest target length. \[sizes of the garment\]
const LONGEST: f32 = 1000.0;

/// Checks that a value is a length, or 0.
///
/// # Errors
/// A negative or infinite value.
pub fn length(key: &str, length: f32) -> Result<(), Error> {
    if length.is_finite() && length >= 0.0 {
        return Ok(());
    }
    let remedy = "give a positive number of mesh units, a length such as 8mm, or 0 for automatic";
    Err(Error::recipe(key, format!("{length} is no length")).remedy(remedy))
}

/// Checks that a value is a distance of either sign.
///
/// # Errors
/// An infinite value.
pub fn finite(key: &str, value: f32) -> Result<(), Error> {
    if value.is_finite() {
        return Ok(());
    }
    Err(Error::recipe(key, format!("{value} is no distance")).remedy("give a number of mesh units"))
}

/// Checks that a length or height fits a garment: operators look for other cloth as far as it reaches.
///
/// # Errors
/// A value larger than half of the garment, with its range.
pub fn within_size(key: &str, value: f32, garment: &Garment) -> Result<(), Error> {
    within(key, value, LARGEST * garment.size(), "mesh units", &garment.prim)
}

/// Checks that a target length fits a garment. Longer ones make no coarser mesh, and numbers end somewhere.
///
/// # Errors
/// A value larger than [`LONGEST`] garments, with its range.
pub fn target_fits(key: &str, value: f32, garment: &Garment) -> Result<(), Error> {
    let most = LONGEST * garment.size();
    if value <= most {
        return Ok(());
    }
    let fault = format!("{value} is more than {LONGEST} times the size of {}", garment.prim);
    Err(Error::recipe(key, fault).remedy(format!("give at most {most} mesh units; 0 is automatic")))
}

/// Checks that a length in metres fits a garment.
///
/// # Errors
/// As [`within_size`].
pub fn within_size_in_meters(key: &str, value: f32, garment: &Garment) -> Result<(), Error> {
    let most = f64::from(LARGEST * garment.size()) * garment.units.meters();
    within(key, value, most as f32, "metres", &garment.prim)
}

fn within(key: &str, value: f32, most: f32, unit: &str, prim: &str) -> Result<(), Error> {
    if value.abs() <= most {
        return Ok(());
    }
    let fault = format!("{value} is more than half of the size of {prim}");
    Err(Error::recipe(key, fault).remedy(format!("give at most {most} {unit}, above or below 0")))
}

/// Checks that any subset of a kind is named.
///
/// # Errors
/// An empty list.
pub fn named(key: &str, names: &[String], kind: &str) -> Result<(), Error> {
    if !names.is_empty() {
        return Ok(());
    }
    let fault = Error::recipe(key, format!("it names no {kind} subset")).code(ErrorCode::UnknownSubset);
    Err(fault.remedy(format!("name one of the {kind} subsets of the mesh")))
}

/// Checks that all of `names` are subsets of the garment, with elements of one kind.
///
/// # Errors
/// A name that is missing, or has other elements.
pub fn subsets_are(garment: &Garment, key: &str, names: &[String], kind: &str) -> Result<(), Error> {
    let fits = |name: &String| garment.subset(name).is_some_and(|s| s.elements.kind() == kind);
    let Some(name) = names.iter().find(|name| !fits(name)) else { return Ok(()) };
    let known = garment.subsets.iter().filter(|s| s.elements.kind() == kind);
    let known: Vec<&str> = known.map(|s| s.name.as_str()).collect();
    let (fault, remedy) = match garment.subset(name) {
        Some(other) => {
            let other = other.elements.kind();
            let place =
                of_kind(other).map(|option| format!("; a set of {other}s goes to {option}")).unwrap_or_default();
            (format!("\"{name}\" is a subset of {other}s of {}, not of {kind}s", garment.prim), place)
        }
        None => (format!("\"{name}\" is no {kind} subset of {}", garment.prim), String::new()),
    };
    let known_sets = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
    let remedy = format!("{}its {kind} subsets are: {known_sets}{remedy}", did_you_mean(name, &known));
    Err(Error::recipe(key, fault).code(ErrorCode::UnknownSubset).remedy(remedy))
}

/// The option that takes subsets of a kind.
fn of_kind(kind: &str) -> Option<&'static str> {
    match kind {
        "face" => Some("thickness.<name>.faces"),
        "edge" => Some("seam.<name>.edges"),
        "point" => Some("cloth.pins"),
        _ => None,
    }
}

/// The known word that is nearest to `word`; none where more than a third of its letters differ.
pub fn nearest<'a>(word: &str, known: &'a [impl AsRef<str>]) -> Option<&'a str> {
    let letters = word.chars().count();
    let distance = |name: &str| strsim::damerau_levenshtein(&word.to_lowercase(), &name.to_lowercase());
    let near = known.iter().map(|name| (distance(name.as_ref()), name.as_ref()));
    let near = near.filter(|(distance, _)| *distance <= (letters / 3).max(1) && *distance < letters);
    near.min().map(|(_, name)| name)
}

/// The start of a remedy that names the nearest known word, if there is one.
pub fn did_you_mean(word: &str, known: &[impl AsRef<str>]) -> String {
    nearest(word, known).map(|name| format!("did you mean {name}? ")).unwrap_or_default()
}

/// The primvar that `key` names, which has to be a `kind`; none where the name is empty.
///
/// # Errors
/// A primvar that is missing or of another kind.
pub fn primvar<'a>(
    garment: &'a Garment,
    key: &str,
    name: &str,
    kind: &str,
    fits: impl Fn(&&Primvar) -> bool,
) -> Result<Option<&'a Primvar>, Error> {
    let found = garment.primvar(name).filter(&fits);
    if found.is_some() || name.is_empty() {
        return Ok(found);
    }
    let names: Vec<&str> = garment.primvars.iter().filter(&fits).map(|p| p.name.as_str()).collect();
    let remedy = if names.is_empty() {
        "the mesh has none".to_owned()
    } else {
        format!("{}the mesh has: {}", did_you_mean(name, &names), names.join(", "))
    };
    let fault = format!("\"{name}\" is no {kind} of {}", garment.prim);
    Err(Error::recipe(key, fault).code(ErrorCode::UnknownPrimvar).remedy(remedy))
}

/// The painted weights that `key` names; none where the name is empty.
///
/// # Errors
/// A primvar that is missing or of another kind.
pub fn weights<'a>(garment: &'a Garment, key: &str, name: &str) -> Result<Option<&'a Primvar>, Error> {
    primvar(garment, key, name, "float primvar per vertex", |p| {
        matches!(p.interpolation, Interpolation::Vertex | Interpolation::Varying)
            && p.width() == 1
            && matches!(p.values, Values::F32(_))
    })
}
