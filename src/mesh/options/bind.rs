//! Checks of options against a garment. Every fault names the option and the remedy.

use crate::codes;
use crate::error::Error;
use crate::garment::{Interpolation, LeftOut, Mesh, Primvar, Subset, Values};

/// Largest length or height of an operator, which looks for other cloth as far as it reaches, and of a cloth.
/// \[sizes of the garment\]
pub const LARGEST: f32 = 0.5;

/// Checks that a length or height is at most `largest` sizes of a garment.
///
/// # Errors
/// A larger value, with its range.
pub fn fits_garment(key: &str, value: f32, largest: f32, garment: &Mesh) -> Result<(), Error> {
    within(key, value, [largest, largest * garment.size()], "mesh units", &garment.prim)
}

/// Checks that a length in metres fits a garment.
///
/// # Errors
/// A value larger than half of the garment, with its range.
pub fn within_size_in_meters(key: &str, value: f32, garment: &Mesh) -> Result<(), Error> {
    let most = f64::from(LARGEST * garment.size()) * garment.units.meters();
    within(key, value, [LARGEST, most as f32], "metres", &garment.prim)
}

fn within(key: &str, value: f32, [sizes, most]: [f32; 2], unit: &str, prim: &str) -> Result<(), Error> {
    if value.abs() <= most {
        return Ok(());
    }
    let fault = format!("{value} is more than {sizes} times the size of {prim}");
    Err(Error::recipe(key, fault).remedy(format!("keep it within {most} {unit}")))
}

/// Checks that `name` is a subset of the garment, with elements of the kinds `of`.
///
/// # Errors
/// A name that is missing, or has other elements.
pub fn subset_of(garment: &Mesh, key: &str, name: &str, of: &[&str]) -> Result<(), Error> {
    let fits = |set: &&Subset| of.contains(&set.elements.kind());
    if garment.subset(name).is_some_and(|set| fits(&set)) {
        return Ok(());
    }
    let kinds = of.join(" or ");
    let known: Vec<&str> = garment.subsets.iter().filter(fits).map(|set| set.name.as_str()).collect();
    let (fault, elsewhere) = match garment.subset(name).map(|other| other.elements.kind()) {
        Some(other) => {
            let place = option_of(other).map(|option| format!("; a set of {other}s goes to {option}"));
            let fault = format!("\"{name}\" is a subset of {other}s of {}, not of {}s", garment.prim, of.join("s or "));
            (fault, place.unwrap_or_default())
        }
        None => (format!("\"{name}\" is not one of the {kinds} subsets of {}", garment.prim), String::new()),
    };
    let known_sets = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
    let remedy = format!("{}its {kinds} subsets are: {known_sets}{elsewhere}", did_you_mean(name, &known));
    Err(Error::recipe(key, fault).code(codes::UNKNOWN_SUBSET).remedy(remedy))
}

/// The option that takes subsets of a kind.
fn option_of(kind: &str) -> Option<&'static str> {
    match kind {
        "face" => Some("fold.<name>.faces"),
        "edge" => Some("seam.<name>.edges"),
        "point" => Some("cloth.pins"),
        _ => None,
    }
}

/// The known word that is nearest to `word`; none where more than a third of its letters differ, unless it begins one.
pub fn nearest<'a>(word: &str, known: &'a [impl AsRef<str>]) -> Option<&'a str> {
    let letters = word.chars().count();
    let distance = |name: &str| strsim::damerau_levenshtein(&word.to_lowercase(), &name.to_lowercase());
    let near = known.iter().map(|name| (distance(name.as_ref()), name.as_ref()));
    let near = near.filter(|(distance, _)| *distance <= (letters / 3).max(1) && *distance < letters);
    // A name that is written in part is not a slip of a letter.
    let is_begun = |name: &&str| letters > 3 && name.to_lowercase().starts_with(&word.to_lowercase());
    near.min().map(|(_, name)| name).or_else(|| known.iter().map(AsRef::as_ref).filter(is_begun).min())
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
    garment: &'a Mesh,
    key: &str,
    name: &str,
    kind: &str,
    fits: impl Fn(&&Primvar) -> bool,
) -> Result<Option<&'a Primvar>, Error> {
    let found = garment.primvar(name).filter(&fits);
    if found.is_some() || name.is_empty() {
        return Ok(found);
    }
    if let Some(LeftOut { fault, .. }) = garment.left_out(name) {
        let text = format!("\"{name}\" cannot be used: {} {}", fault.place, fault.text);
        return Err(Error::recipe(key, text).code(fault.code).remedy(&fault.remedy));
    }
    let names: Vec<&str> = garment.primvars.iter().filter(&fits).map(|p| p.name.as_str()).collect();
    let remedy = if names.is_empty() {
        "the mesh has none".to_owned()
    } else {
        format!("{}the mesh has: {}", did_you_mean(name, &names), names.join(", "))
    };
    let fault = format!("\"{name}\" is not a {kind} of {}", garment.prim);
    Err(Error::recipe(key, fault).code(codes::UNKNOWN_PRIMVAR).remedy(remedy))
}

/// The painted weights that `key` names; none where the name is empty.
///
/// # Errors
/// A primvar that is missing or of another kind.
pub fn float_primvar<'a>(garment: &'a Mesh, key: &str, name: &str) -> Result<Option<&'a Primvar>, Error> {
    primvar(garment, key, name, "float primvar per vertex", |p| {
        matches!(p.interpolation, Interpolation::Vertex | Interpolation::Varying)
            && p.width() == 1
            && matches!(p.values, Values::F32(_))
    })
}
