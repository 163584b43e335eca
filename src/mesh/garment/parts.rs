//! Parts of a mesh as meshes of their own.

use super::{Corner, Crease, Interpolation, Mesh, Primvar, Subset};
use crate::connectivity::{CornerId, Elements, FaceId, Faces, IdVec, VertexId};
use std::collections::HashSet;
use std::sync::Arc;

/// A part of a mesh.
#[derive(Clone, Debug)]
pub struct Part {
    /// The part as a mesh.
    pub mesh: Mesh,
    /// The vertex of the whole mesh behind each of its vertices.
    pub vertices: Vec<VertexId>,
}

/// Parts a mesh by face sets, which have all faces between them: one part for each set, in their order. Vertices and edges
/// between two sets are in both parts. A face in none of the sets and a point of no face are in the first part.
///
/// No sets give no parts. A subset is in the parts that have some of its elements. Primvars keep their values; a part has the indices of its own
/// elements.
pub fn split(mesh: &Mesh, sets: &[String]) -> Vec<Part> {
    if sets.is_empty() {
        return Vec::new();
    }
    let mut part_of = IdVec::<FaceId, usize>::filled(0, mesh.faces.len());
    for (part, name) in sets.iter().enumerate().rev() {
        if let Some(Elements::Faces(faces)) = mesh.subset(name).map(|set| &set.elements) {
            faces.iter().for_each(|&face| part_of[face] = part);
        }
    }
    let mut faces = vec![Vec::new(); sets.len()];
    part_of.enumerated().for_each(|(face, &part)| faces[part].push(face));
    let mut is_loose = IdVec::<VertexId, bool>::filled(true, mesh.points.len());
    mesh.faces.corners().iter().for_each(|&v| is_loose[v] = false);
    let none = IdVec::filled(false, mesh.points.len());
    let parts = faces.iter().enumerate();
    parts.map(|(part, faces)| Cut::new(mesh, faces, if part == 0 { &is_loose } else { &none }).part()).collect()
}

/// A part by the elements of the whole mesh.
struct Cut<'a> {
    whole: &'a Mesh,
    faces: &'a [FaceId],
    corners: Vec<CornerId>,
    vertices: Vec<VertexId>,
    new_face: IdVec<FaceId, Option<FaceId>>,
    new_vertex: IdVec<VertexId, Option<VertexId>>,
    /// The edges of its faces, each with its lower vertex of the whole mesh first.
    edges: HashSet<[VertexId; 2]>,
}

impl<'a> Cut<'a> {
    /// The part of some faces, and of some points besides theirs.
    fn new(whole: &'a Mesh, faces: &'a [FaceId], points: &IdVec<VertexId, bool>) -> Self {
        let mut is_used = points.clone();
        let mut new_face = IdVec::filled(None, whole.faces.len());
        let mut edges = HashSet::new();
        for (number, &face) in faces.iter().enumerate() {
            new_face[face] = Some(FaceId::new(number));
            let vertices = whole.faces.vertices_of(face);
            for (&a, &b) in vertices.iter().zip(vertices.iter().cycle().skip(1)) {
                is_used[a] = true;
                edges.insert([a.min(b), a.max(b)]);
            }
        }
        let vertices: Vec<VertexId> = is_used.enumerated().filter(|(_, used)| **used).map(|(v, _)| v).collect();
        let mut new_vertex = IdVec::filled(None, whole.points.len());
        vertices.iter().enumerate().for_each(|(number, &v)| new_vertex[v] = Some(VertexId::new(number)));
        let corners = faces.iter().flat_map(|&face| whole.faces.corners_of(face)).collect();
        Self { whole, faces, corners, vertices, new_face, new_vertex, edges }
    }

    fn part(self) -> Part {
        let whole = self.whole;
        let corners: IdVec<CornerId, VertexId> =
            self.corners.iter().filter_map(|&c| self.new_vertex[whole.faces.corners()[c]]).collect();
        let corner = |c: &Corner| Some(Corner { vertex: self.new_vertex[c.vertex]?, sharpness: c.sharpness });
        let mesh = Mesh {
            points: self.vertices.iter().map(|&v| whole.points[v]).collect(),
            faces: Faces::mixed(self.faces.iter().map(|&face| whole.faces.valence(face)), corners),
            holes: whole.holes.iter().filter_map(|&face| self.new_face[face]).collect(),
            creases: whole.creases.iter().flat_map(|crease| self.creases(crease)).collect(),
            corners: whole.corners.iter().filter_map(corner).collect(),
            primvars: Arc::new(whole.primvars.iter().map(|primvar| self.primvar(primvar)).collect()),
            subsets: Arc::new(whole.subsets.iter().filter_map(|set| self.subset(set)).collect()),
            influences: None,
            ..whole.clone()
        };
        Part { mesh, vertices: self.vertices }
    }

    /// An edge of the whole mesh, if it is one of the part.
    fn edge(&self, [a, b]: [VertexId; 2]) -> Option<[VertexId; 2]> {
        let is_own = self.edges.contains(&[a.min(b), a.max(b)]);
        is_own.then_some([self.new_vertex[a]?, self.new_vertex[b]?])
    }

    /// The runs of a crease along edges of the part.
    fn creases(&self, crease: &Crease) -> Vec<Crease> {
        let mut runs: Vec<Crease> = Vec::new();
        let mut is_going_on = false;
        for (ends, &sharpness) in crease.vertices.windows(2).zip(&crease.sharpnesses) {
            let edge = self.edge([ends[0], ends[1]]);
            match (edge, runs.last_mut().filter(|_| is_going_on)) {
                (Some([_, b]), Some(run)) => {
                    run.vertices.push(b);
                    run.sharpnesses.push(sharpness);
                }
                (Some([a, b]), None) => runs.push(Crease { vertices: vec![a, b], sharpnesses: vec![sharpness] }),
                (None, _) => {}
            }
            is_going_on = edge.is_some();
        }
        runs
    }

    fn primvar(&self, primvar: &Primvar) -> Primvar {
        let elements: Vec<usize> = match primvar.interpolation {
            Interpolation::Constant => return primvar.clone(),
            Interpolation::Uniform => self.faces.iter().map(|face| face.index()).collect(),
            Interpolation::Varying | Interpolation::Vertex => self.vertices.iter().map(|v| v.index()).collect(),
            Interpolation::FaceVarying => self.corners.iter().map(|c| c.index()).collect(),
        };
        match &primvar.indices {
            Some(indices) => {
                let indices = elements.iter().map(|&element| indices[element]).collect();
                Primvar { indices: Some(Arc::new(indices)), ..primvar.clone() }
            }
            None => {
                Primvar { values: primvar.values.gather(primvar.width(), elements.iter().copied()), ..primvar.headed() }
            }
        }
    }

    /// The elements of a subset that are in the part; none where all of them are elsewhere.
    fn subset(&self, set: &Subset) -> Option<Subset> {
        let elements = match &set.elements {
            Elements::Faces(faces) => Elements::Faces(faces.iter().filter_map(|&face| self.new_face[face]).collect()),
            Elements::Edges(edges) => Elements::Edges(edges.iter().filter_map(|&edge| self.edge(edge)).collect()),
            Elements::Points(points) => Elements::Points(points.iter().filter_map(|&v| self.new_vertex[v]).collect()),
        };
        let is_of_others = elements.is_empty() && !set.elements.is_empty();
        (!is_of_others).then(|| Subset { elements, ..set.clone() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// Two quads beside each other, 0-1-4-3 and 1-2-5-4, and a point of no face.
    fn pair() -> Mesh {
        let set = |name: &str, elements| Subset { name: name.into(), family: String::new(), elements, sharpness: None };
        let primvar = |interpolation, values: Vec<f32>, indices: Option<Vec<u32>>| Primvar {
            name: format!("{interpolation:?}"),
            interpolation,
            ..Primvar::of_corners(values, indices)
        };
        let v = VertexId::new;
        Mesh {
            points: (0..7).map(|i| Vec3::new((i % 3) as f32, (i / 3) as f32, 0.0)).collect(),
            faces: Faces::quads([0, 1, 4, 3, 1, 2, 5, 4].map(v).to_vec()),
            creases: vec![Crease { vertices: [0, 1, 4, 5].map(v).to_vec(), sharpnesses: vec![1.0, 2.0, 3.0] }],
            corners: vec![Corner { vertex: v(2), sharpness: 4.0 }],
            primvars: Arc::new(vec![
                primvar(Interpolation::Uniform, vec![10.0, 20.0], None),
                primvar(Interpolation::Vertex, (0..7).map(|i| i as f32).collect(), None),
                primvar(Interpolation::FaceVarying, vec![7.0, 8.0], Some(vec![0, 0, 1, 1, 1, 1, 0, 0])),
            ]),
            subsets: Arc::new(vec![
                set("left", Elements::Faces(vec![FaceId::new(0)])),
                set("right", Elements::Faces(vec![FaceId::new(1)])),
                set("sewn", Elements::Edges(vec![[v(4), v(1)]])),
                set("tip", Elements::Points(vec![v(2)])),
            ]),
            ..Mesh::default()
        }
    }

    fn names(part: &Part) -> Vec<&str> {
        part.mesh.subsets.iter().map(|set| set.name.as_str()).collect()
    }

    #[test]
    fn each_part_has_its_own_elements_and_what_lies_between() {
        let parts = split(&pair(), &["left".to_owned(), "right".to_owned()]);
        let [left, right] = parts.as_slice() else { panic!("two parts") };
        let old = |part: &Part| part.vertices.iter().map(|v| v.index()).collect::<Vec<_>>();
        assert_eq!((old(left), old(right)), (vec![0, 1, 3, 4, 6], vec![1, 2, 4, 5]));
        assert_eq!((names(left), names(right)), (vec!["left", "sewn"], vec!["right", "sewn", "tip"]));
        assert_eq!(right.mesh.corners[0].vertex, VertexId::new(1));
        let creases = |part: &Part| part.mesh.creases.iter().map(|c| c.sharpnesses.clone()).collect::<Vec<_>>();
        assert_eq!((creases(left), creases(right)), (vec![vec![1.0, 2.0]], vec![vec![2.0, 3.0]]));
    }

    #[test]
    fn every_corner_keeps_its_place_and_its_values() {
        let whole = pair();
        for (face, part) in split(&whole, &["left".to_owned(), "right".to_owned()]).iter().enumerate() {
            for k in 0..4 {
                let (old, new) = (CornerId::new(4 * face + k), CornerId::new(k));
                let at = part.mesh.faces.corners()[new];
                assert_eq!(part.vertices[at.index()], whole.faces.corners()[old]);
                for (a, b) in whole.primvars.iter().zip(part.mesh.primvars.iter()) {
                    let element = |corner: CornerId, vertex: VertexId, face: usize| match a.interpolation {
                        Interpolation::Uniform => face,
                        Interpolation::Vertex => vertex.index(),
                        _ => corner.index(),
                    };
                    let rows = [
                        a.values.gather(1, std::iter::once(a.row(element(old, whole.faces.corners()[old], face)))),
                        b.values.gather(1, std::iter::once(b.row(element(new, at, 0)))),
                    ];
                    assert_eq!(rows[0], rows[1], "{}", a.name);
                }
            }
        }
    }
}
