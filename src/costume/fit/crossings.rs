//! Where the triangles of a cage cross a body or each other.

use super::bodies::Bodies;
use super::cage::Cage;
use super::triangle::{aabb, cross};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::BTreeSet;
use tailor::contact::{NearestSearch, WorkLimit};
use tailor_mesh::connectivity::{Elements, FaceId};

/// Elements in a hierarchy of boxes.
pub fn search<const N: usize>(elements: &[[usize; N]], points: &[DVec3]) -> NearestSearch {
    NearestSearch::new(&elements.iter().map(|e| aabb(&e.map(|v| points[v]))).collect::<Vec<_>>())
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
    /// Finds where a cage at `points` crosses a body in a shape, and itself. Incomplete beyond the bound of `work`.
    pub fn of(cage: &Cage, points: &[DVec3], bodies: &Bodies, shape: &[DVec3], work: &WorkLimit) -> Self {
        let (of_body, of_cage) = (search(&bodies.triangles, shape), search(&cage.triangles, points));
        let corners = |t: usize| cage.triangles[t].map(|v| points[v]);
        let with_body = |t: usize| {
            let own = corners(t);
            let near = of_body.intersecting(&aabb(&own), work).into_iter();
            near.filter(move |&b| cross(own, bodies.triangles[b].map(|v| shape[v]))).map(move |b| [t, b])
        };
        let share_vertex = |t: usize, o: usize| cage.triangles[o].iter().any(|v| cage.triangles[t].contains(v));
        let with_own = |t: usize| {
            let own = corners(t);
            let others =
                of_cage.intersecting(&aabb(&own), work).into_iter().filter(move |&o| o > t && !share_vertex(t, o));
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
    /// All of them.
    pub fn elements(&self) -> Elements {
        let all: BTreeSet<usize> = self.body.iter().chain(self.own.iter().flatten()).copied().collect();
        Elements::Faces(all.into_iter().map(FaceId::new).collect())
    }

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
