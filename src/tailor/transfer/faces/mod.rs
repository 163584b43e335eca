//! Attributes of faces, by the areas that faces of the two meshes have in common: the mean of numbers, the mode of
//! other values, and the majority of sets.

mod sets;
mod teeth;
mod uniform;

pub(super) use sets::{FaceSets, carry_sets};
pub(super) use uniform::carry_primvar;
