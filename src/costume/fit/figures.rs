//! How well a garment fits.

use super::bodies::Bodies;
use super::bound::BoundPoints;
use super::cage::Cage;
use super::clearance::reach_of_body;
use super::contacts::{Elements, with_body};
use super::crossings::{CrossingFaces, Crossings};
use super::path::Path;
use super::{SEARCH_PART, work_limit};
use glam::DVec3;
use serde::Serialize;
use std::collections::BTreeSet;
use tailor::contact::WorkLimit;
use tailor_mesh::connectivity::{CornerId, FaceId};
use tailor_mesh::garment::Mesh;

/// Change of an edge's length, against that of the body around it, up to which it counts as kept.
const KEPT: f64 = 0.15;
/// Angle below which a corner is a sliver. \[degrees\]
const SLIVER: f64 = 5.0;

/// How well a garment fits another body.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct FitFigures {
    /// Points that were moved.
    pub points: usize,
    /// Faces that cross the body.
    pub body_crossings: CrossingCount,
    /// Pairs of faces that cross each other.
    pub own_crossings: CrossingCount,
    /// Distances from the body. \[mesh units\]
    pub distance: BodyDistance,
    /// Share of the edges that changed their lengths by at most 15 % more or less than the body around them, along them.
    pub edges_kept: f64,
    /// The least, the mean and the largest length of edges, as a share of that before.
    pub lengths: [f64; 3],
    /// The mean change of the angles of faces, and that which 95 % of them do not pass. \[degrees\]
    pub angles: [f64; 2],
    /// The lengths of sets.
    pub sets: Vec<SetLengths>,
}

/// What crosses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct CrossingCount {
    /// On the body that the garment was made for.
    pub before: usize,
    /// On the other body.
    pub after: usize,
    /// Of these, those that did not cross before.
    pub new: usize,
}

impl CrossingCount {
    fn new<T: Ord>(before: &BTreeSet<T>, after: &BTreeSet<T>) -> Self {
        Self { before: before.len(), after: after.len(), new: after.difference(before).count() }
    }
}

/// Distances from a body before and after. \[mesh units\]
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct BodyDistance {
    /// The least distance of faces that do not cross the body; none if all are far from it.
    pub least: [Option<f64>; 2],
    /// The mean distance of the points.
    pub mean: [f64; 2],
}

/// The edges of a set.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SetLengths {
    /// Its name.
    pub name: String,
    /// Their length after, as a share of that before.
    pub length: f64,
    /// The change of the body along them.
    pub body: f64,
}

/// A garment on one of the bodies.
pub(super) struct OnBody<'a> {
    pub points: Vec<DVec3>,
    pub bound: BoundPoints<'a>,
    pub crossings: CrossingFaces,
    /// The least distance of faces that do not cross the body; none if all are far from it.
    least: Option<f64>,
    /// The work of its searches.
    pub work: WorkLimit,
}

impl<'a> OnBody<'a> {
    /// A cage at `points` on a shape of a body. `edges` are the mean edges at its vertices, which contacts are found by.
    pub fn new(cage: &Cage, edges: &[f64], points: Vec<DVec3>, bodies: &'a Bodies, shape: &[DVec3]) -> Self {
        let work = work_limit(cage, bodies, SEARCH_PART);
        let crossings = Crossings::of(cage, &points, bodies, shape, &work).faces(cage);
        let [free, body] = [Elements::free(cage, &crossings), Elements::of_body(bodies, points.len())];
        let near = with_body(&free, &body, &[&points, shape].concat(), &reach_of_body(edges), &work);
        let least = near.iter().map(|contact| contact.distance).reduce(f64::min);
        Self { bound: BoundPoints::new(bodies, shape, &points), crossings, points, least, work }
    }

    fn mean(&self) -> f64 {
        self.bound.distances().sum::<f64>() / self.points.len().max(1) as f64
    }
}

impl FitFigures {
    pub(super) fn new(mesh: &Mesh, path: &Path, start: &OnBody, end: &OnBody) -> Self {
        let (cage, points) = (path.cage, &end.points);
        let lengths = Lengths::new(path, points);
        let ratios = || lengths.before.iter().zip(&lengths.after).filter(|(b, _)| **b > 0.0).map(|(b, a)| a / b);
        Self {
            points: points.len(),
            body_crossings: CrossingCount::new(&start.crossings.body, &end.crossings.body),
            own_crossings: CrossingCount::new(&start.crossings.own, &end.crossings.own),
            distance: BodyDistance { least: [start.least, end.least], mean: [start.mean(), end.mean()] },
            edges_kept: lengths.kept(),
            lengths: [
                ratios().reduce(f64::min).unwrap_or(1.0),
                ratios().sum::<f64>() / ratios().count().max(1) as f64,
                ratios().reduce(f64::max).unwrap_or(1.0),
            ],
            angles: angles(mesh, path.rest, points),
            sets: mesh
                .subsets
                .iter()
                .filter_map(|set| lengths.of_set(&set.name, &cage.edges_in(&set.elements)))
                .collect(),
        }
    }
}

/// The lengths of the edges of a cage.
struct Lengths {
    before: Vec<f64>,
    after: Vec<f64>,
    /// As the body asks.
    wanted: Vec<f64>,
}

impl Lengths {
    fn new(path: &Path, points: &[DVec3]) -> Self {
        let of = |points: &[DVec3]| path.cage.edges.iter().map(|&[a, b]| points[a].distance(points[b])).collect();
        let wanted = path.stretched_edges(&path.bodies.to).iter().map(|edge| edge.length()).collect();
        Self { before: of(path.rest), after: of(points), wanted }
    }

    fn kept(&self) -> f64 {
        let is_kept = |(after, wanted): &(&f64, &f64)| (*after / *wanted - 1.0).abs() <= KEPT;
        let count = self.after.iter().zip(&self.wanted).filter(is_kept).count();
        count as f64 / self.after.len().max(1) as f64
    }

    fn of_set(&self, name: &str, is_in: &[bool]) -> Option<SetLengths> {
        let sum = |lengths: &[f64]| lengths.iter().zip(is_in).filter(|(_, is)| **is).map(|(l, _)| l).sum::<f64>();
        let before = sum(&self.before);
        let share = |lengths: &[f64]| sum(lengths) / before;
        (before > 0.0).then(|| SetLengths {
            name: name.to_owned(),
            length: share(&self.after),
            body: share(&self.wanted),
        })
    }
}

/// The angle of a corner of a face. \[degrees\]
fn angle(mesh: &Mesh, points: &[DVec3], corner: CornerId) -> f64 {
    let at = |c| points[mesh.faces.vertex(c).index()];
    let middle = at(corner);
    (at(mesh.faces.prev(corner)) - middle).angle_between(at(mesh.faces.next(corner)) - middle).to_degrees()
}

/// The faces with a corner that has become a sliver, each once, ascending.
pub fn slivers(mesh: &Mesh, before: &[DVec3], after: &[DVec3]) -> Vec<FaceId> {
    let is_new = |c: &CornerId| angle(mesh, after, *c) < SLIVER && angle(mesh, before, *c) >= SLIVER;
    let mut faces: Vec<FaceId> = mesh.faces.corners().ids().filter(is_new).map(|c| mesh.faces.face_of(c)).collect();
    faces.dedup();
    faces
}

/// The mean change of the angles of faces, and that of the 95th percentile. \[degrees\]
fn angles(mesh: &Mesh, before: &[DVec3], after: &[DVec3]) -> [f64; 2] {
    let change = |c| (angle(mesh, after, c) - angle(mesh, before, c)).abs();
    let changes = mesh.faces.corners().ids().map(change);
    let mut changes: Vec<f64> = changes.filter(|change| change.is_finite()).collect();
    changes.sort_unstable_by(f64::total_cmp);
    let count = changes.len().max(1);
    [changes.iter().sum::<f64>() / count as f64, changes.get(count * 95 / 100).copied().unwrap_or(0.0)]
}
