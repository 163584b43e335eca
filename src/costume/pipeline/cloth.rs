//! The steps from both meshes to cloth and binding.

use crate::binding::Binding;
use crate::cloth::{Cloth, ClothOptions, FabricOptions, Pattern};
use crate::fit::PanelRest;
use crate::recipe::Recipe;
use std::collections::BTreeMap;
use std::sync::Arc;
use tailor::pipeline::{Clock, MeshBuilder, RemeshResult, SimResult};
use tailor::recipe::MeshRecipe;
use tailor::render::Origins;
use tailor::transfer::Locator;
use tailor_mesh::error::{Error, Warnings};
use tailor_mesh::garment::Mesh;
use tailor_mesh::step::{Same, Step};

/// The simulation mesh, its UV set, whether its pattern is kept, and the options of cloth and fabrics.
type ClothInput = (Same<SimResult>, (String, bool), ClothOptions, BTreeMap<String, FabricOptions>);

/// The binding of a render mesh to a simulation mesh.
pub type BindingStep = Step<(Same<SimResult>, Same<Mesh>), Arc<Binding>>;

/// The steps from a simulation mesh to its cloth.
pub struct ClothSteps {
    garment: Arc<Mesh>,
    mean_edge: f32,
    cloth: Step<ClothInput, (Arc<Cloth>, Warnings)>,
}

/// The steps that bind points to simulation meshes of one garment.
pub struct BindingSteps {
    garment: Arc<Mesh>,
    render: BindingStep,
    /// Those of the render mesh to the simulation meshes of all levels of detail.
    pub(super) levels: Vec<BindingStep>,
    cage: Step<Same<SimResult>, Arc<Binding>>,
}

impl ClothSteps {
    /// The steps of a garment with its mean edge length.
    pub fn new(garment: Arc<Mesh>, mean_edge: f32) -> Self {
        Self { garment, mean_edge, cloth: Step::default() }
    }

    /// The garment.
    pub fn garment(&self) -> &Arc<Mesh> {
        &self.garment
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
            let pattern = Pattern { uv_set, is_kept: *is_kept };
            let cloth =
                || Cloth::new(options, fabrics, garment, &simulated.remeshed, &simulated.mesh, pattern, mean_edge);
            clock.run("cloth", cloth).map(|(cloth, warnings)| (Arc::new(cloth), warnings))
        })?;
        Ok(Some(cloth))
    }

    /// An estimate of the memory of the kept results. \[bytes\]
    pub fn bytes(&self) -> usize {
        self.cloth.last().map_or(0, |(cloth, _)| cloth.bytes())
    }
}

impl BindingSteps {
    /// The steps of a garment.
    pub fn new(garment: Arc<Mesh>) -> Self {
        Self { garment, render: Step::default(), levels: Vec::new(), cage: Step::default() }
    }

    /// The bindings of a render mesh and of the garment's own points, whose origins `meshes` computes if they are needed.
    pub fn update(
        &mut self,
        simulated: &Arc<SimResult>,
        render: &Arc<Mesh>,
        meshes: &mut MeshBuilder,
        recipe: &MeshRecipe,
        clock: &mut Clock<'_>,
    ) -> Result<[Arc<Binding>; 2], Error> {
        let of_render = self.render.get((Same::from(simulated), Same::from(render)), |_| {
            clock.run("binding", || Ok(Arc::new(bound(simulated, render, &meshes.origins(recipe)?))))
        })?;
        let garment = &self.garment;
        let of_cage = self
            .cage
            .get(Same::from(simulated), |_| Ok(Arc::new(bound(simulated, garment, &meshes.cage_origins()?))))?;
        Ok([of_render, of_cage])
    }

    /// An estimate of the memory of the kept results. \[bytes\]
    pub fn bytes(&self) -> usize {
        let all = [self.render.last(), self.cage.last()].into_iter().flatten();
        all.chain(self.levels.iter().filter_map(Step::last)).map(|binding| binding.bytes()).sum()
    }
}

/// The places of the points of a mesh, with these origins, on a simulation mesh of the same garment. All are in one frame.
pub fn bound(simulated: &SimResult, mesh: &Mesh, origins: &Origins) -> Binding {
    let RemeshResult { product, tables, .. } = &*simulated.remeshed;
    Binding::new(&Locator::new(product, tables), &simulated.mesh, mesh, origins)
}
