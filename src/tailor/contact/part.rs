//! Part of a cage refined twice.

use super::face::ChildId;
use super::faces::RefinedFaces;
use super::{each_once, faces_at};
use glam::Vec3;
use rayon::prelude::*;
use tailor_mesh::connectivity::{FaceId, IdVec, VertexId};
use tailor_mesh::subdivide::{Level, Numbering};

/// The part of a cage's first refinement on which the children of some children depend, as a cage of its own.
pub struct RefinedPart {
    /// The children that may be asked about, ascending.
    children: Vec<ChildId>,
    /// Each of them as a face of the part.
    faces: Vec<FaceId>,
    level: Level,
    /// The vertices of the part in the refinement of the whole cage.
    pub whole: IdVec<VertexId, VertexId>,
    points: IdVec<VertexId, Vec3>,
}

impl RefinedPart {
    /// The part for the children of some pairs. `point` are the points of the first refinement.
    pub fn new(level: &Level, pairs: &[[ChildId; 2]], point: impl Fn(VertexId) -> Vec3) -> Self {
        let children: Vec<ChildId> = each_once(pairs.iter().flatten().copied().collect());
        let t = &level.topology;
        // Faces further away count by their points alone.
        let vertex = |&(face, number): &ChildId| t.faces.vertices_of(face)[number];
        let parents = faces_at(t, children.iter().map(vertex));
        let (part, own) = level.part(&parents);
        let [of_whole, of_part] = [level, &part].map(Numbering::new);
        let mut whole = IdVec::filled(VertexId::new(0), of_part.vertices());
        own.enumerated().for_each(|(v, &old)| whole[of_part.of_vertex(v)] = of_whole.of_vertex(old));
        part.topology.faces.ids().zip(&parents).for_each(|(f, &old)| whole[of_part.of_face(f)] = of_whole.of_face(old));
        let corners = parents.iter().flat_map(|&f| t.faces.corners_of(f));
        corners.zip(part.topology.corner_edge.iter()).for_each(|(old, &edge)| {
            whole[of_part.of_edge(edge)] = of_whole.of_edge(t.corner_edge[old]);
        });
        let face = |&(face, number): &ChildId| {
            let parent = FaceId::new(parents.partition_point(|&f| f < face));
            // Child faces have the numbers of the parent's corners.
            FaceId::new(part.topology.faces.range(parent).start + number)
        };
        let faces = children.iter().map(face).collect();
        let points = whole.iter().map(|&v| point(v)).collect();
        Self { children, faces, level: part.refined(), whole, points }
    }

    /// The children, refined again.
    pub fn refined(&self) -> RefinedFaces<'_> {
        let mut refined = RefinedFaces::empty(&self.level);
        refined.add(&self.points, self.faces.iter().copied());
        refined
    }

    /// A child as a face of the part.
    pub fn face(&self, child: ChildId) -> FaceId {
        self.faces[self.children.partition_point(|&other| other < child)]
    }

    /// The pairs of children whose own children, `refined`, intersect.
    pub fn intersecting(&self, refined: &RefinedFaces, pairs: &[[ChildId; 2]]) -> Vec<[ChildId; 2]> {
        let intersect = |pair: &&[ChildId; 2]| {
            let [a, b] = pair.map(|child| self.face(child));
            refined.intersect(a, b)
        };
        pairs.par_iter().filter(intersect).copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tailor_mesh::connectivity::Faces;
    use tailor_mesh::garment::{Crease, Mesh};
    use tailor_mesh::subdivide::carried_points;
    use tailor_testing::cage::Cage;

    /// Two pentagons, two triangles and three quads, with a crease.
    fn mixed() -> Cage {
        let places = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [0.0, 1.0], [1.2, 1.1], [2.0, 1.0], [3.0, 1.0]];
        let above = [[0.0, 2.0], [1.0, 2.0], [2.0, 2.0], [3.0, 2.0], [1.0, 3.0]];
        let all = places.into_iter().chain(above).enumerate();
        let points = all.map(|(i, [x, y])| Vec3::new(x, y, (i * i % 7) as f32 / 7.0));
        let faces: [&[usize]; 7] =
            [&[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7], &[2, 7, 6], &[4, 5, 9, 12, 8], &[5, 6, 10, 9], &[6, 7, 11, 10]];
        let corners = faces.iter().flat_map(|face| face.iter().copied().map(VertexId::new));
        let crease = Crease { vertices: [1, 5, 9].map(VertexId::new).to_vec(), sharpnesses: vec![1.5, 3.0] };
        Cage::new(Mesh {
            points: points.collect(),
            faces: Faces::mixed(faces.iter().map(|face| face.len()), corners.collect::<Vec<_>>()),
            creases: vec![crease],
            ..Mesh::default()
        })
    }

    #[test]
    fn a_part_is_refined_as_the_whole_is() {
        let cage = mixed();
        let (level, first) = (cage.level(), carried_points(&cage.level().vertex_rows(), &cage.garment().points));
        let (numbering, whole) = (Numbering::new(level), level.refined());
        let mut expected = RefinedFaces::empty(&whole);
        expected.add(&first, whole.topology.faces.ids());
        let faces = &level.topology.faces;
        for face in faces.ids() {
            for (number, in_whole) in numbering.of_face_within(faces, face).enumerate() {
                let part = RefinedPart::new(level, &[[(face, number); 2]], |v| first[v]);
                let refined = part.refined();
                let in_part = part.face((face, number));
                for child in 0..4 {
                    let (found, right) = (refined.child((in_part, child)), expected.child((in_whole, child)));
                    let same = found.iter().zip(&right).all(|(a, b)| a.abs_diff_eq(*b, 1e-6));
                    assert!(same, "child {child} of {number} of {face:?}: {found:?}, not {right:?}");
                }
            }
        }
    }
}
