//! Finds the primvars and subsets that a recipe names in a garment.

use super::UsedGroup;
use crate::sim::SimOptions;
use tailor_mesh::error::Error;
use tailor_mesh::garment::{Mesh, Primvar};
use tailor_mesh::options::primvar;

/// Checks that a garment has all primvars and subsets that groups of options name, and that their lengths fit. Names that are not
/// subsets are those of derived sets.
///
/// # Errors
/// A primvar or subset that is missing or has another type; a length that is too large.
pub fn bind(groups: &[UsedGroup<'_>], garment: &Mesh) -> Result<(), Error> {
    groups.iter().try_for_each(|(prefix, options)| options.bind(prefix, garment))
}

/// Finds the UV set; `None` if the name is empty.
///
/// # Errors
/// A primvar that is missing or has another type.
pub fn bind_uv_set<'a>(options: &SimOptions, garment: &'a Mesh) -> Result<Option<&'a Primvar>, Error> {
    primvar(garment, "sim.uvSet", &options.uv_set, "face-varying float2 primvar", |p| p.is_uv_set())
}
