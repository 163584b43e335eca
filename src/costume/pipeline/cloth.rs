//! The steps from both meshes to cloth and binding.

use crate::binding::Binding;
use crate::cloth::{Cloth, ClothOptions, FabricOptions, Pattern};
use crate::fit::PanelRest;
use crate::recipe::Recipe;
use std::collections::BTreeMap;
use std::sync::Arc;
use tailor::pipeline::{Clock, SimResult};
use tailor::render::Origins;
use tailor_mesh::error::{Error, Warnings};
use tailor_mesh::garment::Mesh;
use tailor_mesh::step::{Same, Step};

/// The simulation mesh, its UV set, whether its pattern is kept, and the options of cloth and fabrics.
type ClothInput = (Same<SimResult>, (String, bool), ClothOptions, BTreeMap<String, FabricOptions>);

/// The binding of a render mesh to a simulation mesh.
pub type BindingStep = Step<(Same<SimResult>, Same<Mesh>), Arc<Binding>>;

/// The steps of one garment.
pub struct ClothSteps {
    pub(super) garment: Arc<Mesh>,
    mean_edge: f32,
    cloth: Step<ClothInput, (Arc<Cloth>, Warnings)>,
    binding: BindingStep,
    /// The bindings to the simulation meshes of all levels of detail.
    pub(super) level_bindings: Vec<BindingStep>,
    cage_binding: Step<Same<SimResult>, Arc<Binding>>,
}

impl ClothSteps {
    /// The steps of a garment with its mean edge length.
    pub fn new(garment: Arc<Mesh>, mean_edge: f32) -> Self {
        let (cloth, binding, cage_binding) = Default::default();
        Self { garment, mean_edge, cloth, binding, level_bindings: Vec::new(), cage_binding }
    }

    /// The cloth of a resolved recipe, with its warnings; none without physics.
    pub fn cloth(
        &mut self,
        recipe: &Recipe,
        simulated: &Arc<SimResult>,
        clock: &mut Clock<'_>,
    ) -> Result<Option<(Arc<Cloth>, Warnings)>, Error> {
        if recipe.cloth.physics.is_empty() {
            return Ok(None);
        }
        let (garment, mean_edge) = (&self.garment, self.mean_edge);
        let panels = (recipe.sim.uv_set.clone(), recipe.fit.rest == PanelRest::Pattern);
        let input = (Same::from(simulated), panels, recipe.cloth.clone(), recipe.fabric.clone());
        let cloth = self.cloth.get(input, |(simulated, (uv_set, is_kept), options, fabrics)| {
            let product = &simulated.remeshed.product;
            let pattern = Pattern { uv_set, is_kept: *is_kept };
            let cloth = || Cloth::new(options, fabrics, garment, product, &simulated.mesh, pattern, mean_edge);
            clock.run("cloth", cloth).map(|(cloth, warnings)| (Arc::new(cloth), warnings))
        })?;
        Ok(Some(cloth))
    }

    /// The binding of a render mesh, whose `origins` are computed if they are needed.
    pub fn binding(
        &mut self,
        simulated: &Arc<SimResult>,
        render: &Arc<Mesh>,
        origins: impl FnOnce() -> Result<Origins, Error>,
        clock: &mut Clock<'_>,
    ) -> Result<Arc<Binding>, Error> {
        let garment = &self.garment;
        self.binding.get((Same::from(simulated), Same::from(render)), |(simulated, render)| {
            clock.run("binding", || Ok(Arc::new(bound(garment, simulated, render, &origins()?))))
        })
    }

    /// The binding of the garment's own points, whose `origins` are computed if they are needed.
    pub fn cage_binding(
        &mut self,
        simulated: &Arc<SimResult>,
        origins: impl FnOnce() -> Result<Origins, Error>,
    ) -> Result<Arc<Binding>, Error> {
        let garment = &self.garment;
        self.cage_binding
            .get(Same::from(simulated), |simulated| Ok(Arc::new(bound(garment, simulated, garment, &origins()?))))
    }

    /// An estimate of the memory of the kept results. \[bytes\]
    pub fn bytes(&self) -> usize {
        let cloth = self.cloth.last().map_or(0, |(cloth, _)| cloth.bytes());
        let of_levels = self.level_bindings.iter().filter_map(Step::last);
        let bindings = [self.binding.last(), self.cage_binding.last()];
        cloth + bindings.into_iter().flatten().chain(of_levels).map(|binding| binding.bytes()).sum::<usize>()
    }
}

/// The places of the points of a mesh, with these origins, on a simulation mesh of the garment. All are in one frame.
pub fn bound(garment: &Mesh, simulated: &SimResult, mesh: &Mesh, origins: &Origins) -> Binding {
    Binding::new(&simulated.remeshed.product, garment.faces.len(), &simulated.mesh, mesh, origins)
}
