//! Cages whose limit surface is where it was asked to be, without the waves of an exact fit.
//!
//! A cage that interpolates given limits swings between lines that lie close together on one side and far apart on the
//! other. So the cage is moved by what its limit is off, a few times over (Richardson's iteration): that is exact where
//! the error is even, as along a seam or a layer, and leaves alone what changes from one vertex to the next.
//!
//! Heights are all to one side, so that a layer stays on its side of the other one: the limit of the difference is a mean
//! of what the vertices differ by.

use super::derivation::Table;
use super::shape::{Held, Role};
use crate::mesh::{EdgeId, IdVec, VertexId};
use glam::Vec3;
use rayon::prelude::*;

/// Steps to the surface as it was. More come nearer to it, and make more waves.
const BASE_STEPS: usize = 2;
/// How many times its neighbour's height one may be further, over one less the cosine between their normals.
const EVEN: f32 = 0.5;
/// Sweeps that make heights even.
const GRADES: usize = 4;
/// Part of an edge's length by which the moves of its ends may differ.
const MOST_BEND: f32 = 0.5;
/// Steps to the heights.
const HEIGHT_STEPS: usize = 4;
/// Least part of a limit that raised vertices are taken to have.
const LEAST_PART: f32 = 0.4;
/// How much of the way back to its place the centre of a seam goes. All of it would bend the lines beside a turn.
const CENTRED: f32 = 0.7;
/// Part of an edge's length that a fold of the surface may take from it on the second layer. Larger lets the layer come
/// closer to crossing itself.
const MOST_SHRUNK: f32 = 0.7;
/// How much of its height a vertex has at least and at most, to have that height in the limit.
const LIFT: [f32; 2] = [0.7, 2.0];

/// The held vertices of a cage.
pub struct Settling<'a> {
    /// The vertices.
    pub held: &'a [Held],
    /// Limit rows of all vertices.
    pub rows: &'a Table<VertexId>,
    /// The one from whose limit each is measured.
    pub from: &'a [usize],
    /// The edges of the cage.
    pub edges: &'a IdVec<EdgeId, [VertexId; 2]>,
}

/// How far a vertex is to be from where it was.
#[derive(Clone, Copy, Debug)]
pub struct Raise {
    /// In this direction.
    pub normal: Vec3,
    /// This far in the limit.
    pub height: f32,
    /// Whether it may not be further on the cage either, for want of room.
    pub is_least: bool,
}

impl Settling<'_> {
    fn row(&self, held: usize) -> &[(VertexId, f32)] {
        self.rows.at(self.held[held].vertex.index())
    }

    fn limit(&self, held: usize, points: &IdVec<VertexId, Vec3>) -> Vec3 {
        self.row(held).iter().map(|&(v, w)| w * points[v]).sum()
    }

    /// Moves the vertices so that their limits are near `targets` (place and normal).
    pub fn base(&self, targets: &[(Vec3, Vec3)], linear: &IdVec<VertexId, Vec3>) -> IdVec<VertexId, Vec3> {
        let mut points = linear.clone();
        for _ in 0..BASE_STEPS {
            let step = |i: usize, points: &_| {
                let off = targets[i].0 - self.limit(i, points);
                match self.held[i].role {
                    Role::Layer { .. } => Vec3::ZERO,
                    Role::Fold => off,
                    Role::Centre { .. } => CENTRED * off + (1.0 - CENTRED) * off.dot(targets[i].1) * targets[i].1,
                    _ => off.dot(targets[i].1) * targets[i].1,
                }
            };
            self.move_by(step, &mut points);
            self.copy(&mut points);
        }
        self.calm(linear, &mut points);
        self.copy(&mut points);
        points
    }

    /// Puts copies on what they are copies of.
    fn copy(&self, points: &mut IdVec<VertexId, Vec3>) {
        for held in self.held {
            if let Role::Layer { over, .. } = held.role {
                points[held.vertex] = points[over];
            }
        }
    }

    /// Takes back moves that differ too much from their neighbours', which would turn faces between close lines.
    fn calm(&self, linear: &IdVec<VertexId, Vec3>, points: &mut IdVec<VertexId, Vec3>) {
        let mut share = IdVec::filled(1.0f32, points.len());
        for &[a, b] in self.edges.iter() {
            let bend = ((points[a] - linear[a]) - (points[b] - linear[b])).length();
            let most = MOST_BEND * linear[a].distance(linear[b]);
            if bend > most && most > 0.0 {
                [a, b].into_iter().for_each(|v| share[v] = share[v].min(most / bend));
            }
        }
        for (vertex, &share) in share.enumerated().filter(|(_, s)| **s < 1.0) {
            points[vertex] = linear[vertex].lerp(points[vertex], share);
        }
    }

    /// Moves copies so that their limits are where those are of what they are copies of, and never between the two.
    pub fn aligned(&self, targets: &[(Vec3, Vec3)], mut points: IdVec<VertexId, Vec3>) -> IdVec<VertexId, Vec3> {
        for _ in 0..BASE_STEPS {
            let step = |i: usize, points: &_| match self.held[i].role {
                Role::Layer { side, .. } if self.from[i] != i => {
                    let off = (self.limit(self.from[i], points) - self.limit(i, points)).dot(targets[i].1);
                    // Towards the layer that it is a copy of it would meet it between the vertices.
                    (side * (side * off).max(0.0)) * targets[i].1
                }
                _ => Vec3::ZERO,
            };
            self.move_by(step, &mut points);
        }
        points
    }

    fn move_by(
        &self,
        step: impl Fn(usize, &IdVec<VertexId, Vec3>) -> Vec3 + Send + Sync,
        points: &mut IdVec<VertexId, Vec3>,
    ) {
        let steps: Vec<Vec3> = (0..self.held.len()).into_par_iter().map(|i| step(i, points)).collect();
        self.held.iter().zip(&steps).filter(|(_, s)| s.is_finite()).for_each(|(h, &s)| points[h.vertex] += s);
    }

    /// Raises the vertices until their limits are as far as asked from the surface, or from where their limits are
    /// without heights.
    pub fn raised(
        &self,
        targets: &[(Vec3, Vec3)],
        raises: &[Raise],
        base: &IdVec<VertexId, Vec3>,
    ) -> IdVec<VertexId, Vec3> {
        let raised: Vec<usize> = (0..raises.len()).filter(|&i| raises[i].height != 0.0).collect();
        let mut moves = IdVec::filled(false, base.len());
        raised.iter().for_each(|&i| moves[self.held[i].vertex] = true);
        let prepare = |&i: &usize| {
            let from = match self.held[i].role {
                Role::Layer { .. } => self.limit(i, base),
                _ => targets[i].0,
            };
            let part = self.row(i).iter().filter(|(v, _)| moves[*v]).map(|(_, w)| w).sum::<f32>();
            (from.dot(raises[i].normal) + raises[i].height, part.max(LEAST_PART))
        };
        let wanted: Vec<(f32, f32)> = raised.par_iter().map(prepare).collect();
        let mut lifts: Vec<f32> = raised.iter().map(|&i| raises[i].height).collect();
        let mut points = base.clone();
        for step in 0..=HEIGHT_STEPS {
            for (&i, &lift) in raised.iter().zip(&lifts) {
                points[self.held[i].vertex] = base[self.held[i].vertex] + lift * raises[i].normal;
            }
            if step < HEIGHT_STEPS {
                let next = |((&i, &(height, part)), &lift): ((&usize, &(f32, f32)), &f32)| {
                    let off = height - self.limit(i, &points).dot(raises[i].normal);
                    let next = lift + off / part;
                    if matches!(self.held[i].role, Role::Layer { .. }) { raises[i].clamped(next) } else { next }
                };
                lifts = raised.par_iter().zip(&wanted).zip(&lifts).map(next).collect();
            }
        }
        points
    }
}

/// Lowers heights at the ends of edges that would be too short, or the other way round, where the surface folds towards
/// the second layer. `targets` are places and normals.
pub fn unfolded(heights: &mut [f32], edges: &[[usize; 2]], targets: &[(Vec3, Vec3)]) {
    for &[a, b] in edges {
        let ((p, n), (q, m)) = (targets[a], targets[b]);
        let turn = (m - n).dot(q - p);
        let most = MOST_SHRUNK * p.distance_squared(q) / turn.abs();
        for i in [a, b] {
            if heights[i] * turn < 0.0 {
                heights[i] = heights[i].abs().min(most).copysign(heights[i]);
            }
        }
    }
}

/// Lowers heights that are much larger than those beside them: on a mean of directions that differ, the largest decides.
pub fn graded(raises: &mut [Raise], edges: &[[usize; 2]]) {
    for _ in 0..GRADES {
        let mut is_even = true;
        for &[a, b] in edges {
            if raises[a].height == 0.0 || raises[b].height == 0.0 {
                continue;
            }
            let turn = 1.0 - raises[a].normal.dot(raises[b].normal);
            let most = 1.0 + EVEN / turn.max(1e-3);
            for (low, high) in [(a, b), (b, a)] {
                let limit = most * raises[low].height.abs();
                if raises[high].height.abs() > limit {
                    raises[high].height = raises[high].height.signum() * limit;
                    raises[high].is_least = true;
                    is_even = false;
                }
            }
        }
        if is_even {
            break;
        }
    }
}

impl Raise {
    fn clamped(&self, lift: f32) -> f32 {
        let [least, most] = if self.is_least { [LIFT[0], 1.0] } else { LIFT };
        let (a, b) = (least * self.height, most * self.height);
        if lift.is_finite() { lift.clamp(a.min(b), a.max(b)) } else { self.height }
    }
}
