//! The door between what a file said and what geometry code may assume.

use super::{Garment, GarmentInput};
use crate::error::Warnings;
use std::fmt;

/// One fault of the input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The attribute or subset that is at fault.
    pub attribute: String,
    /// What is wrong, with the element in the user's own numbers.
    pub fault: String,
    /// What the user can do.
    pub remedy: String,
}

/// All faults that were found in one mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GarmentError {
    /// Path of the mesh.
    pub prim: String,
    /// The faults; at least one.
    pub problems: Vec<Problem>,
}

impl fmt::Display for GarmentError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, p) in self.problems.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            write!(f, "{}.{}: {}\n  hint: {}", self.prim, p.attribute, p.fault, p.remedy)?;
        }
        Ok(())
    }
}

impl std::error::Error for GarmentError {}

/// Checks `input` and gives it the types that geometry code works with.
///
/// # Errors
/// Every fault of topology, indices, lengths and values that was found.
pub fn check_garment(_input: GarmentInput, _warnings: &mut Warnings) -> Result<Garment, GarmentError> {
    todo!()
}
