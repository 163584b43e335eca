//! Where the front of the input is: it says of the faces of all cages after it whether they are turned over.

use super::derivation::Derivation;
use super::sound::{Skin, twice_area};
use crate::mesh::{FaceId, IdVec, VertexId};
use crate::subdivide::{Cage, Lineage};
use glam::Vec3;
use rayon::prelude::*;

/// Cosine between a child and the front below which faces of the input count as turned over themselves.
const ALREADY_TURNED: f32 = 0.3;

/// The front of the input, at the vertices and faces of a cage.
#[derive(Clone, Debug)]
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
        let (directions, skin) = (front.directions(cage), Skin::new(cage, &garment.points, &all, None));
        for face in all.into_iter().filter(|&face| skin.is_turned(face, directions[face], ALREADY_TURNED)) {
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
    pub fn directions(&self, cage: &Cage) -> IdVec<FaceId, Vec3> {
        let faces = &cage.level().topology.faces;
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
