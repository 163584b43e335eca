//! Elements of a cage that are near a body or near another part of the cage.
//!
//! Cage and body are one list of points here: first those of the cage, which move, then those of the body, which are given. Gaps
//! between elements are linear near where they are: a point and the plane of a triangle, or two edges and the direction across both.

use super::cage::Cage;
use super::crossings::{CrossingFaces, search};
use super::rigid::Limit;
use super::triangle::{aabb, at, between, closest_shares, closest_weights};
use glam::DVec3;
use rayon::prelude::*;
use std::vec::IntoIter;
use tailor::contact::{NearestSearch, WorkLimit};

/// Contacts of one element at most, the nearest ones. Others hold nothing that these do not.
const MOST_CONTACTS: usize = 32;

/// Two elements that may not pass each other, and how they are where they were found.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    pub vertices: [usize; 4],
    /// The weight of each vertex in the way from the second element to the first.
    weights: [f64; 4],
    /// The direction of that way.
    normal: DVec3,
    pub distance: f64,
}

impl Contact {
    fn new(vertices: [usize; 4], weights: [f64; 4], away: DVec3, reach: f64) -> Option<Self> {
        let distance = away.length();
        let is_near = distance < reach && distance > 0.0;
        is_near.then(|| Self { vertices, weights, normal: away / distance, distance })
    }

    fn of_point(point: usize, [a, b, c]: [usize; 3], points: &[DVec3], reach: f64) -> Option<Self> {
        let corners = [a, b, c].map(|v| points[v]);
        let weights = closest_weights(corners, points[point]);
        let all = [1.0, -weights.x, -weights.y, -weights.z];
        Self::new([point, a, b, c], all, points[point] - at(corners, weights), reach)
    }

    fn of_edges([a, b]: [usize; 2], [c, d]: [usize; 2], points: &[DVec3], reach: f64) -> Option<Self> {
        let [s, t] = closest_shares([a, b].map(|v| points[v]), [c, d].map(|v| points[v]))?;
        let away = points[a].lerp(points[b], s) - points[c].lerp(points[d], t);
        Self::new([a, b, c, d], [1.0 - s, s, t - 1.0, -t], away, reach)
    }

    /// As a limit of the first `count` points, with the others where `points` has them.
    pub fn limit(&self, points: &[DVec3], count: usize, least: f64) -> Limit {
        let mut limit = Limit { terms: [(0, 0.0); 4], normal: self.normal, constant: -least };
        for (k, (v, weight)) in self.vertices.into_iter().zip(self.weights).enumerate() {
            if v < count {
                limit.terms[k] = (v, weight);
            } else {
                limit.constant += weight * self.normal.dot(points[v]);
            }
        }
        limit
    }
}

/// The limits that keep two triangles apart: each corner of the first stays above all corners of the second, along the direction in
/// which the triangles are nearest to each other at `near`.
pub fn apart(
    [first, second]: [[usize; 3]; 2],
    near: &[DVec3],
    points: &[DVec3],
    count: usize,
    least: f64,
) -> impl Iterator<Item = Limit> {
    let away = between(first.map(|v| near[v]), second.map(|v| near[v]));
    let corners = first.into_iter().flat_map(move |a| second.into_iter().map(move |b| [a, b]));
    corners.filter_map(move |[a, b]| {
        let (vertices, weights) = ([a, b, 0, 0], [1.0, -1.0, 0.0, 0.0]);
        Some(Contact::new(vertices, weights, away, f64::INFINITY)?.limit(points, count, least))
    })
}

/// Elements of a surface.
pub struct Elements {
    pub vertices: Vec<usize>,
    pub edges: Vec<[usize; 2]>,
    pub triangles: Vec<[usize; 3]>,
}

/// The contacts of elements of a cage with a body, within the reach of each vertex of the cage. Incomplete beyond the bound of
/// `work`.
pub fn with_body(cage: &Elements, body: &Elements, points: &[DVec3], reach: &[f64], work: &WorkLimit) -> Vec<Contact> {
    let most = reach.iter().copied().fold(0.0, f64::max);
    let (triangles, edges) = (search(&body.triangles, points), search(&body.edges, points));
    let own = search(&cage.triangles, points);
    let of_point = |&v: &usize| {
        let near = near(&triangles, &[points[v]], reach[v], work);
        nearest(near.filter_map(|t| Contact::of_point(v, body.triangles[t], points, reach[v])))
    };
    let of_body_point = |&v: &usize| {
        let near = near(&own, &[points[v]], most, work).map(|t| cage.triangles[t]);
        nearest(near.filter_map(|t| Contact::of_point(v, t, points, least(reach, &t))))
    };
    let of_edge = |&edge: &[usize; 2]| {
        let reach = least(reach, &edge);
        let near = near(&edges, &edge.map(|v| points[v]), reach, work);
        nearest(near.filter_map(|b| Contact::of_edges(edge, body.edges[b], points, reach)))
    };
    let mut all: Vec<Contact> = cage.vertices.par_iter().flat_map_iter(of_point).collect();
    all.par_extend(body.vertices.par_iter().flat_map_iter(of_body_point));
    all.par_extend(cage.edges.par_iter().flat_map_iter(of_edge));
    all
}

/// The contacts of a cage with itself, of elements without a common vertex whose faces did not cross before. Incomplete beyond the
/// bound of `work`.
pub fn with_itself(
    cage: &Cage,
    points: &[DVec3],
    reach: &[f64],
    before: &CrossingFaces,
    work: &WorkLimit,
) -> Vec<Contact> {
    let (triangles, edges) = (search(&cage.triangles, points), search(&cage.edges, points));
    let crossed = |a: &[usize], b: &[usize]| {
        let have_crossed = |f: usize| cage.faces_of(b).all(|g| before.own.contains(&[f.min(g), f.max(g)]));
        !before.own.is_empty() && cage.faces_of(a).all(have_crossed)
    };
    let may_touch = |a: &[usize], b: &[usize]| !a.iter().any(|v| b.contains(v)) && !crossed(a, b);
    let of_point = |v: usize| {
        let near = near(&triangles, &[points[v]], reach[v], work).map(|t| cage.triangles[t]);
        let near = near.filter(|t| may_touch(&[v], t));
        nearest(near.filter_map(|t| Contact::of_point(v, t, points, reach[v].min(least(reach, &t)))))
    };
    let of_edge = |e: usize| {
        let (edge, own) = (cage.edges[e], least(reach, &cage.edges[e]));
        let near = near(&edges, &edge.map(|v| points[v]), own, work).filter(|&o| o > e);
        let near = near.map(|o| cage.edges[o]).filter(|o| may_touch(&edge, o));
        nearest(near.filter_map(|o| Contact::of_edges(edge, o, points, own.min(least(reach, &o)))))
    };
    let mut all: Vec<Contact> = (0..points.len()).into_par_iter().flat_map_iter(of_point).collect();
    all.par_extend((0..cage.edges.len()).into_par_iter().flat_map_iter(of_edge));
    all
}

/// The elements whose boxes some points come within a reach of, ascending.
fn near(all: &NearestSearch, points: &[DVec3], reach: f64, work: &WorkLimit) -> IntoIter<usize> {
    all.intersecting(&aabb(points).expanded(reach as f32), work).into_iter()
}

/// The nearest contacts of one element.
fn nearest(contacts: impl Iterator<Item = Contact>) -> Vec<Contact> {
    let mut all: Vec<Contact> = contacts.collect();
    if all.len() > MOST_CONTACTS {
        all.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        all.truncate(MOST_CONTACTS);
    }
    all
}

/// The least reach of some vertices.
fn least(reach: &[f64], vertices: &[usize]) -> f64 {
    vertices.iter().map(|&v| reach[v]).fold(f64::INFINITY, f64::min)
}
