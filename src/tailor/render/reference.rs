//! Reference normals: the normals of the input garment, carried to each cage. A face against its reference is flipped.

use super::child::OperatorDerivation;
use super::repair::FLIPPED_BEFORE;
use crate::contact::{RefinedFaces, twice_area};
use glam::Vec3;
use rayon::prelude::*;
use tailor_mesh::connectivity::{FaceId, Faces, IdVec, VertexId};
use tailor_mesh::garment::Mesh;
use tailor_mesh::subdivide::{Derivation, Level};

/// The reference normals of a cage.
#[derive(Clone, Debug, Default)]
pub struct ReferenceNormals {
    /// The mean of the face normals around each vertex of the input, interpolated to the vertices of the cage.
    normals: IdVec<VertexId, Vec3>,
    /// 1 for faces that should agree with the normals, -1 for faces of a second layer. 0 accepts both directions:
    /// around a fold, and on faces that are flipped in the input.
    signs: IdVec<FaceId, f32>,
}

impl ReferenceNormals {
    /// The normals of a garment.
    pub fn first(garment: &Mesh, level: &Level) -> Self {
        let mut normals = IdVec::filled(Vec3::ZERO, garment.points.len());
        for face in garment.faces.ids() {
            let normal = twice_area(garment.faces.vertices_of(face), &garment.points).normalize_or_zero();
            garment.faces.vertices_of(face).iter().for_each(|&v| normals[v] += normal);
        }
        let normals = normals.iter().map(|sum| sum.normalize_or_zero()).collect();
        let all: Vec<FaceId> = garment.faces.ids().collect();
        let mut reference = Self { normals, signs: IdVec::filled(1.0, all.len()) };
        let surface = RefinedFaces::new(level, level.vertex_rows(), &garment.points, &all, None);
        let directions = reference.directions(&garment.faces);
        for face in all.into_iter().filter(|&face| surface.is_flipped(face, directions[face], FLIPPED_BEFORE)) {
            reference.signs[face] = 0.0;
        }
        reference
    }

    /// The reference normals after an operator; `is_copy` flags the vertices of its second layer.
    pub fn carried(&self, derivation: &OperatorDerivation, is_copy: &IdVec<VertexId, bool>) -> Self {
        let normal = |v: usize| derivation.vertices.at(v).iter().map(|&(p, w)| w * self.normals[p]).sum();
        let sign = |face: FaceId| {
            let vertices = derivation.faces.vertices_of(face);
            let copies = vertices.iter().filter(|&&v| is_copy[v]).count();
            let layer = if copies == 0 { 1.0 } else { -1.0 };
            if 0 < copies && copies < vertices.len() { 0.0 } else { layer * self.signs[derivation.parent_face(face)] }
        };
        Self {
            normals: (0..derivation.vertices.len()).map(normal).collect(),
            signs: derivation.faces.ids().map(sign).collect(),
        }
    }

    /// The unit reference normal of each face; zero where both directions are accepted.
    pub fn directions(&self, faces: &Faces) -> IdVec<FaceId, Vec3> {
        let direction = |face: FaceId| {
            let sum: Vec3 = faces.vertices_of(face).iter().map(|&v| self.normals[v]).sum();
            self.signs[face] * sum.normalize_or_zero()
        };
        (0..faces.len()).into_par_iter().map(|face| direction(FaceId::new(face))).collect::<Vec<_>>().into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::child::ChildBuilder;
    use tailor_mesh::garment::{Scheme, SubdivisionRules};

    fn ids(numbers: &[usize]) -> Vec<VertexId> {
        numbers.iter().map(|&v| VertexId::new(v)).collect()
    }

    /// Two quads in a row, and their reference normals. A negative `x` of the last vertex twists the second quad.
    fn two_quads(x: f32) -> (Mesh, Level, ReferenceNormals) {
        let points = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [2.0, 0.0], [x, 1.0]];
        let garment = Mesh {
            points: points.iter().map(|&[x, y]| Vec3::new(x, y, 0.0)).collect(),
            faces: Faces::quads(ids(&[0, 1, 2, 3, 1, 4, 5, 2])),
            rules: SubdivisionRules { scheme: Scheme::Bilinear, ..SubdivisionRules::default() },
            ..Mesh::default()
        };
        let level = Level::base(&garment);
        let reference = ReferenceNormals::first(&garment, &level);
        (garment, level, reference)
    }

    #[test]
    fn faces_that_are_flipped_in_the_input_may_have_both_directions() {
        let (garment, _, flat) = two_quads(2.0);
        assert_eq!(flat.directions(&garment.faces).as_slice(), [Vec3::Z; 2]);
        let (garment, _, bow_tie) = two_quads(-2.0);
        assert_eq!(bow_tie.directions(&garment.faces).as_slice(), [Vec3::Z, Vec3::ZERO]);
    }

    #[test]
    fn a_second_layer_is_reversed_and_a_fold_may_have_both_directions() {
        let (_, level, reference) = two_quads(2.0);
        let parent = &level.topology;
        let mut builder = ChildBuilder::new(parent);
        let [a, b] = [0, 3].map(|v| builder.vertex(&[(VertexId::new(v), 1.0)]));
        let [c, d] = [1, 2].map(|v| builder.vertex(&[(VertexId::new(v), 1.0)]));
        let first = FaceId::new(0);
        builder.face(first, &ids(&[0, 1, 2, 3]));
        builder.face(first, &[a, b, d, c]);
        let [two, one] = [2, 1].map(VertexId::new);
        builder.face(first, &[two, one, c, d]);
        let derivation = builder.finish();
        let is_copy: IdVec<VertexId, bool> = (0..derivation.vertices.len()).map(|v| v >= 6).collect();
        let carried = reference.carried(&derivation, &is_copy);
        assert_eq!(carried.signs.as_slice(), [1.0, -1.0, 0.0]);
        assert!(carried.normals.iter().all(|&n| n == Vec3::Z));
        // A second layer of the second layer agrees with the normals again.
        let mut builder = ChildBuilder::new(parent);
        builder.face(FaceId::new(1), &ids(&[0, 1, 2, 3]));
        let all = IdVec::filled(true, 6);
        assert_eq!(carried.carried(&builder.finish(), &all).signs.as_slice(), [1.0]);
    }
}
