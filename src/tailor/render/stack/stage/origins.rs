//! Where the vertices of the render mesh lie on the garment.

use super::{SourceFaces, StageSteps, Start, connectivity};
use crate::contact::each_once;
use crate::render::stack::Stage;
use glam::Vec3;
use std::sync::Arc;
use tailor_mesh::connectivity::{Csr, FaceId, Faces, IdVec, VertexId};
use tailor_mesh::error::Error;
use tailor_mesh::garment::Mesh;
use tailor_mesh::subdivide::{Derivation, carried_points};

/// The origin of each vertex of a render mesh on the limit surface of its garment.
pub struct Origins {
    /// The position without the heights of operators. All layers of a hem have that of the first. \[mesh units\]
    pub points: IdVec<VertexId, Vec3>,
    /// Faces of the garment around each vertex, each once, ascending.
    pub faces: Csr<VertexId, FaceId>,
}

/// The origins of a mesh between two stages.
pub struct OriginTrace {
    /// Points without heights.
    points: IdVec<VertexId, Vec3>,
    faces: Faces,
    /// Vertices with their copies on second layers.
    copies: Vec<[VertexId; 2]>,
}

impl OriginTrace {
    /// The garment itself.
    pub fn first(garment: &Mesh) -> Self {
        Self { points: garment.points.clone(), faces: garment.faces.clone(), copies: Vec::new() }
    }

    /// The origins at these points, on faces with these sources.
    pub fn origins(self, sources: &SourceFaces) -> Origins {
        let Self { points, faces, .. } = self;
        let around = faces.corners().enumerated().map(|(corner, &v)| (v, sources[faces.face_of(corner)]));
        let around = Csr::group(points.len(), around, FaceId::new(0));
        let (mut offsets, mut once) = (vec![0], Vec::with_capacity(points.len()));
        for vertex in points.ids() {
            once.extend(each_once(around.row(vertex).to_vec()));
            offsets.push(once.len() as u32);
        }
        Origins { faces: Csr::from_parts(offsets, once), points }
    }

    /// Vertices keep their numbers; copies are where their originals are.
    fn join_copies(&mut self) {
        self.copies.iter().for_each(|&[over, copy]| self.points[copy] = self.points[over]);
    }
}

impl StageSteps {
    /// The vertices of a garment on its limit surface.
    ///
    /// # Errors
    /// A mesh whose refinement would be too large.
    pub fn cage_origins(&mut self, start: &Start) -> Result<Origins, Error> {
        let first = self.first_cage(start)?;
        let limits = connectivity(&mut self.first_connectivity, &first.level)?;
        let trace = OriginTrace::first(&first.garment);
        Ok(OriginTrace { points: carried_points(&limits.limits(), &trace.points), ..trace }.origins(&start.sources))
    }

    /// The origins after this stage, whose last [`StageSteps::update`] had the same start. Without refinement, the origins
    /// of the last stage are on the limit surface.
    ///
    /// # Errors
    /// As [`StageSteps::update`].
    pub fn origins(
        &mut self,
        start: &Start,
        stage: &Stage,
        mut trace: OriginTrace,
        is_last: bool,
    ) -> Result<OriginTrace, Error> {
        let stage = &self.with_halving(start, stage)?;
        let (first, _) = self.first(start, stage)?;
        let mut last = connectivity(&mut self.first_connectivity, &first.level)?;
        for steps in self.points.iter_mut().take(stage.operators.len()) {
            let Some(points) = steps.origins(trace.points.clone())? else { break };
            trace.points = IdVec::clone(&points);
            let Some(placement) = steps.placement.last() else { break };
            trace.copies.extend(placement.copy_pairs());
            trace.faces = placement.derivation().faces.clone();
            if let Some(connectivity) = steps.connectivity.last() {
                last = Arc::clone(connectivity);
            }
        }
        let is_limit = is_last && stage.level == 0;
        if is_limit {
            trace.points = carried_points(&last.limits(), &trace.points);
        }
        trace.join_copies();
        for refinement in self.refinements.iter().take(stage.level as usize).filter_map(|steps| steps.last()) {
            trace.points = carried_points(&refinement.vertex(), &trace.points);
            trace.faces = refinement.faces().clone();
        }
        Ok(trace)
    }
}
