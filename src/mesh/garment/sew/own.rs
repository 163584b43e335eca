//! Borders of one mesh that coincide: files of glTF and FBX have such points twice along each cut of the UVs.

use super::borders::{Border, Match, Pairs, matches};
use super::merge::{Panel, Sewn, merge};
use super::{Seam, unsewn};
use crate::codes;
use crate::connectivity::{Elements, VertexId};
use crate::error::{Warning, Warnings};
use crate::garment::{Garment, check_garment};
use glam::DMat4;

/// Sews the borders of `mesh` that coincide, as [`find_seams`](super::find_seams) does between meshes: where an edge has one
/// counterpart, of the same winding. The set of the seam is the only one that is new. Gives nothing for a mesh without such
/// edges or with faults. Warns of borders that lie along each other and are not sewn. Time is n log n in the number of edges.
pub fn sew_own_borders(mesh: &Garment, tolerance: f64) -> (Option<(Sewn, Seam)>, Warnings) {
    let is_point = |&p: &i32| usize::try_from(p).is_ok_and(|p| p < mesh.points.len());
    if !mesh.face_vertex_indices.iter().all(is_point) || !mesh.points.iter().all(|p| p.is_finite()) {
        return (None, Warnings::default());
    }
    let border = Border::of(mesh, &DMat4::IDENTITY);
    let borders = std::slice::from_ref(&border);
    let pairs = unambiguous(&border, matches(borders, tolerance, Pairs::Within).unwrap_or_default());
    let sewn = (!pairs.is_empty()).then(|| sew(mesh, borders, &pairs)).flatten();
    let mut is_sewn = vec![false; border.edges.len()];
    if sewn.is_some() {
        pairs.iter().flat_map(|pair| pair.edges).for_each(|(_, edge)| is_sewn[edge] = true);
    }
    let warnings = open_borders(mesh, &border, &is_sewn, tolerance).into_iter().collect();
    (sewn, warnings)
}

/// The pairs whose edges are in no other, and whose faces run along them in opposite directions.
fn unambiguous(border: &Border, found: Vec<Match>) -> Vec<Match> {
    let mut counts = vec![0; border.edges.len()];
    found.iter().flat_map(|pair| pair.edges).for_each(|(_, edge)| counts[edge] += 1);
    let fits = |pair: &Match| {
        let [a, b] = pair.edges.map(|(_, edge)| &border.edges[edge]);
        pair.edges.iter().all(|&(_, edge)| counts[edge] == 1) && (a.forward == b.forward) == pair.reversed
    };
    found.into_iter().filter(fits).collect()
}

/// The mesh with the points of these pairs as one; none where it has faults before or after.
fn sew(mesh: &Garment, borders: &[Border], pairs: &[Match]) -> Option<(Sewn, Seam)> {
    let (checked, _) = check_garment(mesh.clone()).ok()?;
    let welds: Vec<_> = pairs.iter().flat_map(|pair| pair.welds(borders)).collect();
    let mut panel = Panel { name: String::new(), mesh: mesh.clone() };
    panel.mesh.leave_out(&checked);
    let mut sewn = merge(mesh.prim.clone(), mesh.units, vec![panel], &welds).ok()?;
    sewn.mesh.space = mesh.space;
    sewn.mesh.face_numbers.clone_from(&mesh.face_numbers);
    sewn.mesh.materials.clone_from(&mesh.materials);
    let gap = pairs.iter().map(|pair| pair.gap).fold(0.0, f64::max);
    Some((sewn, Seam { panels: [0, 0], edges: pairs.len(), gap }))
}

/// The warning of borders of a mesh that lie along each other and are not sewn.
fn open_borders(mesh: &Garment, border: &Border, is_sewn: &[bool], tolerance: f64) -> Option<Warning> {
    let edges = unsewn::find_own(border, is_sewn, tolerance);
    let problem = format!(
        "{} border edges lie along others of the mesh and are not sewn, so that the two sides move apart",
        edges.len()
    );
    let remedy = "Weld the points before the export, as by merge by distance, or raise --sew-tolerance. Layers that only lie \
                  on each other need nothing";
    let is_found = !edges.is_empty();
    let edges = edges.into_iter().map(|edge| edge.map(VertexId::new)).collect();
    is_found.then(|| Warning::new(codes::UNSEWN_BORDERS, &mesh.prim, problem).at(Elements::Edges(edges)).remedy(remedy))
}
