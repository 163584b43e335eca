//! Where the triangles of a cage cross a body or each other.

use super::bodies::Bodies;
use super::cage::Cage;
use super::triangle::{aabb, cross};
use glam::{DVec3, Vec3A};
use rayon::prelude::*;
use std::collections::BTreeSet;
use tailor::contact::{Aabb, Bvh, morton_sorted};

/// Elements in a hierarchy of boxes.
pub struct Boxes {
    order: Vec<usize>,
    tree: Bvh,
}

impl Boxes {
    pub fn new<const N: usize>(elements: &[[usize; N]], points: &[DVec3]) -> Self {
        let boxes: Vec<Aabb> = elements.iter().map(|e| aabb(&e.map(|v| points[v]))).collect();
        let centres: Vec<Vec3A> = boxes.iter().map(|b| 0.5 * b.low + 0.5 * b.high).collect();
        let order = morton_sorted(&centres);
        let tree = Bvh::new(boxes.len(), |slot| boxes[order[slot]]);
        Self { order, tree }
    }

    /// The elements whose boxes some points come within a reach of, ascending.
    pub fn near(&self, points: &[DVec3], reach: f64) -> Vec<usize> {
        let mut found = Vec::new();
        self.tree.visit_while(&aabb(points).expanded(reach as f32), &mut |slot| {
            found.push(self.order[slot]);
            true
        });
        found.sort_unstable();
        found
    }
}

/// Triangles that cross.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Crossings {
    /// Triangles of the cage and of the body.
    pub body: Vec<[usize; 2]>,
    /// Triangles of two faces of the cage without a common vertex, the lower one first.
    pub own: Vec<[usize; 2]>,
}

impl Crossings {
    /// Finds where a cage at `points` crosses a body in a shape, and itself.
    pub fn of(cage: &Cage, points: &[DVec3], bodies: &Bodies, shape: &[DVec3]) -> Self {
        let (of_body, of_cage) = (Boxes::new(&bodies.triangles, shape), Boxes::new(&cage.triangles, points));
        let corners = |t: usize| cage.triangles[t].map(|v| points[v]);
        let with_body = |t: usize| {
            let own = corners(t);
            let near = of_body.near(&own, 0.0).into_iter();
            near.filter(move |&b| cross(own, bodies.triangles[b].map(|v| shape[v]))).map(move |b| [t, b])
        };
        let share_vertex = |t: usize, o: usize| cage.triangles[o].iter().any(|v| cage.triangles[t].contains(v));
        let with_own = |t: usize| {
            let own = corners(t);
            let others = of_cage.near(&own, 0.0).into_iter().filter(move |&o| o > t && !share_vertex(t, o));
            others.filter(move |&o| cage.face[o] != cage.face[t] && cross(own, corners(o))).map(move |o| [t, o])
        };
        let count = cage.triangles.len();
        Self {
            body: (0..count).into_par_iter().flat_map_iter(with_body).collect(),
            own: (0..count).into_par_iter().flat_map_iter(with_own).collect(),
        }
    }

    /// The faces of the cage that cross the body, and the pairs of faces that cross each other.
    pub fn faces(&self, cage: &Cage) -> CrossingFaces {
        CrossingFaces {
            body: self.body.iter().map(|&[t, _]| cage.face[t]).collect(),
            own: self.own.iter().map(|&pair| cage.pair_of(pair)).collect(),
        }
    }

    /// Leaves out triangles of faces that have crossed before.
    pub fn without(mut self, before: &CrossingFaces, cage: &Cage) -> Self {
        self.body.retain(|&[t, _]| !before.body.contains(&cage.face[t]));
        self.own.retain(|&pair| !before.own.contains(&cage.pair_of(pair)));
        self
    }

    pub fn is_empty(&self) -> bool {
        self.body.is_empty() && self.own.is_empty()
    }
}

impl CrossingFaces {
    /// Adds others.
    pub fn add(&mut self, others: Self) {
        self.body.extend(others.body);
        self.own.extend(others.own);
    }
}

/// Faces of a cage that cross.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CrossingFaces {
    /// Faces that cross the body.
    pub body: BTreeSet<usize>,
    /// Pairs that cross each other, the lower one first.
    pub own: BTreeSet<[usize; 2]>,
}
