//! The door between what a file said and what geometry code may assume.
//!
//! Each file here turns one part of a [`GarmentInput`] into its checked form and adds what is wrong to [`Problems`].
//! A part that depends on a faulty one is left alone, so that one fault is named once; parts that do not are all
//! looked at. Time is linear in the size of the mesh and its attributes, but for the sort that finds duplicate faces.

mod creases;
mod faces;
mod mesh;
mod primvars;
mod problem;
mod subsets;
mod surface;

#[cfg(test)]
mod tests;

pub use problem::{GarmentError, Problem};

use super::{Garment, GarmentInput};
use crate::error::Warnings;
use crate::mesh::Topology;
use mesh::Mesh;
use problem::Problems;
use std::mem::take;

/// Checks `input` and gives it the types that geometry code works with.
///
/// What is odd but can be worked with (edges of more than two faces, bow-tie vertices, faces that disagree in winding,
/// unused points, duplicate and zero-area faces) is kept and added to `warnings`, also where other faults are errors.
///
/// # Errors
/// Every independent fault of topology, indices, lengths and values that was found, in a fixed order.
pub fn check_garment(mut input: GarmentInput, warnings: &mut Warnings) -> Result<Garment, GarmentError> {
    let mut problems = Problems::default();
    let found = &mut problems;
    let finite = faces::check_points(&input.points, found);
    let topology = faces::faces(&input, found).map(|faces| Topology::new(faces, input.points.len()));
    faces::check_scheme(&input, found);
    if let Some(topology) = &topology {
        surface::warn(topology, finite.then_some(&input.points), warnings);
    }

    let (primvars, subsets) = (take(&mut input.primvars), take(&mut input.subsets));
    let mesh = Mesh::new(&input, topology.as_ref());
    let holes = faces::holes(&input.hole_indices, &mesh, found);
    let creases = creases::creases(&input, &mesh, found);
    let corners = creases::corners(&input, &mesh, found);
    let primvars = primvars::primvars(primvars, &mesh, found);
    let subsets = subsets::subsets(subsets, &input.families, &mesh, found);

    match topology {
        Some(topology) if problems.is_empty() => Ok(Garment {
            prim: input.prim,
            points: input.points.into(),
            faces: topology.faces,
            orientation: input.orientation,
            rules: input.rules,
            holes,
            creases,
            corners,
            primvars: primvars.into(),
            subsets: subsets.into(),
            families: input.families,
        }),
        _ => Err(problems.into_error(input.prim)),
    }
}
