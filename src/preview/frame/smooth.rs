//! Refinement for display alone.

use std::sync::Arc;
use tailor::render::{RenderOptions, RenderSteps, Stack};
use tailor_mesh::connectivity::{CornerId, FaceId, Faces};
use tailor_mesh::error::Error;
use tailor_mesh::garment::{Mesh, Scheme};
use tailor_mesh::subdivide::{Level, child_corner};

/// A mesh as it is drawn.
#[derive(Clone)]
pub struct Drawn {
    /// The mesh or a refinement of it.
    pub mesh: Arc<Mesh>,
    /// Where the refinement comes from; `None` for the mesh itself.
    pub origin: Option<Arc<Origin>>,
}

/// The elements of a mesh that a refinement comes from.
pub struct Origin {
    faces: Faces,
    levels: u32,
    /// The mesh's face of each refined face.
    pub face_of: Vec<u32>,
    /// For each refined corner, 1 if the edge to the next corner is on an edge of the mesh.
    pub edges: Vec<u8>,
}

impl Drawn {
    /// The mesh after `levels` refinements. `last` is what was drawn before.
    ///
    /// # Errors
    /// A refinement that would be too large.
    pub fn new(mesh: &Arc<Mesh>, levels: u32, last: Option<&Drawn>) -> Result<Self, Error> {
        if levels == 0 {
            return Ok(Self { mesh: Arc::clone(mesh), origin: None });
        }
        let stack = Stack::new(&RenderOptions { level: levels, ..RenderOptions::default() }, &[])?;
        let refined = RenderSteps::new(Arc::clone(mesh)).update(&stack)?.mesh;
        let known = last.and_then(|last| last.origin.as_ref());
        let origin = match known.filter(|origin| origin.levels == levels && origin.faces == mesh.faces) {
            Some(origin) => Arc::clone(origin),
            None => Arc::new(Origin::new(mesh, levels)),
        };
        Ok(Self { mesh: refined, origin: Some(origin) })
    }
}

impl Origin {
    fn new(mesh: &Mesh, levels: u32) -> Self {
        let mut level = Level::base(mesh);
        let mut edges = vec![1; mesh.faces.corners().len()];
        let mut face_of: Vec<u32> = (0..mesh.faces.len() as u32).collect();
        for _ in 0..levels {
            let child = level.refined();
            let faces = child.topology.faces.ids();
            let parent = |face: FaceId| level.topology.faces.face_of(level.corner_of_child(face));
            face_of = faces.map(|face| face_of[parent(face).index()]).collect();
            edges = child_edges(&level, &child, &edges);
            level = child;
        }
        Self { faces: mesh.faces.clone(), levels, face_of, edges }
    }
}

/// The marks of child corners: each parent edge becomes two edges with its mark, and new edges have none.
fn child_edges(parent: &Level, child: &Level, edges: &[u8]) -> Vec<u8> {
    let mut marks = vec![0; child.topology.faces.corners().len()];
    let faces = &parent.topology.faces;
    let mut mark = |at: CornerId, parent: CornerId| marks[at.index()] = edges[parent.index()];
    for corner in faces.ids().flat_map(|face| faces.corners_of(face)) {
        let previous = faces.prev(corner);
        if parent.scheme == Scheme::Loop {
            // Child j of a triangle has corner j at position j.
            let (face, j) = (corner.index() / 3, corner.index() % 3);
            let first = 3 * (4 * face + j);
            mark(CornerId::new(first + j), corner);
            mark(CornerId::new(first + (j + 2) % 3), previous);
        } else {
            mark(child_corner(faces, corner, 0), corner);
            mark(child_corner(faces, corner, 3), previous);
        }
    }
    marks
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use tailor_mesh::connectivity::Topology;

    /// Undirected marked edges.
    fn marked(faces: &Faces, edges: &[u8]) -> BTreeSet<[usize; 2]> {
        let corners = faces.ids().flat_map(|face| faces.corners_of(face));
        let of_corner = corners.filter(|corner| edges[corner.index()] == 1).map(|corner| {
            let [a, b] = faces.half_edge(corner).map(|v| v.index());
            [a.min(b), a.max(b)]
        });
        of_corner.collect()
    }

    #[test]
    fn every_edge_of_the_mesh_is_a_path_of_marked_edges_and_nothing_else_is_marked() {
        for (scheme, faces) in [
            (
                Scheme::CatmullClark,
                Faces::mixed([4, 3], [0, 1, 4, 3, 1, 2, 4].map(tailor_mesh::connectivity::VertexId::new).to_vec()),
            ),
            (Scheme::Loop, Faces::triangles([0, 1, 3, 1, 2, 3].map(tailor_mesh::connectivity::VertexId::new).to_vec())),
        ] {
            let points = (0..5).map(|i| glam::Vec3::new(i as f32, (i * i) as f32, 0.0)).collect::<Vec<_>>();
            let rules = tailor_mesh::garment::SubdivisionRules { scheme, ..Default::default() };
            let mesh = Arc::new(Mesh { points: points.into(), faces, rules, ..Mesh::default() });
            let of_mesh = Topology::new(mesh.faces.clone(), mesh.points.len()).edges.len();
            for levels in 1..=2 {
                let drawn = Drawn::new(&mesh, levels, None).expect("a small mesh");
                let origin = drawn.origin.expect("a refinement");
                assert_eq!(marked(&drawn.mesh.faces, &origin.edges).len(), of_mesh << levels, "{scheme:?} {levels}");
                assert_eq!(origin.face_of.len(), drawn.mesh.faces.len());
                assert!(origin.face_of.iter().all(|&face| (face as usize) < mesh.faces.len()));
            }
        }
    }
}
