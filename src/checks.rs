//! What options of all kinds are held to, by themselves and on a garment. Every fault names the option and the remedy.

use crate::error::Error;
use crate::garment::{Garment, Interpolation, Primvar, Values};

/// A value that makes no sense.
///
/// # Errors
/// Always.
pub fn fault(key: &str, fault: &str, hint: &str) -> Result<(), Error> {
    Err(Error::Recipe(format!("{key}: {fault}\n  hint: {hint}")))
}

/// Whether a value is a length, or 0.
///
/// # Errors
/// Where it is not.
pub fn length(key: &str, length: f32) -> Result<(), Error> {
    if length.is_finite() && length >= 0.0 {
        return Ok(());
    }
    fault(key, &format!("{length} is no length"), "give a positive number of stage units, or 0 for automatic")
}

/// Whether a value is a distance of either sign.
///
/// # Errors
/// Where it is not.
pub fn finite(key: &str, value: f32) -> Result<(), Error> {
    if value.is_finite() {
        return Ok(());
    }
    fault(key, &format!("{value} is no distance"), "give a number of stage units")
}

/// Whether any subset of a kind is named.
///
/// # Errors
/// Where none is.
pub fn named(key: &str, names: &[String], kind: &str) -> Result<(), Error> {
    if names.is_empty() {
        return fault(
            key,
            &format!("it names no {kind} subset"),
            &format!("name one of the {kind} subsets of the mesh"),
        );
    }
    Ok(())
}

/// Whether all of `names` are subsets of the garment whose elements are of a kind.
///
/// # Errors
/// One that is missing or of another kind.
pub fn subsets_are(garment: &Garment, key: &str, names: &[String], kind: &str) -> Result<(), Error> {
    for name in names {
        if garment.subset(name).is_none_or(|s| s.elements.kind() != kind) {
            let fitting = garment.subsets.iter().filter(|s| s.elements.kind() == kind);
            let fitting: Vec<&str> = fitting.map(|s| s.name.as_str()).collect();
            return Err(Error::Recipe(format!(
                "{}: {key} names \"{name}\", which is no {kind} subset of the mesh\n  hint: its {kind} subsets are: {}",
                garment.prim,
                fitting.join(", ")
            )));
        }
    }
    Ok(())
}

/// The primvar that `key` names, which has to be a `kind`; none where the name is empty.
///
/// # Errors
/// One that is missing or of another kind.
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
    let hint =
        if names.is_empty() { "the mesh has none".to_owned() } else { format!("the mesh has: {}", names.join(", ")) };
    Err(Error::Recipe(format!(
        "{}: {key} names \"{name}\", which is no {kind} of the mesh\n  hint: {hint}",
        garment.prim
    )))
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
