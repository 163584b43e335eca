//! The connected pieces of a set.
//!
//! Faces and points are connected by edges. Edges are connected where exactly two of a set meet, so that the pieces of a
//! network of seams are its chains between junctions, and the pieces of borders are loops.

use super::SetEvaluator;
use super::elements::ElementSet;
use super::expression::{Choice, Extreme};
use glam::Vec3;
use std::collections::{BTreeMap, BTreeSet};
use tailor_mesh::connectivity::{CornerId, EdgeId, FaceId, Groups, Id, IdVec, Topology, VertexId};
use tailor_mesh::garment::{Mesh, Orientation};

/// The pieces of a set, in the order of their first elements.
pub fn pieces(t: &Topology, set: &ElementSet) -> Vec<ElementSet> {
    match set {
        ElementSet::Faces(faces) => face_pieces(t, faces, |_| false),
        ElementSet::Edges(edges) => edge_pieces(t, edges),
        ElementSet::Points(points) => point_pieces(t, points),
    }
}

/// Pieces of faces that are connected across edges which are not cut.
pub fn face_pieces(t: &Topology, faces: &BTreeSet<FaceId>, is_cut: impl Fn(EdgeId) -> bool) -> Vec<ElementSet> {
    let is_in = marked(faces, t.faces.len());
    let mut groups = Groups::<FaceId>::new(t.faces.len());
    for edge in t.edges.ids().filter(|&edge| !is_cut(edge)) {
        let mut around = t.edge_corners.row(edge).iter().map(|&c| t.faces.face_of(c)).filter(|&face| is_in[face]);
        if let Some(first) = around.next() {
            for face in around {
                groups.join(first, face);
            }
        }
    }
    grouped(faces.iter().copied(), |face| groups.first(face)).map(ElementSet::Faces).collect()
}

fn edge_pieces(t: &Topology, edges: &BTreeMap<EdgeId, [VertexId; 2]>) -> Vec<ElementSet> {
    let mut groups = Groups::<EdgeId>::new(t.edges.len());
    for ends in edges_at(t, edges.keys()).values() {
        if let [a, b] = ends[..] {
            groups.join(a, b);
        }
    }
    let pieces = grouped(edges.keys().copied(), |edge| groups.first(edge));
    pieces.map(|piece| ElementSet::Edges(piece.into_iter().map(|edge| (edge, edges[&edge])).collect())).collect()
}

fn point_pieces(t: &Topology, points: &BTreeSet<VertexId>) -> Vec<ElementSet> {
    let is_in = marked(points, t.vertex_count());
    let mut groups = Groups::<VertexId>::new(t.vertex_count());
    for &[a, b] in t.edges.iter().filter(|ends| ends.iter().all(|&v| is_in[v])) {
        groups.join(a, b);
    }
    grouped(points.iter().copied(), |point| groups.first(point)).map(ElementSet::Points).collect()
}

/// A flag for each element of the mesh.
pub fn marked<I: Id>(set: &BTreeSet<I>, len: usize) -> IdVec<I, bool> {
    let mut is_in = IdVec::filled(false, len);
    set.iter().for_each(|&element| is_in[element] = true);
    is_in
}

/// Elements by the first element of their group, in its order.
fn grouped<I: Id>(
    elements: impl Iterator<Item = I>,
    mut first: impl FnMut(I) -> I,
) -> impl Iterator<Item = BTreeSet<I>> {
    let mut groups = BTreeMap::<I, BTreeSet<I>>::new();
    for element in elements {
        groups.entry(first(element)).or_default().insert(element);
    }
    groups.into_values()
}

/// The edges of a set at each of their ends.
pub fn edges_at<'e>(t: &Topology, edges: impl Iterator<Item = &'e EdgeId>) -> BTreeMap<VertexId, Vec<EdgeId>> {
    let mut at = BTreeMap::<VertexId, Vec<EdgeId>>::new();
    for &edge in edges {
        t.edges[edge].iter().for_each(|&end| at.entry(end).or_default().push(edge));
    }
    at
}

/// Edges with directions that go on along each chain. The first edge of a chain keeps that of its first face.
pub fn oriented(t: &Topology, edges: &BTreeSet<EdgeId>) -> ElementSet {
    let at = edges_at(t, edges.iter());
    let mut found = BTreeMap::<EdgeId, [VertexId; 2]>::new();
    for &first in edges {
        if found.contains_key(&first) {
            continue;
        }
        found.insert(first, t.edges[first]);
        for end in [1, 0] {
            let mut edge = first;
            while let [a, b] = at[&found[&edge][end]][..] {
                let next = if a == edge { b } else { a };
                if found.contains_key(&next) {
                    break;
                }
                let here = found[&edge][end];
                let far = other_end(t, next, here);
                found.insert(next, if end == 1 { [here, far] } else { [far, here] });
                edge = next;
            }
        }
    }
    ElementSet::Edges(found)
}

/// The end of an edge that `vertex` is not.
pub fn other_end(t: &Topology, edge: EdgeId, vertex: VertexId) -> VertexId {
    let [a, b] = t.edges[edge];
    if a == vertex { b } else { a }
}

/// The edge that leaves a corner, in the direction in which the face is at its left, seen from the front.
pub fn beside(sets: &SetEvaluator<'_>, corner: CornerId) -> (EdgeId, [VertexId; 2]) {
    let [a, b] = sets.topology.faces.half_edge(corner);
    let is_left_handed = sets.garment.orientation == Orientation::LeftHanded;
    (sets.topology.corner_edge[corner], if is_left_handed { [b, a] } else { [a, b] })
}

/// Where a set is, and its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// The least coordinates in the stage's directions, from the origin of the mesh. \[stage units\]
    pub low: Vec3,
    /// The greatest coordinates.
    pub high: Vec3,
    /// The length of edges \[mesh units\], the area of faces \[square mesh units\], or the number of points.
    pub size: f64,
}

impl Extent {
    /// The extent of a set that is not empty.
    pub fn of(garment: &Mesh, t: &Topology, set: &ElementSet) -> Self {
        let at = |v: VertexId| garment.points[v].as_dvec3();
        let places = set.points(t).into_iter().map(|v| garment.space.to_stage * garment.points[v]);
        let (low, high) = places.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        let size = match set {
            ElementSet::Faces(faces) => faces.iter().map(|&face| 0.5 * garment.doubled_normal(face).length()).sum(),
            ElementSet::Edges(edges) => edges.values().map(|&[a, b]| at(a).distance(at(b))).sum(),
            ElementSet::Points(points) => points.len() as f64,
        };
        Self { low, high, size }
    }

    /// How far it is in a direction, or how large.
    pub fn along(&self, extreme: Extreme, up: usize) -> f64 {
        let centre = self.low.midpoint(self.high).as_dvec3();
        match extreme {
            Extreme::Lowest => -centre[up],
            Extreme::Highest => centre[up],
            Extreme::Least(axis) => -centre[axis],
            Extreme::Greatest(axis) => centre[axis],
            Extreme::Largest => self.size,
        }
    }
}

/// One of several pieces; none where there are too few.
pub fn chosen(sets: &SetEvaluator<'_>, mut pieces: Vec<ElementSet>, choice: Choice) -> Option<ElementSet> {
    let at = match choice {
        Choice::Number(number) => number - 1,
        Choice::Extreme(extreme) => {
            let up = sets.garment.space.up_axis();
            let along = |set| Extent::of(sets.garment, &sets.topology, set).along(extreme, up);
            // The first of equals.
            let farthest = pieces.iter().map(along).enumerate().rev().max_by(|a, b| a.1.total_cmp(&b.1));
            farthest?.0
        }
    };
    (at < pieces.len()).then(|| pieces.swap_remove(at))
}
