//! The two meshes of a build.

use super::progress::Timing;
use super::sim::SimResult;
use crate::recipe::MeshRecipe;
use crate::report::{RenderFigures, SimFigures, TriangleQuality};
use crate::sim::RemeshReport;
use rayon::prelude::*;
use std::sync::Arc;
use tailor_mesh::connectivity::{FaceId, IdVec};
use tailor_mesh::error::Warnings;
use tailor_mesh::garment::Mesh;

/// The two meshes of one update.
#[derive(Clone)]
#[non_exhaustive]
pub struct Meshes {
    /// The simulation mesh.
    pub sim: Arc<Mesh>,
    /// The render mesh.
    pub render: Arc<Mesh>,
    /// The recipe with the lengths that were used.
    pub recipe: MeshRecipe,
    /// The operators of the render mesh, in their order.
    pub operators: Vec<String>,
    /// Names of the face sets that they made.
    pub operator_sets: Vec<String>,
    /// Warnings of the garment and of both meshes.
    pub warnings: Warnings,
    /// Time of each step; one that was not repeated takes nearly none.
    pub timings: Vec<Timing>,
    pub(super) simulated: Arc<SimResult>,
}

impl Meshes {
    /// The quality figures of the simulation mesh.
    pub fn sim_figures(&self) -> SimFigures {
        self.simulated.figures()
    }

    /// The figures of the render mesh.
    pub fn render_figures(&self) -> RenderFigures {
        RenderFigures::new(&self.render)
    }

    /// The counts of the remesher.
    pub fn remesh(&self) -> &RemeshReport {
        &self.simulated.remeshed.product.report
    }
}

/// The simulation mesh of one update.
#[derive(Clone)]
#[non_exhaustive]
pub struct SimUpdate {
    /// The mesh.
    pub mesh: Arc<Mesh>,
    /// Its warnings.
    pub warnings: Warnings,
    /// Time of each step that was repeated.
    pub timings: Vec<Timing>,
    /// The result of its step, from which more is made.
    pub simulated: Arc<SimResult>,
}

impl SimUpdate {
    /// The quality figures.
    pub fn figures(&self) -> SimFigures {
        self.simulated.figures()
    }

    /// The face of [`MeshBuilder::garment`](super::MeshBuilder::garment) under the centroid of each triangle.
    pub fn sources(&self) -> IdVec<FaceId, FaceId> {
        let product = &self.simulated.remeshed.product;
        let sources = (0..product.triangles.len()).into_par_iter().map(|i| product.source_face(FaceId::new(i)));
        sources.collect::<Vec<_>>().into()
    }

    /// The smallest angle and the length of the edges of each triangle.
    pub fn triangle_quality(&self) -> TriangleQuality {
        TriangleQuality::new(&self.simulated.remeshed.product)
    }
}

/// The render mesh of one update.
#[derive(Clone)]
#[non_exhaustive]
pub struct RenderUpdate {
    /// The mesh.
    pub mesh: Arc<Mesh>,
    /// The face of [`MeshBuilder::garment`](super::MeshBuilder::garment) that each of its faces is part of.
    pub sources: Arc<IdVec<FaceId, FaceId>>,
    /// The operators, in their order.
    pub operators: Vec<String>,
    /// Names of the face sets that they made.
    pub operator_sets: Vec<String>,
    /// Refinements before the first seam. \[levels\]
    pub seam_level: u32,
    /// Its warnings.
    pub warnings: Warnings,
    /// Time of the step.
    pub timings: Vec<Timing>,
}
