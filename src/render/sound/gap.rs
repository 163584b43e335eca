//! How far it is from each face of a cage to the next layer.

use super::skin::Skin;
use super::tree::Tree;
use crate::mesh::{FaceId, IdVec};
use glam::Vec3;
use rayon::prelude::*;

/// Cosine between normals below which faces that touch are two sides of a fold.
const FOLDED: f32 = -0.3;
/// Share of a face's size within which points of faces that touch are those they have in common.
const SHARED: f32 = 1e-3;

/// How far it is from a face to the next layer against and along its normal. \[stage units\]
pub type Gap = [f32; 2];

/// No layer is near.
pub const OPEN: Gap = [f32::INFINITY; 2];

/// A face seen along its normal.
struct View {
    face: FaceId,
    normal: Vec3,
    /// Directions across the normal, with the range of the face along each.
    across: [(Vec3, f32, f32); 2],
    /// Its range along the normal.
    heights: (f32, f32),
    reach: f32,
}

impl Skin<'_> {
    /// For each face the gap to the next layer that is within `reach` of it.
    pub fn gaps(&self, reach: f32) -> IdVec<FaceId, Gap> {
        let tree = Tree::new(&self.boxes);
        let of = |face: FaceId| {
            let (mut gap, view) = (OPEN, self.view(face, reach));
            let around = self.boxes[face].grown(reach);
            tree.visit(&self.boxes, &around, &mut |other| self.narrow(&view, other, &mut gap));
            gap
        };
        (0..self.boxes.len()).into_par_iter().map(|f| of(FaceId::new(f))).collect::<Vec<_>>().into()
    }

    fn view(&self, face: FaceId, reach: f32) -> View {
        let normal = self.normal(face);
        let (u, v) = normal.try_normalize().unwrap_or(Vec3::Z).any_orthonormal_pair();
        let range = |axis| {
            let (low, high) = self.range(face, axis);
            (axis, low, high)
        };
        View { face, normal, across: [range(u), range(v)], heights: self.range(face, normal), reach }
    }

    /// The children's points: corners, middles and the centre, which comes with the last corner.
    fn samples(&self, face: FaceId) -> impl Iterator<Item = Vec3> {
        let last = self.level.topology.faces.range(face).len() - 1;
        self.quads(face).enumerate().flat_map(move |(i, q)| q.into_iter().take(if i == last { 3 } else { 2 }))
    }

    fn range(&self, face: FaceId, axis: Vec3) -> (f32, f32) {
        let heights = self.samples(face).map(|p| p.dot(axis));
        heights.fold((f32::MAX, f32::MIN), |(low, high), h| (low.min(h), high.max(h)))
    }

    /// Whether a face is not over or under the one that is seen.
    fn is_beside(&self, view: &View, other: FaceId) -> bool {
        let bounds = &self.boxes[other];
        let (middle, half) = (0.5 * (bounds.low + bounds.high), 0.5 * (bounds.high - bounds.low));
        let boxes_part = |&(axis, low, high): &(Vec3, f32, f32)| {
            let (at, radius) = (middle.dot(axis), half.dot(axis.abs()));
            at + radius <= low || at - radius >= high
        };
        let parts = |&(axis, low, high): &(Vec3, f32, f32)| {
            let (from, to) = self.range(other, axis);
            to <= low || from >= high
        };
        view.across.iter().any(boxes_part) || view.across.iter().any(parts)
    }

    /// Narrows the gap of a face to what another leaves of it.
    fn narrow(&self, view: &View, other: FaceId, gap: &mut Gap) {
        let (faces, normal, face) = (&self.level.topology.faces, view.normal, view.face);
        if face == other || self.is_beside(view, other) {
            return;
        }
        let touch = faces.vertices_of(face).iter().any(|v| faces.vertices_of(other).contains(v));
        if touch && normal.dot(self.normal(other)) > FOLDED {
            return;
        }
        // Nearer ones are known on both sides.
        let ((low, high), (from, to)) = (view.heights, self.range(other, normal));
        if from - high > gap[1].min(view.reach) || low - to > gap[0].min(view.reach) {
            return;
        }
        let size = (self.boxes[face].high - self.boxes[face].low).max_element();
        let least = if touch { SHARED * size } else { 0.0 };
        let mut take = |height: f32| {
            if height.abs() >= least {
                let side = usize::from(height > 0.0);
                gap[side] = gap[side].min(height.abs());
            }
        };
        // From the points of each face to the other one, as either may have the finer ones.
        for p in self.samples(face) {
            self.quads(other).filter_map(|q| height_of(p, normal, q)).for_each(&mut take);
        }
        for p in self.samples(other) {
            self.quads(face).filter_map(|q| height_of(p, normal, q)).for_each(|h| take(-h));
        }
    }
}

/// How far along `direction` it is from `p` to a quad, if it is there.
fn height_of(p: Vec3, direction: Vec3, [a, b, c, d]: [Vec3; 4]) -> Option<f32> {
    [[a, b, c], [a, c, d]].into_iter().find_map(|[a, b, c]| {
        let normal = (b - a).cross(c - a);
        let slope = normal.dot(direction);
        if slope.abs() < 1e-2 * normal.length() {
            return None;
        }
        let height = (a - p).dot(normal) / slope;
        let x = p + height * direction;
        let inside = |u: Vec3, v: Vec3| (v - u).cross(x - u).dot(normal) >= -1e-6 * normal.length_squared();
        (inside(a, b) && inside(b, c) && inside(c, a)).then_some(height)
    })
}
