//! Panels of one garment: meshes whose borders coincide become one mesh.
//!
//! [`find_seams`] matches border edges of different meshes and groups the meshes that share some. [`merge`] welds the points of
//! a group and joins its faces, primvars and subsets. [`sew_own_borders`] does both within one mesh.

mod borders;
mod merge;
mod own;
mod primvars;
mod subsets;
mod unsewn;

#[cfg(test)]
mod tests;

pub use borders::{border_points, edges};
pub use merge::{Panel, Sewn, merge, place};
pub use own::sew_own_borders;
pub use unsewn::Unsewn;

use super::Garment;
use crate::codes;
use crate::connectivity::Groups;
use crate::error::{Error, ErrorKind};
use borders::{Border, Pairs, matches};
use glam::DMat4;
use std::collections::BTreeMap;

/// Default distance at which border points coincide. \[share of the mean edge length\]
pub const TOLERANCE: f64 = 0.001;
/// Largest tolerance. Larger ones would weld the ends of an edge. \[share of the mean edge length\]
pub const MAX_TOLERANCE: f64 = 0.25;

/// The seam between two meshes.
#[derive(Clone, Debug, PartialEq)]
pub struct Seam {
    /// The meshes by number, the lower one first.
    pub panels: [usize; 2],
    /// How many border edges match.
    pub edges: usize,
    /// The largest distance of two ends that match. \[units of the common space\]
    pub gap: f64,
}

/// The seams between meshes, and the garments that they make.
#[derive(Clone, Debug, Default)]
pub struct Seams {
    /// The seams, by their meshes.
    pub seams: Vec<Seam>,
    /// Borders that lie along each other and do not match.
    pub unsewn: Vec<Unsewn>,
    /// The meshes of each garment, by the first of them.
    pub garments: Vec<Vec<usize>>,
    /// Pairs of points that are one, each as mesh and point.
    pub welds: Vec<[(usize, usize); 2]>,
}

/// Finds the border edges of different meshes that coincide. Each mesh comes with its transform to a common space; its indices
/// are those of a mesh that passes the check. Time is n log n in the number of border edges.
///
/// Edges match where both ends are within `tolerance` of each other, which is a share of the smaller mean edge length.
///
/// # Errors
/// More border edges at one place than a garment has.
pub fn find_seams(meshes: &[(&Garment, DMat4)], tolerance: f64) -> Result<Seams, Error> {
    let borders: Vec<Border> = meshes.iter().map(|(mesh, to_common)| Border::of(mesh, to_common)).collect();
    let pairs = matches(&borders, tolerance, Pairs::Between).map_err(|crowd| {
        let fault = Error::new(
            ErrorKind::Mesh,
            &meshes[crowd].0.prim,
            "more border edges of other meshes lie in one place than can be sewn",
        );
        fault.code(codes::PANELS_DIFFER).remedy("leave copies out by --exclude, or lower --sew-tolerance")
    })?;
    let mut sewn: Vec<Vec<bool>> = borders.iter().map(|border| vec![false; border.edges.len()]).collect();
    let mut seams = BTreeMap::<[usize; 2], Seam>::new();
    let mut found = Seams::default();
    for pair in pairs {
        let panels = pair.edges.map(|(panel, _)| panel);
        pair.edges.iter().for_each(|&(panel, edge)| sewn[panel][edge] = true);
        let seam = seams.entry(panels).or_insert(Seam { panels, edges: 0, gap: 0.0 });
        seam.edges += 1;
        seam.gap = seam.gap.max(pair.gap);
        found.welds.extend(pair.welds(&borders));
    }
    found.seams = seams.into_values().collect();
    found.garments = garments(meshes.len(), &found.seams);
    found.unsewn = unsewn::find(&borders, &sewn, tolerance);
    Ok(found)
}

/// The meshes that seams connect, by the first of each.
fn garments(count: usize, seams: &[Seam]) -> Vec<Vec<usize>> {
    let mut sets = Groups::new(count);
    for &Seam { panels: [a, b], .. } in seams {
        sets.join(a, b);
    }
    let mut found = BTreeMap::<usize, Vec<usize>>::new();
    for mesh in 0..count {
        found.entry(sets.first(mesh)).or_default().push(mesh);
    }
    found.into_values().collect()
}
