//! Where the front of the input is: it says of the faces of all cages after it whether they are turned over.

use super::derivation::Derivation;
use super::repair::FLIPPED_BEFORE;
use crate::contact::{RefinedFaces, twice_area};
use crate::mesh::{FaceId, Faces, IdVec, VertexId};
use crate::subdivide::{Cage, Lineage};
use glam::Vec3;
use rayon::prelude::*;

/// The front of the input, at the vertices and faces of a cage.
#[derive(Clone, Debug, Default)]
pub struct Front {
    /// Normals of the input, each the mean of those of the faces around a vertex.
    normals: IdVec<VertexId, Vec3>,
    /// 1 for faces that look along them, -1 for those of a second layer, 0 where either may be: around a fold, and on faces
    /// of the input that are turned over themselves.
    sides: IdVec<FaceId, f32>,
}

impl Front {
    /// The front of a cage before any operator.
    pub fn first(cage: &Cage) -> Self {
        let garment = cage.garment();
        let mut normals = IdVec::filled(Vec3::ZERO, garment.points.len());
        for face in garment.faces.ids() {
            let normal = twice_area(garment.faces.vertices_of(face), &garment.points).normalize_or_zero();
            garment.faces.vertices_of(face).iter().for_each(|&v| normals[v] += normal);
        }
        let normals = normals.iter().map(|sum| sum.normalize_or_zero()).collect();
        let all: Vec<FaceId> = garment.faces.ids().collect();
        let mut front = Self { normals, sides: IdVec::filled(1.0, all.len()) };
        let refined = RefinedFaces::new(cage.level(), cage.level().vertex_rows(), &garment.points, &all, None);
        let directions = front.directions(&garment.faces);
        for face in all.into_iter().filter(|&face| refined.is_flipped(face, directions[face], FLIPPED_BEFORE)) {
            front.sides[face] = 0.0;
        }
        front
    }

    /// The front after an operator, which makes copies of some vertices for a second layer.
    pub fn carried(&self, derivation: &Derivation, is_copy: &IdVec<VertexId, bool>) -> Self {
        let normal = |v: usize| derivation.vertices.at(v).iter().map(|&(p, w)| w * self.normals[p]).sum();
        let side = |face: FaceId| {
            let vertices = derivation.faces.vertices_of(face);
            let copies = vertices.iter().filter(|&&v| is_copy[v]).count();
            let sign = if copies == 0 { 1.0 } else { -1.0 };
            if 0 < copies && copies < vertices.len() { 0.0 } else { sign * self.sides[derivation.parent_face(face)] }
        };
        Self {
            normals: (0..derivation.vertices.len()).map(normal).collect(),
            sides: derivation.faces.ids().map(side).collect(),
        }
    }

    /// Where each face of the cage is to look; zero where either way may be right.
    pub fn directions(&self, faces: &Faces) -> IdVec<FaceId, Vec3> {
        let direction = |face: FaceId| {
            let sum: Vec3 = faces.vertices_of(face).iter().map(|&v| self.normals[v]).sum();
            self.sides[face] * sum.normalize_or_zero()
        };
        (0..faces.len()).into_par_iter().map(|face| direction(FaceId::new(face))).collect::<Vec<_>>().into()
    }

    /// Memory that it holds. \[bytes\]
    pub fn bytes(&self) -> usize {
        size_of_val(self.normals.as_slice()) + size_of_val(self.sides.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::garment::{Garment, Scheme, SubdivisionRules};
    use crate::render::derivation::Builder;

    fn ids(numbers: &[usize]) -> Vec<VertexId> {
        numbers.iter().map(|&v| VertexId::new(v)).collect()
    }

    /// Two quads, of which the second is turned back over the first by a last vertex at `x`.
    fn front(x: f32) -> (Cage, Front) {
        let points = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [2.0, 0.0], [x, 1.0]];
        let cage = Cage::new(Garment {
            points: points.iter().map(|&[x, y]| Vec3::new(x, y, 0.0)).collect(),
            faces: Faces::quads(ids(&[0, 1, 2, 3, 1, 4, 5, 2])),
            rules: SubdivisionRules { scheme: Scheme::Bilinear, ..SubdivisionRules::default() },
            ..Garment::default()
        });
        let front = Front::first(&cage);
        (cage, front)
    }

    #[test]
    fn faces_look_to_the_front_but_for_those_that_are_turned_over() {
        let (cage, flat) = front(2.0);
        assert_eq!(flat.directions(&cage.garment().faces).as_slice(), [Vec3::Z; 2]);
        let (cage, bow_tie) = front(-2.0);
        assert_eq!(bow_tie.directions(&cage.garment().faces).as_slice(), [Vec3::Z, Vec3::ZERO]);
    }

    #[test]
    fn a_second_layer_looks_away_from_the_front_and_a_fold_to_neither_side() {
        let (cage, front) = front(2.0);
        let parent = &cage.level().topology;
        let mut builder = Builder::new(parent);
        let [a, b] = [0, 3].map(|v| builder.vertex(&[(VertexId::new(v), 1.0)]));
        let [c, d] = [1, 2].map(|v| builder.vertex(&[(VertexId::new(v), 1.0)]));
        let first = FaceId::new(0);
        builder.face(first, &ids(&[0, 1, 2, 3]));
        builder.face(first, &[a, b, d, c]);
        let [two, one] = [2, 1].map(VertexId::new);
        builder.face(first, &[two, one, c, d]);
        let derivation = builder.finish();
        let is_copy: IdVec<VertexId, bool> = (0..derivation.vertices.len()).map(|v| v >= 6).collect();
        let carried = front.carried(&derivation, &is_copy);
        assert_eq!(carried.sides.as_slice(), [1.0, -1.0, 0.0]);
        assert!(carried.normals.iter().all(|&n| n == Vec3::Z));
        // A second layer of the second layer looks to the front again.
        let mut again = Builder::new(parent);
        again.face(FaceId::new(1), &ids(&[0, 1, 2, 3]));
        let all = IdVec::filled(true, 6);
        assert_eq!(carried.carried(&again.finish(), &all).sides.as_slice(), [1.0]);
    }
}
