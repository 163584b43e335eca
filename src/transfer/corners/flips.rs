//! Flipped triangles of a layout: values near the cuts are extrapolated, averaged or cut off until no triangle is
//! flipped.

use super::field::doubled_area;
use super::shells::{ROUNDS, ShellValues};
use super::sources::CornerSource;
use crate::mesh::{CornerId, FaceId};
use crate::sim::BaselinePoint;
use crate::subdivide::Real;
use glam::Vec3;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Smallest area in UV of an unflipped triangle, as a share of the area in proportion to that of its seed.
const MIN_AREA: f64 = 0.02;

/// The corners of one vertex that share a value, and a new value for them.
type ValueChange<T> = (Vec<CornerId>, [T; 2]);

impl<T: Real> ShellValues<'_, T> {
    /// Extrapolates values beyond the cuts where the closest ones on the shell flip a triangle, and updates the set of
    /// flipped triangles.
    pub fn unflip(&mut self) {
        let stale = std::mem::take(&mut self.stale);
        let (flipped, upright): (Vec<FaceId>, Vec<FaceId>) = stale.into_par_iter().partition(|&f| self.is_flipped(f));
        self.flipped.extend(flipped);
        for face in &upright {
            self.flipped.remove(face);
        }
        let mut round = self.flipped.clone();
        for _ in 0..ROUNDS {
            let mut next = BTreeSet::new();
            while let Some(face) = round.pop_first() {
                if self.check_flip(face) {
                    for other in self.extrapolate_corners(face) {
                        (if other > face { &mut round } else { &mut next }).insert(other);
                    }
                }
            }
            round = next;
        }
        for face in round {
            self.check_flip(face);
        }
    }

    /// Whether a triangle is flipped now, which updates the set of those that are.
    fn check_flip(&mut self, face: FaceId) -> bool {
        let is_flipped = self.is_flipped(face);
        if is_flipped {
            self.flipped.insert(face);
        } else {
            self.flipped.remove(&face);
        }
        is_flipped
    }

    /// Whether a triangle has too little area in UV, or another orientation than its seed. Triangles where the layout
    /// itself is folded are exempt.
    fn is_flipped(&self, face: FaceId) -> bool {
        let map = self.cuts.map;
        let corners = [0, 1, 2].map(|k| CornerId::new(3 * face.index() + k));
        // Triangles away from the cuts are on the shell of their corners.
        let seed = self.seeds[face].unwrap_or(map.product.places[corners[0]].location.face);
        let of_seed = self.field.doubled_area(seed);
        let [a, b, c] = corners.map(|c| self.uv(c));
        let own = doubled_area([&a, &b, &c]);
        let [a, b, c] = map.triangle(face);
        let in_space = f64::from((b - a).cross(c - a).length()) / f64::from(map.product.baseline.normal(seed).length());
        let is_flipped = in_space.is_finite() && own * of_seed.signum() <= MIN_AREA * of_seed.abs() * in_space;
        let is_folded = |c: CornerId| self.field.doubled_area(self.sources[c].location.face) * of_seed <= 0.0;
        is_flipped && !corners.into_iter().any(is_folded)
    }

    /// Extrapolates the values of a triangle's moved corners. Returns the triangles near the cuts that share them.
    fn extrapolate_corners(&mut self, face: FaceId) -> BTreeSet<FaceId> {
        let mut changed = BTreeSet::new();
        for corner in self.cuts.map.mesh.topology.faces.corners_of(face) {
            if self.sources[corner].moved {
                let location = self.cuts.extrapolated(corner, self.sources[corner].location);
                let value = self.value_at(&location);
                let sharing = self.sharing(corner);
                for &other in &sharing {
                    self.set_uv(other, value);
                    self.sources[other] = CornerSource { location, moved: false };
                }
                changed.extend(self.faces_of(&sharing).filter(|&f| self.seeds[f].is_some()));
            }
        }
        changed
    }

    /// Changes values of flipped triangles where that leaves fewer flipped: one to the mean of its neighbours, or some
    /// to their extrapolations.
    pub fn relax_flipped(&mut self) {
        for _ in 0..ROUNDS {
            for face in self.flipped.clone() {
                let corners = self.cuts.map.mesh.topology.faces.corners_of(face);
                let extrapolated: Vec<ValueChange<T>> = corners.clone().filter_map(|c| self.extrapolation(c)).collect();
                let is_better = corners.clone().any(|c| self.try_changes(&[self.neighbour_mean(c)]))
                    || extrapolated.iter().any(|m| self.try_changes(std::slice::from_ref(m)));
                if !is_better {
                    self.try_changes(&extrapolated);
                }
            }
        }
    }

    /// Changes values if that leaves fewer triangles flipped. Returns whether it does.
    fn try_changes(&mut self, changes: &[ValueChange<T>]) -> bool {
        let faces: BTreeSet<FaceId> = changes.iter().flat_map(|c| self.faces_of(&c.0)).collect();
        let flipped = |shells: &Self| faces.iter().filter(|&&f| shells.is_flipped(f)).count();
        let before = flipped(self);
        let corners: Vec<(CornerId, [T; 2])> =
            changes.iter().flat_map(|(corners, value)| corners.iter().map(|&c| (c, *value))).collect();
        let values: Vec<[T; 2]> = corners.iter().map(|&(corner, _)| self.uv(corner)).collect();
        corners.iter().for_each(|&(corner, value)| self.set_uv(corner, value));
        if flipped(self) >= before {
            corners.iter().zip(values).for_each(|(&(corner, _), value)| self.set_uv(corner, value));
            return false;
        }
        for face in faces {
            self.check_flip(face);
        }
        true
    }

    /// Gives each flipped triangle extrapolated values of its own, apart from its neighbours.
    pub fn cut_off_flipped(&mut self) {
        for face in self.flipped.clone() {
            for corner in self.cuts.map.mesh.topology.faces.corners_of(face) {
                if let Some((_, value)) = self.extrapolation(corner) {
                    self.set_uv(corner, value);
                }
            }
        }
    }

    /// A corner's value as the mean of the corners next to it.
    fn neighbour_mean(&self, corner: CornerId) -> ValueChange<T> {
        let faces = &self.cuts.map.mesh.topology.faces;
        let corners = self.sharing(corner);
        let neighbours = corners.iter().flat_map(|&c| [faces.next(c), faces.prev(c)]);
        let add = |sum: [f64; 2], uv: [T; 2]| [0, 1].map(|k| sum[k] + uv[k].to_f64());
        let sum = neighbours.map(|c| self.uv(c)).fold([0.0; 2], add);
        let mean = sum.map(|x| T::from_f64(x / (2 * corners.len()) as f64));
        (corners, mean)
    }

    /// A corner's value by extrapolation of its triangle's seed; none away from the cuts.
    fn extrapolation(&self, corner: CornerId) -> Option<ValueChange<T>> {
        let face = self.seeds[self.cuts.map.mesh.topology.faces.face_of(corner)]?;
        let centroid = BaselinePoint { face, weights: Vec3::splat(1.0 / 3.0) };
        Some((self.sharing(corner), self.value_at(&self.cuts.extrapolated(corner, centroid))))
    }

    /// The corners of a vertex that share a corner's value.
    fn sharing(&self, corner: CornerId) -> Vec<CornerId> {
        let t = &self.cuts.map.mesh.topology;
        let around = t.vertex_corners.row(t.faces.vertex(corner)).iter().copied();
        around.filter(|&c| self.field.same(&self.values, c, corner)).collect()
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
