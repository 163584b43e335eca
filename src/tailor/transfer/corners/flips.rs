//! Flipped triangles of a layout: values beyond the cuts are extrapolated, and what is flipped then is cut off.

use super::field::doubled_area;
use super::shells::{ShellValues, near_cuts};
use crate::sim::BaselinePoint;
use glam::Vec3;
use rayon::prelude::*;
use tailor_mesh::connectivity::{CornerId, FaceId};
use tailor_mesh::subdivide::Real;

/// Smallest area in UV of an unflipped triangle, as a share of the area in proportion to that of its seed.
const MIN_AREA: f64 = 0.02;

impl<T: Real> ShellValues<'_, T> {
    /// The flipped triangles near the cuts.
    pub fn flipped(&self) -> Vec<FaceId> {
        let near: Vec<FaceId> = near_cuts(&self.seeds).collect();
        near.into_par_iter().filter(|&face| self.is_flipped(face)).collect()
    }

    /// Whether a triangle has too little area in UV, or another orientation than its seed. Triangles where the layout
    /// itself is flipped are exempt.
    fn is_flipped(&self, face: FaceId) -> bool {
        let map = self.cuts.map;
        let corners = [0, 1, 2].map(|k| CornerId::new(3 * face.index() + k));
        let Some(seed) = self.seeds[face] else { return false };
        let of_seed = self.field.doubled_area(seed);
        let [a, b, c] = corners.map(|c| self.uv(c));
        let own = doubled_area([&a, &b, &c]);
        let [a, b, c] = map.triangle(face);
        let in_space = f64::from((b - a).cross(c - a).length()) / f64::from(map.product.baseline.normal(seed).length());
        let is_flipped = in_space.is_finite() && own * of_seed.signum() <= MIN_AREA * of_seed.abs() * in_space;
        let is_flipped_there = |c: CornerId| self.field.doubled_area(self.sources[c].location.face) * of_seed <= 0.0;
        is_flipped && !corners.into_iter().any(is_flipped_there)
    }

    /// Extrapolates values beyond the cuts where the closest ones on the shell flip a triangle.
    pub fn extrapolate_flipped(&mut self) {
        for face in self.flipped() {
            for corner in self.cuts.map.mesh.topology.faces.corners_of(face) {
                if self.sources[corner].moved {
                    let value = self.value_at(&self.cuts.extrapolated(corner, self.sources[corner].location));
                    self.set_shared_uv(corner, value);
                }
            }
        }
    }

    /// Gives a triangle, apart from its neighbours, values that are extrapolated from its seed.
    pub fn cut_off(&mut self, face: FaceId) {
        let Some(seed) = self.seeds[face] else { return };
        let centroid = BaselinePoint { face: seed, weights: Vec3::splat(1.0 / 3.0) };
        for corner in self.cuts.map.mesh.topology.faces.corners_of(face) {
            let value = self.value_at(&self.cuts.extrapolated(corner, centroid));
            self.set_uv(corner, value);
        }
    }

    /// Sets the value of a corner and of those of its vertex that share it.
    fn set_shared_uv(&mut self, corner: CornerId, value: [T; 2]) {
        let t = &self.cuts.map.mesh.topology;
        let around = t.vertex_corners.row(t.faces.vertex(corner)).iter().copied();
        let sharing: Vec<CornerId> = around.filter(|&c| self.field.same(&self.values, c, corner)).collect();
        sharing.into_iter().for_each(|c| self.set_uv(c, value));
    }

    fn value_at(&self, at: &BaselinePoint) -> [T; 2] {
        let mut value = [T::from_f64(0.0); 2];
        self.field.value_at(at, &mut value);
        value
    }

    fn uv(&self, corner: CornerId) -> [T; 2] {
        [0, 1].map(|k| self.values[2 * corner.index() + k])
    }

    fn set_uv(&mut self, corner: CornerId, value: [T; 2]) {
        self.values[2 * corner.index()..][..2].copy_from_slice(&value);
    }
}
