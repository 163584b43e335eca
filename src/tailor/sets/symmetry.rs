//! The plane of symmetry of a garment, and the twin of each element on its other side.
//!
//! Topology comes first: a connected piece is walked from a face and its twin at once, so that both sides may be posed
//! differently. Pieces whose sides differ are compared by place.

use super::elements::ElementSet;
use super::pieces::face_pieces;
use crate::contact::{NearestSearch, Range};
use glam::{DVec3, Vec3};
use rustc_hash::FxHashMap;
use std::collections::{BTreeMap, BTreeSet};
use tailor_mesh::connectivity::{CornerId, FaceId, IdVec, Topology, VertexId};
use tailor_mesh::garment::{Mesh, Subset};

/// Least share of the faces that have a twin.
const LEAST_SHARE: f64 = 0.5;
/// Share from which no other plane is looked at.
const SURE_SHARE: f64 = 0.95;
/// Share of the mean edge length by which a face may be away from its mirrored twin where a walk begins.
const NEAR: f64 = 0.5;
/// Share of the mean edge length by which a point may be away from its mirrored twin where places are compared.
const SAME: f64 = 0.1;
/// Faces of a piece from which a walk is tried.
const TRIES: usize = 6;
/// Share of the size of a garment below which it lies in a plane.
const FLAT: f64 = 0.05;

/// A plane of symmetry.
#[derive(Clone, Debug, PartialEq)]
pub struct Symmetry {
    /// The axis that the plane is across, in the stage's directions.
    pub axis: usize,
    /// Where it is on this axis, from the origin of the mesh. \[stage units\]
    pub at: f64,
    /// Share of the faces that have a twin.
    pub share: f64,
    faces: IdVec<FaceId, Option<FaceId>>,
    vertices: IdVec<VertexId, Option<VertexId>>,
}

impl Symmetry {
    /// The name of the axis.
    pub fn axis_name(&self) -> &'static str {
        ["x", "y", "z"][self.axis]
    }

    /// The twin of a face; itself across the plane.
    pub fn face(&self, face: FaceId) -> Option<FaceId> {
        self.faces[face]
    }

    /// The twin of a vertex; itself on the plane.
    pub fn vertex(&self, vertex: VertexId) -> Option<VertexId> {
        self.vertices[vertex]
    }

    /// The plane with the most twins, if at least half of the faces have one. `source` has the garment's vertex behind each vertex
    /// of `t`.
    pub fn of(garment: &Mesh, t: &Topology, source: impl Fn(VertexId) -> VertexId) -> Option<Self> {
        let place = |v| (garment.space.to_stage * garment.points[source(VertexId::new(v))]).as_dvec3();
        let places: IdVec<VertexId, DVec3> = (0..t.vertex_count()).map(place).collect();
        let (low, high) =
            places.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
        let size = high - low;
        let pieces = face_pieces(t, &t.faces.ids().collect(), |_| false);
        let mut best: Option<Self> = None;
        for axis in (0..3).filter(|&axis| size[axis] > FLAT * size.max_element()) {
            for at in [0.0, 0.5 * (low[axis] + high[axis])] {
                if best.as_ref().is_some_and(|best| best.share >= SURE_SHARE) {
                    return best;
                }
                let found = Search::new(t, &places, axis, at).run(&pieces);
                if found.share >= LEAST_SHARE && best.as_ref().is_none_or(|best| found.share > best.share) {
                    best = Some(found);
                }
            }
        }
        best
    }

    /// The twins of the elements that have one. Edges go the other way, so that what was at their left stays there.
    pub(super) fn mirrored(&self, t: &Topology, set: &ElementSet) -> ElementSet {
        match set {
            ElementSet::Faces(faces) => ElementSet::Faces(faces.iter().filter_map(|&face| self.faces[face]).collect()),
            ElementSet::Points(points) => {
                ElementSet::Points(points.iter().filter_map(|&point| self.vertices[point]).collect())
            }
            ElementSet::Edges(edges) => {
                let twin = |&[a, b]: &[VertexId; 2]| {
                    let [a, b] = [self.vertices[b]?, self.vertices[a]?];
                    Some((t.find_edge(a, b)?, [a, b]))
                };
                ElementSet::Edges(edges.values().filter_map(twin).collect())
            }
        }
    }

    /// The name of the twin of each set that has one; a set that lies on both sides has its own name.
    pub(super) fn twins(&self, t: &Topology, sets: &[Subset]) -> BTreeMap<String, String> {
        let of = |set: &Subset| ElementSet::of(t, &set.elements);
        let known: Vec<(&Subset, ElementSet)> = sets.iter().map(|set| (set, of(set))).collect();
        let same = |a: &ElementSet, b: &ElementSet| !a.is_empty() && a.len() == b.len() && a.contains(b);
        let twin = |(set, of): &(&Subset, ElementSet)| {
            let mirrored = self.mirrored(t, of);
            let other = known.iter().find(|(_, other)| same(&mirrored, other))?;
            Some((set.name.clone(), other.0.name.clone()))
        };
        known.iter().filter_map(twin).collect()
    }
}

/// A search for the twins in one plane.
struct Search<'a> {
    t: &'a Topology,
    places: &'a IdVec<VertexId, DVec3>,
    axis: usize,
    at: f64,
    mean: f64,
    faces: IdVec<FaceId, Option<FaceId>>,
    vertices: IdVec<VertexId, Option<VertexId>>,
}

impl<'a> Search<'a> {
    fn new(t: &'a Topology, places: &'a IdVec<VertexId, DVec3>, axis: usize, at: f64) -> Self {
        let sum: f64 = t.edges.iter().map(|&[a, b]| places[a].distance(places[b])).sum();
        let mean = sum / t.edges.len().max(1) as f64;
        let (faces, vertices) = (IdVec::filled(None, t.faces.len()), IdVec::filled(None, t.vertex_count()));
        Self { t, places, axis, at, mean, faces, vertices }
    }

    fn run(mut self, pieces: &[ElementSet]) -> Symmetry {
        let centres = Places::new(NEAR * self.mean, self.t.faces.ids().map(|face| (face, self.centre(face))));
        let points = Places::new(SAME * self.mean, self.places.enumerated().map(|(vertex, &place)| (vertex, place)));
        for piece in pieces {
            let ElementSet::Faces(piece) = piece else { continue };
            self.walk_piece(piece, &centres);
            if piece.iter().any(|&face| self.faces[face].is_none()) {
                self.compare(piece, &points);
            }
        }
        let found = self.faces.iter().flatten().count();
        let share = found as f64 / self.faces.len().max(1) as f64;
        Symmetry { axis: self.axis, at: self.at, share, faces: self.faces, vertices: self.vertices }
    }

    fn centre(&self, face: FaceId) -> DVec3 {
        let vertices = self.t.faces.vertices_of(face);
        vertices.iter().map(|&vertex| self.places[vertex]).sum::<DVec3>() / vertices.len() as f64
    }

    fn mirrored(&self, mut place: DVec3) -> DVec3 {
        place[self.axis] = 2.0 * self.at - place[self.axis];
        place
    }

    /// Walks a piece and its twin from one of its faces.
    fn walk_piece(&mut self, piece: &BTreeSet<FaceId>, centres: &Places<FaceId>) {
        let mut tries = 0;
        for &face in piece {
            if self.faces[face].is_some() || tries == TRIES {
                return;
            }
            let Some(twin) = centres.nearest(self.mirrored(self.centre(face))) else { continue };
            let Some(ends) = self.start(face, twin) else { continue };
            tries += 1;
            if let Some((faces, vertices)) = self.walk(ends) {
                faces.into_iter().for_each(|(face, twin)| self.faces[face] = Some(twin));
                vertices.into_iter().for_each(|(vertex, twin)| self.vertices[vertex] = Some(twin));
                return;
            }
        }
    }

    /// A corner of a face and that of its twin which lie on one another in the mirror, as all others of the two do.
    fn start(&self, face: FaceId, twin: FaceId) -> Option<[CornerId; 2]> {
        let faces = &self.t.faces;
        let first = faces.corners_of(face).next()?;
        let far = |a: CornerId, b: CornerId| {
            self.mirrored(self.places[faces.vertex(a)]).distance(self.places[faces.vertex(b)])
        };
        let other = faces.corners_of(twin).min_by(|&a, &b| far(first, a).total_cmp(&far(first, b)))?;
        let fits = self.around(first, other).is_some_and(|all| all.iter().all(|&[a, b]| far(a, b) < NEAR * self.mean));
        fits.then_some([first, other])
    }

    /// The corners of a face from one on, with those of its twin, which go the other way; none where there are fewer.
    fn around(&self, first: CornerId, twin: CornerId) -> Option<Vec<[CornerId; 2]>> {
        let faces = &self.t.faces;
        let count = faces.valence(faces.face_of(first));
        let step = |&[a, b]: &[CornerId; 2]| Some([faces.next(a), faces.prev(b)]);
        let all = || std::iter::successors(Some([first, twin]), step).take(count).collect();
        (count == faces.valence(faces.face_of(twin))).then(all)
    }

    /// The twins of all elements that are reached from two corners; none where the two sides differ.
    fn walk(&self, start: [CornerId; 2]) -> Option<(FxHashMap<FaceId, FaceId>, FxHashMap<VertexId, VertexId>)> {
        let t = self.t;
        let (mut faces, mut vertices) = (FxHashMap::default(), FxHashMap::default());
        let mut open = vec![start];
        while let Some([corner, twin]) = open.pop() {
            let [face, other] = [corner, twin].map(|corner| t.faces.face_of(corner));
            if faces.get(&face) == Some(&other) {
                continue;
            }
            for (a, b) in [(face, other), (other, face)] {
                if self.faces[a].is_some() || faces.insert(a, b).is_some_and(|known| known != b) {
                    return None;
                }
            }
            for [a, b] in self.around(corner, twin)? {
                let [v, w] = [a, b].map(|corner| t.faces.vertex(corner));
                for (v, w) in [(v, w), (w, v)] {
                    if vertices.insert(v, w).is_some_and(|known| known != w) {
                        return None;
                    }
                }
                // The half-edge that leaves the corner is, in the mirror, the one that comes to it.
                let beside = |corner: CornerId| {
                    let row = t.edge_corners.row(t.corner_edge[corner]);
                    (row.len() <= 2).then(|| row.iter().copied().find(|&other| other != corner))
                };
                match (beside(a)?, beside(t.faces.prev(b))?) {
                    (None, None) => {}
                    (Some(next), Some(twin)) => open.push([next, t.faces.next(twin)]),
                    _ => return None,
                }
            }
        }
        Some((faces, vertices))
    }

    /// Compares the points of a piece by place; its faces have those with the same points for twins.
    fn compare(&mut self, piece: &BTreeSet<FaceId>, points: &Places<VertexId>) {
        let t = self.t;
        for &vertex in piece.iter().flat_map(|&face| t.faces.vertices_of(face)) {
            let twin = self.vertices[vertex].or_else(|| points.nearest(self.mirrored(self.places[vertex])));
            self.vertices[vertex] = twin;
        }
        let sorted = |face: FaceId| t.faces.vertices_of(face).iter().copied().collect::<BTreeSet<_>>();
        for &face in piece {
            let own: Option<BTreeSet<VertexId>> =
                sorted(face).into_iter().map(|vertex| self.vertices[vertex]).collect();
            let Some((first, own)) = own.and_then(|own| Some((*own.first()?, own))) else { continue };
            let around = t.vertex_corners.row(first).iter().map(|&corner| t.faces.face_of(corner));
            self.faces[face] = self.faces[face].or_else(|| around.into_iter().find(|&other| sorted(other) == own));
        }
    }
}

/// Elements by their places.
struct Places<I> {
    elements: Vec<I>,
    points: Vec<Vec3>,
    search: NearestSearch,
    reach: f64,
}

impl<I: Copy> Places<I> {
    fn new(reach: f64, elements: impl Iterator<Item = (I, DVec3)>) -> Self {
        let (elements, points): (Vec<I>, Vec<Vec3>) = elements.map(|(of, place)| (of, place.as_vec3())).unzip();
        Self { search: NearestSearch::of_points(&points), elements, points, reach }
    }

    /// The nearest element within reach.
    fn nearest(&self, place: DVec3) -> Option<I> {
        let range = Range { reach: self.reach, error: 0.0 };
        let distance = |at: usize, from: DVec3| self.points[at].as_dvec3().distance_squared(from);
        self.search.nearest_within(place.as_vec3(), range, |_, _| true, distance).map(|at| self.elements[at])
    }
}
