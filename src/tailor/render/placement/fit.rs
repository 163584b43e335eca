//! Fits the controls of a cage so that their limit positions reach given targets.
//!
//! An exact fit solves a linear system and oscillates where lines are unevenly spaced. Progressive interpolation
//! instead moves each control by the error of its limit, a few times (Richardson's iteration). It is exact where the
//! error is even, as along a seam or layer, and it does not amplify errors that change from vertex to vertex.
//!
//! [`LimitFit::base`] fits the cage without heights, [`LimitFit::aligned`] fits the second layer to the first, and
//! [`LimitFit::raised`] adds the heights. The heights of a layer have one sign, and limit masks are weighted means. So
//! the limit of the layer stays on its side of the surface.
//!
//! Reference: Chen et al. 2008, Progressive Interpolation based on Catmull-Clark Subdivision Surfaces.

use super::patches::{CagePlace, Patches};
use crate::render::child::Table;
use crate::render::operator::{Control, ControlRole};
use glam::Vec3;
use rayon::prelude::*;
use tailor_mesh::connectivity::{IdVec, VertexId};

/// Fitting steps without heights. More steps come nearer to the surface and oscillate more.
const BASE_STEPS: usize = 4;
/// Fitting steps of the heights.
const HEIGHT_STEPS: usize = 4;
/// Least weight of raised vertices that is assumed in a limit mask, so that steps stay bounded.
const MIN_RAISED_WEIGHT: f32 = 0.4;
/// Share by which a concave bend may shorten an edge on the second layer. A larger share brings the layer closer to
/// self-intersection.
const MAX_SHORTENING: f32 = 0.7;
/// Range of a copy's height on the cage, as shares of its height on the limit surface.
const COPY_HEIGHT_RANGE: [f32; 2] = [0.7, 2.0];

/// The controls of a cage with their limit masks.
pub struct LimitFit<'a> {
    /// The controls.
    pub controls: &'a [Control],
    /// Where each control is on the parent.
    pub places: &'a [Option<CagePlace>],
    /// Limit masks of all vertices.
    pub rows: &'a Table<VertexId>,
    /// For each control, itself, or the original of a copy with another mask: the limits of both should coincide.
    pub reference_control: &'a [usize],
}

/// The height of a control.
#[derive(Clone, Copy, Debug)]
pub struct Raise {
    /// Direction of the height.
    pub normal: Vec3,
    /// Height on the limit surface, signed. \[mesh units\]
    pub height: f32,
    /// True if the height was reduced, or the layer closes beside it: on the cage, a copy then stays within it.
    pub is_least: bool,
}

impl LimitFit<'_> {
    fn row(&self, control: usize) -> &[(VertexId, f32)] {
        self.rows.at(self.controls[control].vertex.index())
    }

    fn limit(&self, control: usize, points: &IdVec<VertexId, Vec3>) -> Vec3 {
        self.row(control).iter().map(|&(v, w)| w * points[v]).sum()
    }

    /// The points `linear`, with those of seams at their targets. Lines of a seam are close to each other, and so are a point
    /// among them and its limit. The parent's points are farther from theirs than the lines are apart.
    pub fn on_surface(&self, targets: &[(Vec3, Vec3)], linear: &IdVec<VertexId, Vec3>) -> IdVec<VertexId, Vec3> {
        let mut points = linear.clone();
        for (control, (target, _)) in self.controls.iter().zip(targets) {
            if matches!(control.role, ControlRole::Raised | ControlRole::Crest) && target.is_finite() {
                points[control.vertex] = *target;
            }
        }
        points
    }

    /// The cage without heights: the limits of the controls are on the limit surface of the parent. `targets` are positions
    /// and normals there, and `room` is how far each control may go along it from `start`, as lines close to each other must not
    /// pass.
    pub fn base(
        &self,
        patches: &Patches,
        targets: &[(Vec3, Vec3)],
        room: &[f32],
        start: &IdVec<VertexId, Vec3>,
    ) -> IdVec<VertexId, Vec3> {
        let mut points = start.clone();
        let is_layer = |control: &Control| control.role.original().is_some();
        let places = self.places.iter().zip(self.controls).map(|(place, control)| place.filter(|_| !is_layer(control)));
        let mut places: Vec<Option<CagePlace>> = places.collect();
        for _ in 0..BASE_STEPS {
            let step = |i: usize, place: &mut Option<CagePlace>| {
                let (limit, vertex) = (self.limit(i, &points), self.controls[i].vertex);
                let Some((nearer, target)) = place.and_then(|place| patches.nearer(place, limit)) else {
                    return Vec3::ZERO;
                };
                *place = Some(nearer);
                let moved = points[vertex] + target - limit - start[vertex];
                let along = moved.reject_from_normalized(targets[i].1);
                start[vertex] + moved - along + along.clamp_length_max(room[i]) - points[vertex]
            };
            let steps: Vec<Vec3> = places.par_iter_mut().enumerate().map(|(i, place)| step(i, place)).collect();
            self.move_by(&steps, &mut points);
            self.move_copies_to_originals(&mut points);
        }
        points
    }

    fn move_copies_to_originals(&self, points: &mut IdVec<VertexId, Vec3>) {
        for control in self.controls {
            if let Some(over) = control.role.original() {
                points[control.vertex] = points[over];
            }
        }
    }

    /// Moves copies outwards so that their limits coincide with those of their reference controls.
    pub fn aligned(&self, targets: &[(Vec3, Vec3)], mut points: IdVec<VertexId, Vec3>) -> IdVec<VertexId, Vec3> {
        for _ in 0..BASE_STEPS {
            let step = |i: usize| match self.controls[i].role {
                ControlRole::Copy { side, .. } if self.reference_control[i] != i => {
                    let error =
                        (self.limit(self.reference_control[i], &points) - self.limit(i, &points)).dot(targets[i].1);
                    // A move towards the first layer would intersect it between the vertices.
                    (side * (side * error).max(0.0)) * targets[i].1
                }
                _ => Vec3::ZERO,
            };
            let steps: Vec<Vec3> = (0..self.controls.len()).into_par_iter().map(step).collect();
            self.move_by(&steps, &mut points);
        }
        points
    }

    fn move_by(&self, steps: &[Vec3], points: &mut IdVec<VertexId, Vec3>) {
        self.controls.iter().zip(steps).filter(|(_, s)| s.is_finite()).for_each(|(c, &s)| points[c.vertex] += s);
    }

    /// Raises the controls so that their limits are at their heights over those in `base`.
    pub fn raised(&self, raises: &[Raise], base: &IdVec<VertexId, Vec3>) -> IdVec<VertexId, Vec3> {
        let raised: Vec<usize> = (0..raises.len()).filter(|&i| raises[i].height != 0.0).collect();
        let mut is_raised = IdVec::filled(false, base.len());
        raised.iter().for_each(|&i| is_raised[self.controls[i].vertex] = true);
        let prepare = |&i: &usize| {
            let weight = self.row(i).iter().filter(|(v, _)| is_raised[*v]).map(|(_, w)| w).sum::<f32>();
            (self.limit(i, base).dot(raises[i].normal) + raises[i].height, weight.max(MIN_RAISED_WEIGHT))
        };
        let wanted: Vec<(f32, f32)> = raised.par_iter().map(prepare).collect();
        let mut lifts: Vec<f32> = raised.iter().map(|&i| raises[i].height).collect();
        let mut points = base.clone();
        for step in 0..=HEIGHT_STEPS {
            for (&i, &lift) in raised.iter().zip(&lifts) {
                points[self.controls[i].vertex] = base[self.controls[i].vertex] + lift * raises[i].normal;
            }
            if step < HEIGHT_STEPS {
                let next = |((&i, &(wanted, weight)), &lift): ((&usize, &(f32, f32)), &f32)| {
                    let error = wanted - self.limit(i, &points).dot(raises[i].normal);
                    let next = lift + error / weight;
                    if self.controls[i].role.original().is_some() { raises[i].clamped(next) } else { next }
                };
                lifts = raised.par_iter().zip(&wanted).zip(&lifts).map(next).collect();
            }
        }
        points
    }
}

/// Lowers heights at the ends of edges that the second layer would shorten too far or flip, inside a concave bend.
/// `targets` are positions and normals.
pub fn unfolded(heights: &mut [f32], edges: &[[usize; 2]], targets: &[(Vec3, Vec3)]) {
    for &[a, b] in edges {
        let ((p, n), (q, m)) = (targets[a], targets[b]);
        let turn = (m - n).dot(q - p);
        let most = MAX_SHORTENING * p.distance_squared(q) / turn.abs();
        for i in [a, b] {
            if heights[i] * turn < 0.0 {
                heights[i] = heights[i].abs().min(most).copysign(heights[i]);
            }
        }
    }
}

impl Raise {
    fn clamped(&self, lift: f32) -> f32 {
        let [least, most] = if self.is_least { [COPY_HEIGHT_RANGE[0], 1.0] } else { COPY_HEIGHT_RANGE };
        let (a, b) = (least * self.height, most * self.height);
        if lift.is_finite() { lift.clamp(a.min(b), a.max(b)) } else { self.height }
    }
}
