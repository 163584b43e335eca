//! Primvars on the simulation mesh, each by the elements that carry it.

use super::correspondence::Correspondence;
use super::{corners, faces, normals, provenance, vertices};
use crate::sim::SimOptions;
use rayon::prelude::*;
use tailor_mesh::error::{Warning, Warnings};
use tailor_mesh::garment::{Interpolation, Mesh, Primvar, joints};
use tailor_mesh::subdivide::to_unit_length;

/// The garment's primvars on the simulation mesh in the garment's order, and those of provenance if they are asked for.
pub(super) fn carry_all(garment: &Mesh, map: &Correspondence<'_>, options: &SimOptions) -> (Vec<Primvar>, Warnings) {
    let carry = |primvar| carry(garment, primvar, map, &options.uv_set);
    let (carried, warnings): (Vec<_>, Vec<_>) = garment.primvars.par_iter().map(carry).unzip();
    let mut primvars: Vec<Primvar> = carried.into_iter().flatten().collect();
    primvars.extend(vertices::carry_influences(garment, map));
    primvars.iter_mut().for_each(to_unit_length);
    primvars.sort_by_key(|p| garment.primvars.iter().position(|q| q.name == p.name));
    if options.provenance {
        let own = provenance::primvars(map);
        primvars.retain(|p| own.iter().all(|o| o.name != p.name));
        primvars.extend(own);
    }
    (primvars, warnings.into_iter().flatten().collect())
}

/// A primvar on the simulation mesh; none of joint influences, which are carried together.
fn carry(
    garment: &Mesh,
    primvar: &Primvar,
    map: &Correspondence<'_>,
    uv_set: &str,
) -> (Option<Primvar>, Option<Warning>) {
    if let Some(normals) = normals::recomputed(garment, primvar, map) {
        return (Some(normals), None);
    }
    let carried = match primvar.interpolation {
        Interpolation::Constant => Some(primvar.clone()),
        Interpolation::Uniform => Some(faces::carry_primvar(primvar, map)),
        Interpolation::FaceVarying => {
            let (carried, warning) = corners::carry(garment, primvar, map, uv_set);
            return (Some(carried), warning);
        }
        _ if joints::is_influence(garment, primvar) => None,
        Interpolation::Vertex | Interpolation::Varying => Some(vertices::carry(garment, primvar, map)),
    };
    (carried, None)
}
