//! The topology of a refined level, computed from the parent's by index arithmetic.
//!
//! Children of vertices come first, then those of faces (except under Loop), then those of edges. Child faces follow
//! the parent's face order, corner by corner. This is OpenSubdiv's numbering, so levels can be compared element by
//! element.
//!
//! Quads need no search for shared edges: [`quad_topology`] computes each index directly. Loop levels use
//! [`Topology::new`].

use super::level::{Level, Rule, refined_sharpness};
use crate::connectivity::{CornerId, Csr, EdgeId, FaceId, Faces, IdVec, Topology, VertexId};
use crate::garment::Scheme;
use rayon::prelude::*;

/// Smallest number of corners for one parallel task.
const CORNERS_PER_TASK: usize = 4096;

/// The indices of the children of a level's vertices, edges and faces.
#[derive(Clone, Copy, Debug)]
pub struct Numbering {
    vertices: usize,
    faces: usize,
    edges: usize,
    triangles: bool,
}

impl Numbering {
    /// The numbering of the refinement of `parent`.
    pub fn new(parent: &Level) -> Self {
        let t = &parent.topology;
        let triangles = parent.scheme == Scheme::Loop;
        Self {
            vertices: t.vertex_count(),
            faces: if triangles { 0 } else { t.faces.len() },
            edges: t.edges.len(),
            triangles,
        }
    }

    /// Number of child vertices.
    pub fn vertices(&self) -> usize {
        self.vertices + self.faces + self.edges
    }

    /// The child of a vertex.
    #[inline]
    pub fn of_vertex(&self, v: VertexId) -> VertexId {
        v
    }

    /// The child vertex at the centre of a face.
    #[inline]
    pub fn of_face(&self, f: FaceId) -> VertexId {
        VertexId::new(self.vertices + f.index())
    }

    /// Whether faces have a child vertex at their centre.
    #[inline]
    pub fn has_centres(&self) -> bool {
        !self.triangles
    }

    /// The child vertex of an edge.
    #[inline]
    pub fn of_edge(&self, e: EdgeId) -> VertexId {
        VertexId::new(self.vertices + self.faces + e.index())
    }

    /// The child faces of a face.
    #[inline]
    pub fn of_face_within(&self, parent: &Faces, face: FaceId) -> impl Iterator<Item = FaceId> + use<> {
        let children = if self.triangles { 4 * face.index()..4 * face.index() + 4 } else { parent.range(face) };
        children.map(FaceId::new)
    }

    /// The parent face of a child face.
    #[inline]
    pub fn parent_face(&self, parent: &Faces, child: FaceId) -> FaceId {
        if self.triangles { FaceId::new(child.index() / 4) } else { parent.face_of(CornerId::new(child.index())) }
    }
}

/// Values of the children of all vertices: `own` are those of vertices, and new ones are made for faces and edges.
pub fn child_values<T: Copy>(
    parent: &Level,
    own: &IdVec<VertexId, T>,
    of_face: impl Fn(FaceId) -> T,
    of_edge: impl Fn(EdgeId) -> T,
) -> IdVec<VertexId, T> {
    let t = &parent.topology;
    let faces = t.faces.ids().filter(|_| parent.scheme != Scheme::Loop).map(of_face);
    own.iter().copied().chain(faces).chain(t.edges.ids().map(of_edge)).collect()
}

/// Corner `k` of the child quad of parent corner `c`: 0 at its vertex, 1 at the middle of its edge, 2 at the face's
/// centre, 3 at the middle of the previous edge.
///
/// The child of a quad stores its vertex at the same position as the parent; all other children store it first.
#[inline(always)]
pub fn child_corner(parent: &Faces, c: CornerId, k: usize) -> CornerId {
    CornerId::new(4 * c.index() + ((position_in_child(parent, c) + k) & 3))
}

/// The position in the child quad of a corner at which that corner is stored.
#[inline(always)]
fn position_in_child(parent: &Faces, c: CornerId) -> usize {
    match parent.regular_valence() {
        Some(4) => c.index() & 3,
        Some(_) => 0,
        None => {
            let range = parent.range(parent.face_of(c));
            if range.len() == 4 { c.index() - range.start } else { 0 }
        }
    }
}

/// The values of all corners of the child quads: `own` at a parent corner, `middle` on the edge after it, `centre` in a
/// face.
pub fn child_quads_of<T: Copy + Send>(
    parent: &Faces,
    own: impl Fn(CornerId) -> T + Sync,
    middle: impl Fn(CornerId) -> T + Sync,
    centre: impl Fn(FaceId) -> T + Sync,
) -> Vec<T> {
    if parent.regular_valence() != Some(4) {
        let quad = |c| [own(c), middle(c), centre(parent.face_of(c)), middle(parent.prev(c))];
        return child_corners(parent, quad);
    }
    let quads = |face: usize| {
        let corners = [0, 1, 2, 3].map(|k| CornerId::new(4 * face + k));
        let ([a, b, c, d], [ab, bc, cd, da], e) = (corners.map(&own), corners.map(&middle), centre(FaceId::new(face)));
        [[a, ab, e, da], [ab, b, bc, e], [e, bc, c, cd], [da, e, cd, d]]
    };
    let faces = (0..parent.len()).into_par_iter().with_min_len(CORNERS_PER_TASK / 4);
    faces.map(quads).collect::<Vec<[[T; 4]; 4]>>().into_flattened().into_flattened()
}

/// The values of all corners of the child quads. `around` gives those of one child, starting at its parent corner.
fn child_corners<T: Copy + Send>(parent: &Faces, around: impl Fn(CornerId) -> [T; 4] + Sync) -> Vec<T> {
    let quad = |corner: usize| {
        let corner = CornerId::new(corner);
        let [a, b, c, d] = around(corner);
        match position_in_child(parent, corner) {
            0 => [a, b, c, d],
            1 => [d, a, b, c],
            2 => [c, d, a, b],
            _ => [b, c, d, a],
        }
    };
    let corners = (0..parent.corners().len()).into_par_iter().with_min_len(CORNERS_PER_TASK);
    corners.map(quad).collect::<Vec<[T; 4]>>().into_flattened()
}

/// The child faces of a level.
pub fn child_faces(parent: &Level) -> Faces {
    if parent.scheme == Scheme::Loop { child_triangles(parent) } else { child_quads(parent) }
}

fn child_quads(parent: &Level) -> Faces {
    let numbering = Numbering::new(parent);
    let t = &parent.topology;
    let middle = |corner| numbering.of_edge(t.corner_edge[corner]);
    Faces::quads(child_quads_of(&t.faces, |corner| t.faces.vertex(corner), middle, |face| numbering.of_face(face)))
}

fn child_triangles(parent: &Level) -> Faces {
    let numbering = Numbering::new(parent);
    let t = &parent.topology;
    let mut corners = Vec::with_capacity(12 * t.faces.len());
    for face in t.faces.ids() {
        let mut v = t.faces.vertices_of(face).iter().copied();
        let mut e = t.faces.corners_of(face).map(|c| numbering.of_edge(t.corner_edge[c]));
        if let (Some(v0), Some(v1), Some(v2), Some(e0), Some(e1), Some(e2)) =
            (v.next(), v.next(), v.next(), e.next(), e.next(), e.next())
        {
            corners.extend([v0, e0, e2, e0, v1, e1, e2, e1, v2, e1, e2, e0]);
        }
    }
    Faces::triangles(corners)
}

/// The refined level, from its `faces`.
pub fn child_level(parent: &Level, faces: Faces) -> Level {
    let topology = match parent.scheme {
        Scheme::Loop => Topology::new(faces, Numbering::new(parent).vertices()),
        _ => quad_topology(parent, faces),
    };
    let numbering = Numbering::new(parent);
    let mut edge_sharpness = IdVec::filled(0.0, topology.edges.len());
    for (edge, &sharpness) in parent.edge_sharpness.enumerated().filter(|(_, s)| **s > 0.0) {
        let middle = numbering.of_edge(edge);
        for end in parent.topology.edges[edge] {
            if let Some(child) = topology.find_edge(end, middle) {
                edge_sharpness[child] = refined_sharpness(sharpness);
            }
        }
    }
    let mut vertex_sharpness = IdVec::filled(0.0, topology.vertex_count());
    for (vertex, &sharpness) in parent.vertex_sharpness.enumerated() {
        vertex_sharpness[vertex] = refined_sharpness(sharpness);
    }
    let rules = child_rules(parent, &topology, &edge_sharpness, &vertex_sharpness);
    Level {
        topology,
        scheme: parent.scheme,
        triangles: parent.triangles,
        sharp_corners: parent.sharp_corners,
        edge_sharpness,
        vertex_sharpness,
        rules,
    }
}

fn child_rules(
    parent: &Level,
    topology: &Topology,
    edge_sharpness: &IdVec<EdgeId, f32>,
    vertex_sharpness: &IdVec<VertexId, f32>,
) -> IdVec<VertexId, Rule> {
    let numbering = Numbering::new(parent);
    let mut rules = IdVec::filled(Rule::Smooth, topology.vertex_count());
    let mut spokes = Vec::new();
    for (vertex, _) in parent.rules.enumerated().filter(|(_, r)| **r != Rule::Smooth) {
        super::level::spokes(topology, vertex, &mut spokes);
        rules[vertex] = Rule::new(vertex_sharpness[vertex], spokes.iter().map(|s| edge_sharpness[s.edge]));
    }
    for (edge, _) in parent.edge_sharpness.enumerated().filter(|(_, s)| refined_sharpness(**s) > 0.0) {
        rules[numbering.of_edge(edge)] = Rule::Crease;
    }
    rules
}

/// The adjacency of the child quads.
///
/// Child edges of corners come first: from the middle of the corner's edge to the face's centre. Two child edges for
/// each parent edge follow, the first at its first vertex.
fn quad_topology(parent: &Level, faces: Faces) -> Topology {
    let t = &parent.topology;
    let numbering = Numbering::new(parent);
    let corners = t.faces.corners().len();
    let half =
        |edge: EdgeId, at: VertexId| EdgeId::new(corners + 2 * edge.index() + usize::from(t.edges[edge][0] != at));

    let corner_edge = || {
        child_corners(&t.faces, |corner| {
            let prev = t.faces.prev(corner);
            let vertex = t.faces.vertex(corner);
            [
                half(t.corner_edge[corner], vertex),
                EdgeId::new(corner.index()),
                EdgeId::new(prev.index()),
                half(t.corner_edge[prev], vertex),
            ]
        })
    };
    let ((corner_edge, edges), (edge_corners, vertex_corners)) = rayon::join(
        || rayon::join(corner_edge, || quad_edges(t, numbering)),
        || rayon::join(|| quad_edge_corners(t), || quad_vertex_corners(t)),
    );
    Topology { corner_edge: corner_edge.into(), edges: edges.into(), edge_corners, vertex_corners, faces }
}

fn quad_edges(t: &Topology, numbering: Numbering) -> Vec<[VertexId; 2]> {
    let mut edges = Vec::with_capacity(t.faces.corners().len() + 2 * t.edges.len());
    edges.extend(
        t.corner_edge.enumerated().map(|(c, &e)| [numbering.of_face(t.faces.face_of(c)), numbering.of_edge(e)]),
    );
    for (edge, &[a, b]) in t.edges.enumerated() {
        edges.extend([[numbering.of_edge(edge), a], [numbering.of_edge(edge), b]]);
    }
    edges
}

fn quad_edge_corners(t: &Topology) -> Csr<EdgeId, CornerId> {
    let corners = t.faces.corners().len();
    let mut offsets = Vec::with_capacity(corners + 2 * t.edges.len() + 1);
    let mut items = Vec::with_capacity(4 * corners);
    offsets.push(0);
    for c in (0..corners).map(CornerId::new) {
        items.extend([child_corner(&t.faces, c, 1), child_corner(&t.faces, t.faces.next(c), 2)]);
        offsets.push(items.len() as u32);
    }
    for (edge, &ends) in t.edges.enumerated() {
        for end in ends {
            for &c in t.edge_corners.row(edge) {
                items.push(if t.faces.vertex(c) == end {
                    child_corner(&t.faces, c, 0)
                } else {
                    child_corner(&t.faces, t.faces.next(c), 3)
                });
            }
            offsets.push(items.len() as u32);
        }
    }
    Csr::from_parts(offsets, items)
}

fn quad_vertex_corners(t: &Topology) -> Csr<VertexId, CornerId> {
    let corners = t.faces.corners().len();
    let mut offsets = Vec::with_capacity(t.vertex_count() + t.faces.len() + t.edges.len() + 1);
    let mut items = Vec::with_capacity(4 * corners);
    offsets.extend_from_slice(t.vertex_corners.offsets());
    items.extend(t.vertex_corners.items().iter().map(|&c| child_corner(&t.faces, c, 0)));
    for face in t.faces.ids() {
        items.extend(t.faces.corners_of(face).map(|c| child_corner(&t.faces, c, 2)));
        offsets.push(items.len() as u32);
    }
    for edge in t.edges.ids() {
        for &c in t.edge_corners.row(edge) {
            items.extend([child_corner(&t.faces, c, 1), child_corner(&t.faces, t.faces.next(c), 3)]);
        }
        offsets.push(items.len() as u32);
    }
    Csr::from_parts(offsets, items)
}
