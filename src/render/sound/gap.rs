//! How far it is from each face of a cage to the next layer.

use super::lanes::each;
use super::piece::{Cell, Piece, samples};
use super::skin::Skin;
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

/// A face seen along its normal, in a frame whose last axis is the normal.
struct View<'a> {
    piece: &'a Piece,
    axes: [Vec3; 3],
    cells: Vec<Cell>,
    points: Vec<Vec3>,
    /// Their range along each axis.
    range: Bounds,
}

impl View<'_> {
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
        let tree = Tree::new(self.pieces.len(), |place| self.pieces[place].bounds);
        let of = |piece: &Piece| {
            let (mut gap, view, mut cells) = (OPEN, self.view(piece), Vec::new());
            let around = piece.bounds.grown(reach);
            tree.visit(&around, &mut |other| self.narrow(&view, &self.pieces[other], reach, &mut cells, &mut gap));
            gap
        };
        let found: Vec<Gap> = self.pieces.par_iter().map(of).collect();
        let mut gaps = IdVec::filled(OPEN, found.len());
        self.pieces.iter().zip(found).for_each(|(piece, gap)| gaps[piece.face] = gap);
        gaps
    }

    fn view<'p>(&self, piece: &'p Piece) -> View<'p> {
        let (u, v) = piece.normal.try_normalize().unwrap_or(Vec3::Z).any_orthonormal_pair();
        let axes = [u, v, piece.normal];
        let cells: Vec<Cell> = self.cells(piece).map(|cell| cell.within(&axes)).collect();
        View { piece, axes, points: samples(cells.iter()).collect(), range: range(&cells), cells }
    }

    /// Narrows the gap of a face to what another leaves of it, whose cells in the face's frame go to `cells`.
    fn narrow(&self, view: &View, other: &Piece, reach: f32, cells: &mut Vec<Cell>, gap: &mut Gap) {
        if view.piece.face == other.face || view.is_beside(&other.bounds) {
            return;
        }
        let touch = self.touch(view.piece, other);
        if touch && view.axes[2].dot(other.normal) > FOLDED {
            return;
        }
        cells.clear();
        cells.extend(self.cells(other).map(|cell| cell.within(&view.axes)));
        let (own, its) = (view.range, range(cells));
        // Nearer ones are known on both sides.
        let is_far = its.low.z - own.high.z > gap[1].min(reach) || own.low.z - its.high.z > gap[0].min(reach);
        if is_far || (0..2).any(|i| its.high[i] <= own.low[i] || its.low[i] >= own.high[i]) {
            return;
        }
        let size = (view.piece.bounds.high - view.piece.bounds.low).max_element();
        let least = if touch { SHARED * size } else { 0.0 };
        let mut take = |height: f32| {
            if height.abs() >= least {
                let side = usize::from(height > 0.0);
                gap[side] = gap[side].min(height.abs());
            }
        };
        // From the points of each face to the other one, as either may have the finer ones.
        heights_over(&view.points.iter().copied(), cells, &mut take);
        heights_over(&samples(cells.iter()), &view.cells, &mut |height| take(-height));
    }
}

/// The box of cells.
fn range(cells: &[Cell]) -> Bounds {
    cells.iter().map(|cell| cell.boxes().whole()).fold(Bounds::EMPTY, |all, b| all.and(&b))
}

/// How far it is along the last axis from each of `points` to the children over and under it.
fn heights_over(points: &(impl Iterator<Item = Vec3> + Clone), children: &[Cell], take: &mut impl FnMut(f32)) {
    for cell in children {
        let boxes = cell.boxes();
        for p in points.clone() {
            let there = each(boxes.that_have(p) & cell.all());
            there.filter_map(|child| height_of(p, cell.quad(child))).for_each(&mut *take);
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
