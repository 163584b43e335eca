//! A body in two shapes.

use super::bound::normals;
use super::cage::Cage;
use super::crossings::{CrossingFaces, Crossings};
use super::matching::{Place, bounds, by_pairs, by_uvs, same_faces};
use super::{SEARCH_PART, work_limit};
use crate::codes;
use glam::DVec3;
use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap};
use tailor_mesh::error::{Error, ErrorKind};
use tailor_mesh::garment::{Mesh, Orientation};

/// Share of a body's area that may be turned over on the other body.
const MOST_FOLDED: f64 = 0.25;
/// How much an open body faces inwards, from -1 to 1, where its faces are taken as inside out.
const INWARDS: f64 = -0.3;
/// How far a body sinks below a cage at first, as a share of its size, and how often it sinks, twice as far each time.
const SINK: f64 = 1e-3;
const MOST_SINKS: usize = 6;

/// The body that a garment is to fit, and the same faces where they are on the body that it was made for.
#[derive(Clone, Debug, Default)]
pub struct Bodies {
    /// The vertices of each triangle.
    pub(super) triangles: Vec<[usize; 3]>,
    /// The ends of each edge.
    pub(super) edges: Vec<[usize; 2]>,
    /// Points on the body that the garment was made for. \[mesh units\]
    pub(super) from: Vec<DVec3>,
    /// Points of the body that it is to fit. \[mesh units\]
    pub(super) to: Vec<DVec3>,
    /// The body that the garment was made for, where it has other faces.
    pub(super) first: Option<Box<Bodies>>,
    /// Share of the area that is turned over on the first body.
    pub(super) folded: f64,
}

impl Bodies {
    /// The points of the body after a share of the way. \[mesh units\]
    pub fn shape_at(&self, share: f64) -> Vec<glam::Vec3> {
        self.shape(share).iter().map(|p| p.as_vec3()).collect()
    }

    /// Two bodies with the same faces, or with UVs in which they correspond.
    ///
    /// # Errors
    /// Bodies that have neither, and UVs that turn much of the second body over.
    pub fn new(from: &Mesh, to: &Mesh) -> Result<Self, Error> {
        match same_faces(from, to) {
            Some(points) => Ok(Self::of(to, points)),
            None => Self::of_other_faces(from, to, &by_uvs(from, to)?),
        }
    }

    /// Two bodies of any faces, with pairs of places that correspond: on the first one, and on the second one. The thin-plate spline of
    /// the pairs takes the points of the first body near the second one, and then onto it.
    ///
    /// # Errors
    /// Too few pairs, or too many, and pairs that turn much of the second body over.
    pub fn by_pairs(from: &Mesh, to: &Mesh, pairs: &[[DVec3; 2]]) -> Result<Self, Error> {
        Self::of_other_faces(from, to, &by_pairs(from, to, pairs)?)
    }

    fn of(mesh: &Mesh, from: Vec<DVec3>) -> Self {
        let to = as_doubles(mesh);
        let mut triangles = joined(fans(mesh), &from, &to);
        let (edges, is_closed) = edges(&triangles);
        let is_left = mesh.orientation == Orientation::LeftHanded;
        let outwards = outwards(&triangles, &to) * if is_left { -1.0 } else { 1.0 };
        if is_left != (outwards < if is_closed { 0.0 } else { INWARDS }) {
            triangles.iter_mut().for_each(|triangle| triangle.reverse());
        }
        Self { triangles, edges, from, to, ..Self::default() }
    }

    /// The second body, where its vertices are on the first one. Faces that the first one lacks take no part.
    fn of_other_faces(from: &Mesh, to: &Mesh, places: &[Option<Place>]) -> Result<Self, Error> {
        let first = Self::of(from, as_doubles(from));
        let point = |(place, own): (&Option<Place>, DVec3)| place.as_ref().map_or(own, |place| place.point);
        let mut bodies = Self::of(to, places.iter().zip(as_doubles(to)).map(point).collect());
        bodies.triangles.retain(|triangle| triangle.iter().all(|&v| places[v].is_some()));
        bodies.edges = edges(&bodies.triangles).0;
        bodies.folded = bodies.folded_share(&first, places);
        if bodies.folded > MOST_FOLDED {
            let text = format!("{:.0} % of it would be flipped on {}", 100.0 * bodies.folded, from.prim);
            let remedy = "turn both bodies the same way, and give them UVs or pairs that do not swap their sides";
            return Err(Error::new(ErrorKind::Mesh, &to.prim, text).code(codes::BODIES_DIFFER).remedy(remedy));
        }
        bodies.first = Some(Box::new(first));
        Ok(bodies)
    }

    /// Share of the area whose triangles face the other way than the first body does where they are on it.
    fn folded_share(&self, first: &Self, places: &[Option<Place>]) -> f64 {
        let of_first = |v: usize| {
            let below = places[v].as_ref().map(|place| normal(first.triangles[place.triangle], &first.from));
            below.unwrap_or_default().normalize_or_zero()
        };
        let is_folded = |t: &&[usize; 3]| normal(**t, &self.from).dot(t.iter().map(|&v| of_first(v)).sum()) < 0.0;
        let area = |triangle: &[usize; 3]| normal(*triangle, &self.to).length();
        let all: f64 = self.triangles.iter().map(area).sum();
        self.triangles.iter().filter(is_folded).map(area).sum::<f64>() / all.max(f64::MIN_POSITIVE)
    }

    /// The body that the garment was made for, as its file has it.
    pub(super) fn first(&self) -> &Self {
        self.first.as_deref().unwrap_or(self)
    }

    /// The bodies with the second one below a cage at the start, except for faces that cross the first one: where it is coarser, its
    /// faces reach out of hollows.
    pub(super) fn below(&self, cage: &Cage, points: &[DVec3], crossing: &CrossingFaces) -> Cow<'_, Self> {
        if self.first.is_none() {
            return Cow::Borrowed(self);
        }
        let (mut below, mut step) = (self.clone(), SINK * self.size());
        let work = work_limit(cage, self, SEARCH_PART);
        for _ in 0..MOST_SINKS {
            let found = Crossings::of(cage, points, &below, &below.from, &work).without(crossing, cage).body;
            let sinking: BTreeSet<usize> = found.iter().flat_map(|&[_, body]| below.triangles[body]).collect();
            if sinking.is_empty() {
                break;
            }
            let normals = normals(&below.triangles, &below.from);
            sinking.into_iter().for_each(|v| below.from[v] -= step * normals[v]);
            step *= 2.0;
        }
        Cow::Owned(below)
    }

    /// The bodies with the second one larger all around. \[mesh units\]
    pub(super) fn eased(mut self, ease: f64) -> Self {
        let normals = normals(&self.triangles, &self.to);
        self.to.iter_mut().zip(normals).for_each(|(point, normal)| *point += ease * normal);
        self
    }

    /// The points at a share of the way.
    pub(super) fn shape(&self, share: f64) -> Vec<DVec3> {
        self.from.iter().zip(&self.to).map(|(a, b)| a.lerp(*b, share)).collect()
    }

    /// The diagonal of the box of the first shape's triangles.
    pub(super) fn size(&self) -> f64 {
        let [low, high] = bounds(&self.triangles, &self.from);
        high.distance(low)
    }
}

pub(super) fn as_doubles(mesh: &Mesh) -> Vec<DVec3> {
    mesh.points.iter().map(|p| p.as_dvec3()).collect()
}

/// The faces of a mesh as fans of triangles.
pub(super) fn fans(mesh: &Mesh) -> Vec<[usize; 3]> {
    mesh.faces.fans().map(|triangle| triangle.map(|v| v.index())).collect()
}

/// Triangles without points that are twice in both shapes, as at the UV seams of some files.
fn joined(triangles: Vec<[usize; 3]>, from: &[DVec3], to: &[DVec3]) -> Vec<[usize; 3]> {
    let (mut first, bits) = (HashMap::new(), |v: usize| [from[v], to[v]].map(|p| p.to_array().map(f64::to_bits)));
    let joined = triangles.iter().map(|t| t.map(|v| *first.entry(bits(v)).or_insert(v))).collect::<Vec<_>>();
    if joined.iter().all(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) { joined } else { triangles }
}

/// The edges of triangles, and whether each of them is of two.
fn edges(triangles: &[[usize; 3]]) -> (Vec<[usize; 2]>, bool) {
    let sides = triangles.iter().flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
    let mut edges: Vec<[usize; 2]> = sides.map(|[a, b]| [a.min(b), a.max(b)]).collect();
    edges.sort_unstable();
    let is_closed = edges.chunk_by(|a, b| a == b).all(|sides| sides.len() == 2);
    edges.dedup();
    (edges, is_closed)
}

/// The normal of a triangle, as long as twice its area.
fn normal([a, b, c]: [usize; 3], points: &[DVec3]) -> DVec3 {
    (points[b] - points[a]).cross(points[c] - points[a])
}

/// How much triangles face away from their centre, from -1 to 1. It has the sign of the volume if they are closed.
fn outwards(triangles: &[[usize; 3]], points: &[DVec3]) -> f64 {
    let of =
        |triangle: &[usize; 3]| (triangle.iter().map(|&v| points[v]).sum::<DVec3>() / 3.0, normal(*triangle, points));
    let all: Vec<(DVec3, DVec3)> = triangles.iter().map(of).collect();
    let area: f64 = all.iter().map(|(_, normal)| normal.length()).sum();
    let centre = all.iter().map(|(middle, normal)| *middle * normal.length()).sum::<DVec3>() / area;
    let most: f64 = all.iter().map(|(middle, normal)| middle.distance(centre) * normal.length()).sum();
    let away = all.iter().map(|(middle, normal)| (*middle - centre).dot(*normal)).sum::<f64>() / most;
    if away.is_finite() { away } else { 0.0 }
}
