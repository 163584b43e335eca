//! UVs of triangles across the borders of small UV shells, which are not edges of the mesh: each triangle takes the UVs of one
//! shell at all of its corners, extrapolated beyond the shell.

use super::baseline::{Baseline, BaselinePoint};
use super::sim_mesh::BaselineUvPoint;
use glam::{Vec2, Vec3};
use std::collections::BTreeMap;
use tailor_mesh::connectivity::{CornerId, FaceId, IdVec, VertexId};

/// Largest barycentric weight of an extrapolation: beyond, UVs are those of the closest point.
const MAX_WEIGHT: f32 = 8.0;

/// Sets the UVs of `places` in triangles whose corners are on different shells. `points` are those of the mesh.
pub fn separate_shells(
    baseline: &Baseline,
    points: &IdVec<VertexId, Vec3>,
    triangles: &[[VertexId; 3]],
    places: &mut IdVec<CornerId, BaselineUvPoint>,
) {
    let shells = &baseline.small_shells;
    if shells.is_empty() {
        return;
    }
    let shell_of = |face: FaceId| shells.shell_of[baseline.source_face[face]];
    // Each vertex has one value on each shell, so that triangles of one shell stay connected.
    let mut known = BTreeMap::<(VertexId, FaceId), Vec2>::new();
    for (i, triangle) in triangles.iter().enumerate() {
        let corners = [0, 1, 2].map(|k| CornerId::new(3 * i + k));
        let faces = corners.map(|c| places[c].location.face);
        let own = faces.map(shell_of);
        if own[0] == own[1] && own[1] == own[2] {
            continue;
        }
        // The shell of two corners, else of the first; another one where that flips the triangle.
        let main = usize::from(own[1] == own[2]);
        let mut uvs_on = |k: usize| {
            [0, 1, 2].map(|j| {
                let uv = || baseline.uv_beyond(faces[k], points[triangle[j]], |face| shell_of(face) == own[k]);
                if own[j] == own[k] {
                    places[corners[j]].uv
                } else {
                    *known.entry((triangle[j], own[k])).or_insert_with(uv)
                }
            })
        };
        let is_upright = |k: usize, [a, b, c]: [Vec2; 3]| (b - a).perp_dot(c - a) * baseline.uv_area(faces[k]) > 0.0;
        let first = uvs_on(main);
        let other = |k: usize| Some(uvs_on(k)).filter(|&uvs| is_upright(k, uvs));
        let uvs = if is_upright(main, first) { first } else { (0..3).find_map(other).unwrap_or(first) };
        corners.into_iter().zip(uvs).for_each(|(corner, uv)| places[corner].uv = uv);
    }
}

impl Baseline {
    /// The UV of a point, extrapolated from the closest triangle that a walk from `start` over those of its shell reaches.
    fn uv_beyond(&self, start: FaceId, point: Vec3, is_in_shell: impl Fn(FaceId) -> bool + Copy) -> Vec2 {
        let closest = self.closest_among(start, point, is_in_shell).location;
        let [a, b, c] = self.triangle(closest.face);
        let (u, v, from) = (b - a, c - a, point - a);
        let normal = u.cross(v);
        let over = normal / normal.length_squared();
        let (s, t) = (from.cross(v).dot(over), u.cross(from).dot(over));
        let weights = Vec3::new(1.0 - s - t, s, t);
        let may_extrapolate = weights.is_finite() && weights.abs().max_element() <= MAX_WEIGHT;
        self.uv(if may_extrapolate { BaselinePoint { face: closest.face, weights } } else { closest })
    }
}
