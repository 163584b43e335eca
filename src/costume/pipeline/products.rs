//! The results of a build.

use crate::binding::Binding;
use crate::cloth::{Cloth, ClothFigures};
use crate::recipe::Recipe;
use crate::stitch::Stitch;
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::Arc;
use tailor::pipeline::{MeshPlan, SimResult, Timing};
use tailor::report::{RenderFigures, SimFigures};
use tailor::sim::RemeshReport;
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
    /// The stitches on the render mesh, by name.
    pub stitches: Arc<BTreeMap<String, Stitch>>,
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

/// The cloth of a simulation mesh.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ClothUpdate {
    /// Its figures.
    pub figures: ClothFigures,
    /// Its warnings.
    pub warnings: Warnings,
}

/// The sizes of the products before they are built.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
#[non_exhaustive]
pub struct Plan {
    /// The recipe with the lengths that would be used.
    pub recipe: Recipe,
    /// The sizes of the two meshes.
    #[serde(flatten)]
    pub meshes: MeshPlan,
    /// The coarser levels of detail.
    pub levels: Vec<Self>,
}
