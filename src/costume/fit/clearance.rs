//! How near a cage may come to a body and to itself.

use super::bodies::Bodies;
use super::cage::Cage;
use super::contacts::{Contact, Elements, with_body, with_itself};
use super::crossings::{CrossingFaces, Crossings};
use super::rigid::Limit;
use glam::DVec3;
use tailor::contact::WorkLimit;

/// Reach of contacts with the body and with the cage, as shares of the mean edge at a vertex. Less misses what comes near in a
/// step; more slows.
const REACH: [f64; 2] = [0.5, 0.4];
/// Share of the distance at the start that is kept, and its bounds as shares of the mean edge.
const KEPT: f64 = 0.6;
const MOST: f64 = 0.15;
const LEAST: f64 = 2e-3;

/// The limits of a cage: the elements that it may not pass, and how near it may come to them.
pub struct Clearance<'a> {
    cage: &'a Cage,
    bodies: &'a Bodies,
    /// Faces that cross at the start, and others that could not follow: they are not held.
    released: CrossingFaces,
    /// The mean edge at each vertex.
    pub edge: Vec<f64>,
    /// The distance of the elements at each vertex from the body and from other parts of the cage, at the start.
    distance: [Vec<f64>; 2],
    /// The share of its room that each vertex has kept where there was less.
    squeeze: Vec<f64>,
    /// Elements of the body, among the points of both.
    pub body: Elements,
    /// Elements of faces that are held off the body.
    free: Elements,
}

impl Elements {
    /// The elements of a body, among the points of both after `count` of a cage. Points that no face has are not in the way.
    pub fn of_body(bodies: &Bodies, count: usize) -> Self {
        let mut is_used = vec![false; bodies.from.len()];
        bodies.triangles.iter().flatten().for_each(|&v| is_used[v] = true);
        Self {
            vertices: (0..is_used.len()).filter(|&v| is_used[v]).map(|v| count + v).collect(),
            edges: bodies.edges.iter().map(|e| e.map(|v| count + v)).collect(),
            triangles: bodies.triangles.iter().map(|t| t.map(|v| count + v)).collect(),
        }
    }

    /// The elements of a cage that have a face which does not cross the body.
    pub fn free(cage: &Cage, crossing: &CrossingFaces) -> Self {
        let is_free = |vertices: &[usize]| cage.faces_of(vertices).any(|f| !crossing.body.contains(&f));
        Self {
            vertices: (0..cage.vertex_count()).filter(|&v| is_free(&[v])).collect(),
            edges: cage.edges.iter().copied().filter(|e| is_free(e)).collect(),
            triangles: cage.triangles.iter().copied().filter(|t| is_free(t)).collect(),
        }
    }
}

impl<'a> Clearance<'a> {
    /// The clearance at the start. Incomplete beyond the bound of `work`, as all of its searches are.
    pub fn new(cage: &'a Cage, rest: &[DVec3], bodies: &'a Bodies, work: &WorkLimit) -> Self {
        let count = rest.len();
        let released = Crossings::of(cage, rest, bodies, &bodies.from, work).faces(cage);
        let body = Elements::of_body(bodies, count);
        let distance = [(); 2].map(|()| vec![f64::INFINITY; count]);
        let edge = cage.mean_edges(rest);
        let free = Elements::free(cage, &released);
        let mut clearance = Self { cage, bodies, released, edge, distance, squeeze: vec![1.0; count], body, free };
        let contacts = clearance.contacts(&[rest, &bodies.from].concat(), 1.0, work);
        for (distance, contacts) in clearance.distance.iter_mut().zip(contacts) {
            for contact in contacts {
                let own = contact.vertices.into_iter().filter(|&v| v < count);
                own.for_each(|v| distance[v] = distance[v].min(contact.distance));
            }
        }
        clearance
    }

    /// Contacts with the body and of the cage with itself, of the points of both. `scale` is that of the cage.
    pub fn contacts(&self, points: &[DVec3], scale: f64, work: &WorkLimit) -> [Vec<Contact>; 2] {
        let reach: Vec<f64> = self.edge.iter().map(|edge| scale * REACH[1] * edge).collect();
        let with_body = with_body(&self.free, &self.body, points, &reach_of_body(&self.edge), work);
        let own = &points[..self.edge.len()];
        [with_body, with_itself(self.cage, own, &reach, &self.released, work)]
    }

    /// The contacts as limits, with the body where it is in a shape.
    pub fn limits(&self, contacts: &[Vec<Contact>; 2], shape: &[DVec3], scale: f64) -> Vec<Limit> {
        let count = self.edge.len();
        let points = [&vec![DVec3::ZERO; count], shape].concat();
        let limits = |kind: usize, scale: f64| {
            let limit = |contact: &Contact| contact.limit(&points, count, scale * self.least(contact, kind));
            contacts[kind].iter().map(limit).collect::<Vec<_>>()
        };
        [limits(0, 1.0), limits(1, scale)].concat()
    }

    /// The least gap of a contact.
    fn least(&self, contact: &Contact, kind: usize) -> f64 {
        let of_vertex = |v: usize| {
            let edge = self.edge[v];
            let kept = (KEPT * self.distance[kind][v]).min(MOST * edge);
            (self.squeeze[v] * kept).max(LEAST * edge)
        };
        contact.vertices.into_iter().filter(|&v| v < self.edge.len()).map(of_vertex).fold(f64::INFINITY, f64::min)
    }

    /// Takes half of their room from the vertices of limits that could not be kept: these contradict each other.
    pub fn squeeze(&mut self, limits: &[Limit], points: &[DVec3]) {
        let mut is_squeezed = vec![false; points.len()];
        for limit in limits {
            let vertices = || limit.terms.into_iter().filter(|term| term.1 != 0.0).map(|term| term.0);
            let edge = vertices().map(|v| self.edge[v]).fold(f64::INFINITY, f64::min);
            if limit.value(points) < -0.05 * LEAST * edge {
                vertices().for_each(|v| is_squeezed[v] = true);
            }
        }
        let squeezed = self.squeeze.iter_mut().zip(is_squeezed).filter(|(_, is)| *is);
        squeezed.for_each(|(squeeze, _)| *squeeze *= 0.5);
    }

    /// The gap that is kept beside a triangle which has crossed.
    pub fn least_of(&self, triangle: usize) -> f64 {
        LEAST * self.cage.triangles[triangle].iter().map(|&v| self.edge[v]).fold(f64::INFINITY, f64::min)
    }

    /// The triangles that cross, of faces that are held.
    pub fn held_crossings(&self, points: &[DVec3], shape: &[DVec3], work: &WorkLimit) -> Crossings {
        Crossings::of(self.cage, points, self.bodies, shape, work).without(&self.released, self.cage)
    }

    /// Holds faces no longer.
    pub fn release(&mut self, faces: CrossingFaces) {
        self.released.add(faces);
        self.free = Elements::free(self.cage, &self.released);
    }
}

/// How far contacts with a body reach, by the mean edge at each vertex.
pub fn reach_of_body(edges: &[f64]) -> Vec<f64> {
    edges.iter().map(|edge| REACH[0] * edge).collect()
}
