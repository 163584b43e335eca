//! The garment's cage as manifold, consistently oriented pieces over the same surface.
//!
//! Edges of more than two faces are cut, vertices where several fans meet are duplicated, and faces whose winding disagrees
//! with their neighbours are reversed. Edges and vertices keep their sharpness, so the pieces refine to the same points as
//! the garment.

use tailor_mesh::connectivity::{CornerId, EdgeId, FaceId, Faces, Groups, IdVec, Topology, VertexId};
use tailor_mesh::garment::Mesh;
use tailor_mesh::subdivide::{Channel, Level, child_values};

/// The manifold cage and the garment's elements behind it.
pub struct Manifold {
    /// The level of the cage.
    pub level: Level,
    /// The channel of the constraint UVs, if there is a UV set.
    pub uv_channel: Option<Channel>,
    /// The garment's vertex behind each vertex.
    pub vertex_source: IdVec<VertexId, VertexId>,
    /// The garment's corner behind each corner.
    pub corner_source: IdVec<CornerId, CornerId>,
}

impl Manifold {
    /// The pieces of `garment`, whose unrefined level is `level`.
    pub fn new(garment: &Mesh, level: &Level) -> Self {
        let t = &level.topology;
        let is_reversed = reversed_faces(t);
        let corner_source = corner_sources(t, &is_reversed);
        let loose: Vec<VertexId> = corner_source.iter().map(|&c| t.faces.vertex(c)).collect();
        let counts = || t.faces.ids().map(|f| t.faces.valence(f));
        // Corners connected across manifold edges share a vertex.
        let fans = fans(t, &Faces::mixed(counts(), loose.clone()), &corner_source);
        let mut vertex_source = IdVec::new();
        let mut vertex_of_fan = IdVec::filled(None, fans.len());
        let corners: Vec<VertexId> = fans
            .iter()
            .zip(&loose)
            .map(|(&fan, &source)| *vertex_of_fan[fan].get_or_insert_with(|| vertex_source.push(source)))
            .collect();
        let topology = Topology::new(Faces::mixed(counts(), corners), vertex_source.len());
        let edge_source: IdVec<EdgeId, EdgeId> = topology
            .edges
            .iter()
            .map(|&[a, b]| {
                let source = t.find_edge(vertex_source[a], vertex_source[b]);
                source.unwrap_or_else(|| unreachable!("an edge of a piece is an edge of the cage"))
            })
            .collect();
        let level = like(level, topology, &vertex_source, &edge_source);
        debug_assert_eq!(garment.points.len(), t.vertex_count());
        Self { level, uv_channel: None, vertex_source, corner_source }
    }
}

impl Manifold {
    /// The garment's vertex behind each vertex of the first refinement: for a new one, the first of its edge or face.
    pub fn child_source(&self) -> IdVec<VertexId, VertexId> {
        let (t, own) = (&self.level.topology, &self.vertex_source);
        child_values(&self.level, own, |face| own[t.faces.vertices_of(face)[0]], |edge| own[t.edges[edge][0]])
    }
}

/// The level of the pieces, with the sharpness and rules of the garment's own.
fn like(
    level: &Level,
    topology: Topology,
    vertices: &IdVec<VertexId, VertexId>,
    edges: &IdVec<EdgeId, EdgeId>,
) -> Level {
    Level {
        scheme: level.scheme,
        triangles: level.triangles,
        sharp_corners: level.sharp_corners,
        edge_sharpness: edges.iter().map(|&e| level.edge_sharpness[e]).collect(),
        vertex_sharpness: vertices.iter().map(|&v| level.vertex_sharpness[v]).collect(),
        rules: vertices.iter().map(|&v| level.rules[v]).collect(),
        topology,
    }
}

/// The faces to reverse so that each piece agrees with the majority of its faces. A non-orientable piece is not reversed but
/// cut where its winding disagrees; its edges are sharp there already, as in the garment.
fn reversed_faces(t: &Topology) -> IdVec<FaceId, bool> {
    let mut is_reversed = IdVec::<FaceId, Option<bool>>::filled(None, t.faces.len());
    for seed in t.faces.ids() {
        if is_reversed[seed].is_some() {
            continue;
        }
        is_reversed[seed] = Some(false);
        let mut piece = vec![seed];
        let mut at = 0;
        let mut is_orientable = true;
        while let Some(&face) = piece.get(at) {
            at += 1;
            for corner in t.faces.corners_of(face) {
                let &[a, b] = t.edge_corners.row(t.corner_edge[corner]) else { continue };
                let other = if a == corner { b } else { a };
                let neighbour = t.faces.face_of(other);
                let disagrees = t.faces.vertex(a) == t.faces.vertex(b);
                if is_reversed[neighbour].is_none() {
                    is_reversed[neighbour] = is_reversed[face].map(|own| own != disagrees);
                    piece.push(neighbour);
                }
                is_orientable &= is_reversed[neighbour] == is_reversed[face].map(|own| own != disagrees);
            }
        }
        if !is_orientable {
            piece.iter().for_each(|&f| is_reversed[f] = Some(false));
            continue;
        }
        let minority = piece.iter().filter(|&&f| is_reversed[f] == Some(true)).count();
        if 2 * minority > piece.len() {
            piece.iter().for_each(|&f| is_reversed[f] = is_reversed[f].map(|x| !x));
        }
    }
    is_reversed.iter().map(|t| t.unwrap_or(false)).collect()
}

/// The garment's corner behind each corner of the pieces. Reversed faces run backwards from the same corner.
fn corner_sources(t: &Topology, is_reversed: &IdVec<FaceId, bool>) -> IdVec<CornerId, CornerId> {
    t.faces
        .ids()
        .flat_map(|face| {
            let range = t.faces.range(face);
            let (first, n) = (range.start, range.len());
            let is_reversed_face = is_reversed[face];
            (0..n).map(move |k| CornerId::new(if is_reversed_face { first + (n - k) % n } else { first + k }))
        })
        .collect()
}

/// For each corner the first one of its fan: the corners connected across edges of two faces with the same winding.
fn fans(t: &Topology, faces: &Faces, source: &IdVec<CornerId, CornerId>) -> Vec<CornerId> {
    // The half-edges of the pieces on each edge of the garment.
    let mut halves = IdVec::<EdgeId, Vec<CornerId>>::filled(Vec::new(), t.edges.len());
    for corner in faces.corners().ids() {
        let back = faces.next(corner);
        // In a reversed face the garment's half-edge runs from the next corner to this one.
        let (own, next) = (source[corner], source[back]);
        let edge = if t.faces.next(own) == next { t.corner_edge[own] } else { t.corner_edge[next] };
        halves[edge].push(corner);
    }
    let mut fans = Groups::<CornerId>::new(faces.corners().len());
    for row in halves.iter() {
        let &[a, b] = row.as_slice() else { continue };
        if faces.vertex(a) == faces.vertex(b) {
            continue;
        }
        fans.join(a, faces.next(b));
        fans.join(faces.next(a), b);
    }
    faces.corners().ids().map(|c| fans.first(c)).collect()
}
