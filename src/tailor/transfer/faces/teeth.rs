//! Teeth of borders that follow no edges of constraints. A face that the line of a border cuts near its middle may be a tooth.

use super::sets::Labels;
use crate::transfer::correspondence::Correspondence;
use std::cmp::Reverse;
use tailor_mesh::connectivity::FaceId;

/// Least share of a tooth that the set around it covers. On twelve garments at half a cage edge, borders are 21 % longer than their
/// lines if teeth stay, and 7 % at this share. Smaller shares make borders shorter, and put more area on the wrong side of them.
const LEAST: f32 = 0.35;

/// Gives teeth to the set around them. A tooth is one of `faces` with one edge to its own set and two to another, which covers a
/// `share` of it that is large enough. Each of them shortens the border by an edge, so that there is an end.
pub(super) fn join_teeth(
    labels: &mut Labels,
    map: &Correspondence<'_>,
    faces: &[FaceId],
    share: impl Fn(FaceId, Option<u32>) -> f32,
) {
    loop {
        let tooth = |&face: &FaceId| {
            let set = set_around(labels, map, face)?;
            // The bits of shares, which are not negative, sort as the shares do.
            Some(share(face, set)).filter(|&share| share >= LEAST).map(|share| (Reverse(share.to_bits()), face, set))
        };
        let mut teeth: Vec<_> = faces.iter().filter_map(tooth).collect();
        if teeth.is_empty() {
            return;
        }
        teeth.sort_unstable();
        for (_, face, set) in teeth {
            if set_around(labels, map, face) == Some(set) {
                labels[face] = set;
            }
        }
    }
}

/// The set beyond two edges of a face, if its third edge is inside its own set and this has more faces there.
fn set_around(labels: &Labels, map: &Correspondence<'_>, face: FaceId) -> Option<Option<u32>> {
    let own = labels[face];
    let around = |face: FaceId| map.mesh.open_neighbours(face).map(|(_, other)| other);
    let is_own = |other: &FaceId| labels[*other] == own;
    let mut others = around(face).filter(|other| !is_own(other)).map(|other| labels[other]);
    let (Some(set), Some(second), None) = (others.next(), others.next(), others.next()) else { return None };
    let inside = around(face).find(is_own)?;
    (set == second && around(inside).filter(is_own).count() > 1).then_some(set)
}
