//! Faults of a surface that are warnings: counted, with the first few elements.

use crate::codes;
use crate::connectivity::{CornerId, Elements, FaceId, Faces, Groups, IdVec, Topology, VertexId};
use crate::error::{Warning, WarningCode, Warnings};
use glam::{DVec3, Vec3};

/// A face has no area when its area is this share of its longest edge's square or less: thinner than the rounding of its
/// points. Larger counts slivers too.
const NO_AREA: f64 = f32::EPSILON as f64;

/// A warning for each oddity of the surface.
pub(super) fn warnings(prim: &str, topology: &Topology, points: &[Vec3]) -> Warnings {
    let faces = &topology.faces;
    let cut = "The simulation mesh is cut apart there";
    let found = [
        (
            codes::NON_MANIFOLD_EDGES,
            Elements::Edges(crowded_edges(topology).collect()),
            "have more than two faces",
            cut,
        ),
        (codes::BOW_TIE_VERTICES, Elements::Points(bow_ties(topology).collect()), "join fans of faces", cut),
        (
            codes::WINDING_DISAGREEMENTS,
            Elements::Edges(winding_edges(topology).collect()),
            "are between faces of opposite winding",
            "The simulation mesh is oriented alike, the render mesh keeps them",
        ),
        (
            codes::UNUSED_POINTS,
            Elements::Points(unused_points(topology).collect()),
            "have no face",
            "The simulation mesh drops them, the render mesh keeps them",
        ),
        (
            codes::DEGENERATE_FACES,
            Elements::Faces(without_area(faces, points).collect()),
            "have no area",
            "Both meshes keep them: delete them, or give them an area",
        ),
        (
            codes::DUPLICATE_FACES,
            Elements::Faces(duplicates(faces).into_iter().map(|[_, duplicate]| duplicate).collect()),
            "have the points of another face",
            "Delete one of each two unless two layers are meant",
        ),
    ];
    let found = found.into_iter().filter(|(_, elements, ..)| !elements.is_empty());
    let warning = |(code, elements, problem, remedy): (WarningCode, Elements, &str, &str)| {
        let problem = format!("{} {}s {problem}", elements.len(), elements.kind());
        Warning::new(code, prim, problem).at(elements).remedy(remedy)
    };
    found.map(warning).collect()
}

/// The edges of more than two faces.
fn crowded_edges(topology: &Topology) -> impl Iterator<Item = [VertexId; 2]> {
    let edges = topology.edges.ids().filter(|&e| topology.edge_corners.row(e).len() > 2);
    edges.map(|e| topology.edges[e])
}

/// The edges whose two faces run along them in the same direction.
fn winding_edges(topology: &Topology) -> impl Iterator<Item = [VertexId; 2]> {
    let disagree =
        |corners: &[CornerId]| matches!(*corners, [a, b] if topology.faces.vertex(a) == topology.faces.vertex(b));
    let edges = topology.edges.ids().filter(move |&e| disagree(topology.edge_corners.row(e)));
    edges.map(|e| topology.edges[e])
}

/// The points that no face uses.
fn unused_points(topology: &Topology) -> impl Iterator<Item = VertexId> {
    (0..topology.vertex_count()).map(VertexId::new).filter(|&v| topology.vertex_corners.row(v).is_empty())
}

/// The vertices with more than one fan: a fan is a set of faces that are connected through edges of two faces.
fn bow_ties(topology: &Topology) -> impl Iterator<Item = VertexId> {
    let fans = fan_counts(topology);
    (0..topology.vertex_count()).map(VertexId::new).filter(move |&v| fans[v] > 1)
}

/// The number of fans at each vertex: one for each corner, less one for each edge that joins two.
fn fan_counts(topology: &Topology) -> IdVec<VertexId, usize> {
    let vertices = (0..topology.vertex_count()).map(VertexId::new);
    let mut fans: IdVec<VertexId, usize> = vertices.map(|v| topology.vertex_corners.row(v).len()).collect();
    let mut groups = Groups::<CornerId>::new(topology.faces.corners().len());
    for edge in topology.edges.ids() {
        let &[a, b] = topology.edge_corners.row(edge) else { continue };
        for end in topology.edges[edge] {
            if groups.join(corner_at(&topology.faces, a, end), corner_at(&topology.faces, b, end)) {
                fans[end] -= 1;
            }
        }
    }
    fans
}

/// The corner at `end` of the face whose half-edge `corner` begins or ends there.
fn corner_at(faces: &Faces, corner: CornerId, end: VertexId) -> CornerId {
    if faces.vertex(corner) == end { corner } else { faces.next(corner) }
}

/// The faces whose area is zero except for rounding.
fn without_area(faces: &Faces, points: &[Vec3]) -> impl Iterator<Item = FaceId> {
    let point = |v: VertexId| points[v.index()].as_dvec3();
    let is_without = move |face: &FaceId| {
        let vertices = faces.vertices_of(*face);
        let origin = point(vertices[0]);
        let (mut doubled, mut longest) = (DVec3::ZERO, 0.0f64);
        for (i, &vertex) in vertices.iter().enumerate() {
            let (a, b) = (point(vertex) - origin, point(vertices[(i + 1) % vertices.len()]) - origin);
            doubled += a.cross(b);
            longest = longest.max(a.distance_squared(b));
        }
        doubled.length() <= 2.0 * NO_AREA * longest
    };
    faces.ids().filter(is_without)
}

/// Faces on the same vertices as an earlier one: that one and the face, ordered by the face.
fn duplicates(faces: &Faces) -> Vec<[FaceId; 2]> {
    let mut keys: Vec<(u64, FaceId)> = faces.ids().map(|f| (vertex_set_hash(faces.vertices_of(f)), f)).collect();
    keys.sort_unstable();
    let runs = keys.chunk_by(|a, b| a.0 == b.0).filter(|run| run.len() > 1);
    let mut pairs: Vec<_> = runs.flat_map(|run| duplicates_among(faces, run)).collect();
    pairs.sort_unstable_by_key(|pair| pair[1]);
    pairs
}

/// The duplicates among faces of equal hash.
fn duplicates_among(faces: &Faces, run: &[(u64, FaceId)]) -> Vec<[FaceId; 2]> {
    let sorted = |&(_, face): &(u64, FaceId)| {
        let mut vertices = faces.vertices_of(face).to_vec();
        vertices.sort_unstable();
        (vertices, face)
    };
    let mut sets: Vec<(Vec<VertexId>, FaceId)> = run.iter().map(sorted).collect();
    sets.sort_unstable();
    let same = sets.chunk_by(|a, b| a.0 == b.0);
    same.flat_map(|same| same[1..].iter().map(|other| [same[0].1, other.1])).collect()
}

/// A hash of a face's vertices that does not depend on their order.
fn vertex_set_hash(vertices: &[VertexId]) -> u64 {
    vertices.iter().fold(0, |sum, v| sum.wrapping_add(scramble(v.index() as u64)))
}

/// Spreads a number over 64 bits (the finaliser of SplitMix64), so that sums of different sets differ.
fn scramble(number: u64) -> u64 {
    let mut x = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
