//! The results of a build.

use super::progress::Timing;
use super::sim::SimResult;
use crate::binding::Binding;
use crate::cloth::{Cloth, ClothFigures};
use crate::recipe::Recipe;
use rayon::prelude::*;
use serde::Serialize;
use std::sync::Arc;
use tailor::report::{RenderFigures, SimFigures, TriangleQuality};
use tailor::sim::RemeshReport;
use tailor_mesh::connectivity::{FaceId, IdVec};
use tailor_mesh::error::Warnings;
use tailor_mesh::garment::Mesh;
use tailor_mesh::garment::parts::{Part, split};

/// The products of one update.
#[derive(Clone)]
#[non_exhaustive]
pub struct Products {
    /// The simulation mesh.
    pub sim: Arc<Mesh>,
    /// The render mesh.
    pub render: Arc<Mesh>,
    /// The simulation mesh as cloth; none where `cloth.physics` is empty.
    pub cloth: Option<Arc<Cloth>>,
    /// The places of the render mesh's points on the simulation mesh.
    pub binding: Arc<Binding>,
    /// The places of the garment's own points on the simulation mesh.
    pub cage_binding: Arc<Binding>,
    /// The coarser levels of detail, which are not cloth. Their warnings are of their own meshes.
    pub levels: Vec<Self>,
    /// The places of the render mesh's points on the simulation mesh of each level of detail; empty for one level.
    pub level_bindings: Vec<Arc<Binding>>,
    /// The recipe with the lengths that were used.
    pub recipe: Recipe,
    /// The operators of the render mesh, in their order.
    pub operators: Vec<String>,
    /// Names of the face sets that they made.
    pub operator_sets: Vec<String>,
    /// Warnings of the mesh and of both products.
    pub warnings: Warnings,
    /// Time of each step; one that was not repeated takes nearly none.
    pub timings: Vec<Timing>,
    pub(crate) simulated: Arc<SimResult>,
}

impl Products {
    /// The quality figures of the simulation mesh.
    pub fn sim_figures(&self) -> SimFigures {
        self.simulated.figures()
    }

    /// The render mesh in parts, one for each of the face sets `panels`, which have all its faces between them.
    pub fn render_panels(&self, panels: &[String]) -> Vec<RenderPanel> {
        let parts = split(&self.render, panels).into_iter();
        let panel = |part: Part| {
            let level_bindings = self.level_bindings.iter().map(|all| Arc::new(all.of_points(&part.vertices)));
            RenderPanel {
                binding: self.binding.of_points(&part.vertices),
                level_bindings: level_bindings.collect(),
                mesh: part.mesh,
            }
        };
        parts.map(panel).collect()
    }

    /// The figures of the render mesh.
    pub fn render_figures(&self) -> RenderFigures {
        RenderFigures::new(&self.render)
    }

    /// The figures of the cloth.
    pub fn cloth_figures(&self) -> Option<ClothFigures> {
        self.cloth.as_ref().map(|cloth| cloth.figures(&self.simulated.mesh))
    }

    /// The counts of the remesher.
    pub fn remesh(&self) -> &RemeshReport {
        &self.simulated.remeshed.product.report
    }
}

/// The part of a render mesh that one panel has.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RenderPanel {
    /// The part as a mesh.
    pub mesh: Mesh,
    /// The places of its points on the simulation mesh.
    pub binding: Binding,
    /// Their places on the simulation mesh of each level of detail; empty for one level.
    pub level_bindings: Vec<Arc<Binding>>,
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
    pub(super) simulated: Arc<SimResult>,
}

impl SimUpdate {
    /// The quality figures.
    pub fn figures(&self) -> SimFigures {
        self.simulated.figures()
    }

    /// The face of [`Builder::garment`](super::Builder::garment) under the centroid of each triangle.
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

/// The cloth of a simulation mesh.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ClothUpdate {
    /// Its figures.
    pub figures: ClothFigures,
    /// Its warnings.
    pub warnings: Warnings,
}

/// The render mesh of one update.
#[derive(Clone)]
#[non_exhaustive]
pub struct RenderUpdate {
    /// The mesh.
    pub mesh: Arc<Mesh>,
    /// The face of [`Builder::garment`](super::Builder::garment) that each of its faces is part of.
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

/// The sizes of the products before they are built.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
#[non_exhaustive]
pub struct Plan {
    /// The recipe with the lengths that would be used.
    pub recipe: Recipe,
    /// Triangles that the target lengths ask for, all of them equilateral.
    pub expected_faces: usize,
    /// Constraint chains.
    pub chains: usize,
    /// Faces of the render mesh.
    pub render_faces: usize,
    /// Refinements before the first seam. \[levels\]
    pub seam_level: u32,
    /// The coarser levels of detail.
    pub levels: Vec<Self>,
}
