//! Where the vertices of the render mesh lie on the garment.

use super::{Cage, RenderSteps, connectivity};
use crate::error::Error;
use crate::mesh::{Csr, FaceId, Faces, IdVec, VertexId};
use crate::render::Stack;
use crate::subdivide::{Derivation, carried_points};
use glam::Vec3;
use std::sync::Arc;

/// The origin of each vertex of a render mesh on the limit surface of its garment.
pub struct Origins {
    /// The position without the heights of operators. All layers of a hem have that of the first. \[mesh units\]
    pub points: IdVec<VertexId, Vec3>,
    /// Faces of the garment around each vertex, ascending.
    pub faces: Csr<VertexId, FaceId>,
}

impl Origins {
    /// Origins at `points` of a mesh whose faces have `parents` in the garment.
    fn new(points: IdVec<VertexId, Vec3>, faces: &Faces, parents: &[FaceId]) -> Self {
        let around = faces.corners().enumerated().map(|(corner, &v)| (v, parents[faces.face_of(corner).index()]));
        Self { faces: Csr::group(points.len(), around, FaceId::new(0)), points }
    }
}

impl RenderSteps {
    /// The origins of the garment's own vertices.
    ///
    /// # Errors
    /// A mesh whose refinement would be too large.
    pub fn cage_origins(&mut self) -> Result<Origins, Error> {
        let first = self.first.get_or_insert_with(|| Cage::first(&self.garment)).clone();
        let connectivity = connectivity(&mut self.first_connectivity, &first.level)?;
        let parents: Vec<FaceId> = first.garment.faces.ids().collect();
        let points = carried_points(&connectivity.limits(), &first.garment.points);
        Ok(Origins::new(points, &first.garment.faces, &parents))
    }

    /// The origins of the vertices of the last [`RenderSteps::update`], which had the same stack.
    ///
    /// # Errors
    /// As [`RenderSteps::update`].
    pub fn origins(&mut self, stack: &Stack) -> Result<Origins, Error> {
        let stack = &self.with_halving(stack);
        let (first, mut cage_points) = self.first(stack)?;
        let mut last = connectivity(&mut self.first_connectivity, &first.level)?;
        let mut copies: Vec<[VertexId; 2]> = Vec::new();
        let count = stack.operators.len();
        for (number, steps) in self.points.iter().take(count).enumerate() {
            let Some(placement) = steps.placement.last() else { break };
            // The first operator works on points without heights already.
            cage_points = match steps.flat.last().filter(|_| number == 0) {
                Some(flat) => Arc::new(flat.fitted().clone()),
                None => Arc::new(placement.flat(&cage_points).fitted().clone()),
            };
            let derivation = placement.derivation();
            copies.iter_mut().flatten().for_each(|v| *v = derivation.child_vertex(*v));
            copies.extend(placement.copy_pairs());
            if let Some(connectivity) = steps.connectivity.last() {
                last = Arc::clone(connectivity);
            }
        }
        let cage = self.cages[..count.min(self.cages.len())].last();
        let mut parents: Vec<FaceId> = match cage.and_then(|cage| cage.derived.last()) {
            Some(derived) => derived.ancestry.faces.iter().copied().collect(),
            None => first.garment.faces.ids().collect(),
        };
        let garment = cage.and_then(|cage| cage.garment.last()).map_or(&first.garment, |garment| garment);
        let mut faces = garment.faces.clone();
        let mut points = match stack.level {
            0 => carried_points(&last.limits(), &cage_points.points),
            _ => cage_points.points.clone(),
        };
        copies.iter().for_each(|&[over, copy]| points[copy] = points[over]);
        for refinement in self.refinements.iter().take(stack.level as usize).filter_map(|steps| steps.last()) {
            points = carried_points(&refinement.vertex(), &points);
            faces = refinement.faces().clone();
            parents = faces.ids().map(|face| parents[refinement.parent_face(face).index()]).collect();
        }
        Ok(Origins::new(points, &faces, &parents))
    }
}
