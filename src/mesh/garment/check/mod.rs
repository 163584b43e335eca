//! The check of an input. After it, geometry code may assume clean indices, lengths and values.
//!
//! Each file here turns one part of a [`Garment`] into its checked form and adds its faults to [`Problems`]. Parts that
//! depend on a faulty one are skipped, so that a fault is listed once; all others are checked. Time is linear in the size
//! of the mesh and its attributes, except for the sort that finds duplicate faces.

mod creases;
mod faces;
mod mesh;
mod primvars;
mod problem;
mod repeats;
mod subsets;
mod surface;

#[cfg(test)]
mod tests;

pub use repeats::split_repeats;

use super::{Garment, LeftOut, Mesh};
use crate::connectivity::Topology;
use crate::error::{Error, Warnings};
use mesh::MeshCheck;
use problem::Problems;
use std::mem::take;

/// Checks `input` and converts it to the types of geometry code.
///
/// Non-manifold edges, bow-tie vertices, inconsistent winding, unused points, and duplicate and zero-area faces are kept and
/// are warnings. So are primvars with faults that no step needs: the checked mesh lacks them. So are families whose subsets
/// break their rule: the checked mesh has a weaker one.
///
/// # Errors
/// Every independent fault of topology, indices, lengths and values that was found, in a fixed order.
pub fn check_garment(mut input: Garment) -> Result<(Mesh, Warnings), Error> {
    let mut problems = Problems::default();
    let found = &mut problems;
    faces::check_points(&input.points, found);
    let topology = faces::faces(&input, found).map(|faces| Topology::new(faces, input.points.len()));
    faces::check_scheme(&input, found);
    let (primvars, subsets) = (take(&mut input.primvars), take(&mut input.subsets));
    let mut families = take(&mut input.families);
    let mesh = MeshCheck::new(&input, topology.as_ref());
    let holes = faces::holes(&input.hole_indices, &mesh, found);
    let creases = creases::creases(&input, &mesh, found);
    let corners = creases::corners(&input, &mesh, found);
    let (primvars, faulty) = primvars::primvars(primvars, &mesh, &input.prim, found);
    let (subsets, of_families) = subsets::subsets(subsets, &mut families, (&mesh, &input.prim), found);

    let Some(topology) = topology.filter(|_| problems.is_empty()) else {
        return Err(problems.into_error(&input.prim));
    };
    let mut warnings = surface::warnings(&input.prim, &topology, &input.points);
    let mut left_out = input.left_out;
    left_out.extend(faulty);
    warnings.extend(left_out.iter().map(LeftOut::warning));
    warnings.extend(of_families);
    let garment = Mesh {
        prim: input.prim,
        points: input.points.into(),
        faces: topology.faces,
        units: input.units,
        uv_scales: input.uv_scales,
        space: input.space,
        materials: input.materials,
        orientation: input.orientation,
        rules: input.rules,
        holes,
        creases,
        corners,
        primvars: primvars.into(),
        left_out,
        influences: None,
        subsets: subsets.into(),
        families,
    };
    Ok((garment, warnings))
}
