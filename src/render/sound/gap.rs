//! How far it is from each face of a cage to the next layer.

use super::skin::{Skin, quads};
use super::tree::{Bounds, Tree};
use crate::mesh::{FaceId, IdVec};
use glam::Vec3;
use rayon::prelude::*;

/// Cosine between normals below which faces that touch are two sides of a fold.
const FOLDED: f32 = -0.3;
/// Share of a face's size within which points of faces that touch are those they have in common.
const SHARED: f32 = 1e-3;
/// Cosine between a triangle's normal and the direction below which it is seen edge on, and has no height.
const STEEP: f32 = 1e-2;
/// Part of a triangle's area by which a point may be outside it.
const ROUNDING: f32 = 1e-6;

/// How far it is from a face to the next layer against and along its normal. \[stage units\]
pub type Gap = [f32; 2];

/// No layer is near.
pub const OPEN: Gap = [f32::INFINITY; 2];

/// A face seen along its normal: its samples in a frame whose last axis is the normal.
struct View {
    face: FaceId,
    axes: [Vec3; 3],
    samples: Vec<Vec3>,
    /// Their range along each axis.
    range: Bounds,
}

impl View {
    fn place(&self, p: Vec3) -> Vec3 {
        Vec3::from(self.axes.map(|axis| axis.dot(p)))
    }

    /// Whether a box is not over or under the face.
    fn is_beside(&self, bounds: &Bounds) -> bool {
        let (middle, half) =
            (Vec3::from(0.5 * (bounds.low + bounds.high)), Vec3::from(0.5 * (bounds.high - bounds.low)));
        (0..2).any(|i| {
            let (at, radius) = (middle.dot(self.axes[i]), half.dot(self.axes[i].abs()));
            at + radius <= self.range.low[i] || at - radius >= self.range.high[i]
        })
    }
}

impl Skin<'_> {
    /// For each face the gap to the next layer that is within `reach` of it.
    pub fn gaps(&self, reach: f32) -> IdVec<FaceId, Gap> {
        let tree = Tree::new(&self.boxes);
        let of = |face: FaceId| {
            let (mut gap, view, mut samples) = (OPEN, self.view(face), Vec::new());
            let around = self.boxes[face].grown(reach);
            tree.visit(&around, &mut |other, _| self.narrow(&view, other, reach, &mut samples, &mut gap));
            gap
        };
        (0..self.boxes.len()).into_par_iter().map(|f| of(FaceId::new(f))).collect::<Vec<_>>().into()
    }

    fn view(&self, face: FaceId) -> View {
        let normal = self.normal(face);
        let (u, v) = normal.try_normalize().unwrap_or(Vec3::Z).any_orthonormal_pair();
        let mut view = View { face, axes: [u, v, normal], samples: Vec::new(), range: Bounds::EMPTY };
        view.samples = self.samples(face).iter().map(|&p| view.place(p)).collect();
        view.range = Bounds::of(&view.samples);
        view
    }

    /// Narrows the gap of a face to what another leaves of it, whose samples in the face's frame go to `samples`.
    fn narrow(&self, view: &View, other: FaceId, reach: f32, samples: &mut Vec<Vec3>, gap: &mut Gap) {
        if view.face == other || view.is_beside(&self.boxes[other]) {
            return;
        }
        let touch = self.touch(view.face, other);
        if touch && view.axes[2].dot(self.normal(other)) > FOLDED {
            return;
        }
        samples.clear();
        samples.extend(self.samples(other).iter().map(|&p| view.place(p)));
        let (own, its) = (view.range, Bounds::of(samples));
        // Nearer ones are known on both sides.
        let is_far = its.low.z - own.high.z > gap[1].min(reach) || own.low.z - its.high.z > gap[0].min(reach);
        if is_far || (0..2).any(|i| its.high[i] <= own.low[i] || its.low[i] >= own.high[i]) {
            return;
        }
        let size = (self.boxes[view.face].high - self.boxes[view.face].low).max_element();
        let least = if touch { SHARED * size } else { 0.0 };
        let mut take = |height: f32| {
            if height.abs() >= least {
                let side = usize::from(height > 0.0);
                gap[side] = gap[side].min(height.abs());
            }
        };
        // From the points of each face to the other one, as either may have the finer ones.
        heights_over(&view.samples, samples, &mut take);
        heights_over(samples, &view.samples, &mut |height| take(-height));
    }
}

/// How far it is along the last axis from each of `points` to the children over and under it.
fn heights_over(points: &[Vec3], children: &[Vec3], take: &mut impl FnMut(f32)) {
    for quad in quads(children) {
        let Bounds { low, high } = Bounds::of(&quad);
        for &p in points {
            let is_beside = p.x < low.x || p.x > high.x || p.y < low.y || p.y > high.y;
            if !is_beside && let Some(height) = height_of(p, quad) {
                take(height);
            }
        }
    }
}

/// How far along the last axis it is from `p` to a quad, if it is there.
fn height_of(p: Vec3, [a, b, c, d]: [Vec3; 4]) -> Option<f32> {
    [[a, b, c], [a, c, d]].into_iter().find_map(|[a, b, c]| {
        let normal = (b - a).cross(c - a);
        if normal.z.abs() < STEEP * normal.length() {
            return None;
        }
        let part = |u: Vec3, v: Vec3| (v - u).truncate().perp_dot((p - u).truncate()) / normal.z;
        let parts = [part(b, c), part(c, a), part(a, b)];
        let inside = parts.iter().all(|&part| part >= -ROUNDING);
        inside.then(|| parts[0] * a.z + parts[1] * b.z + parts[2] * c.z - p.z)
    })
}
