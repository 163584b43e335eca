//! The steps from both meshes to cloth and binding.

use crate::binding::Binding;
use crate::cloth::{Cloth, ClothOptions, FabricOptions, Pattern};
use crate::fit::PanelRest;
use crate::recipe::Recipe;
use crate::stitch::{Stitch, StitchOptions, sew};
use std::collections::BTreeMap;
use std::sync::Arc;
use tailor::pipeline::{Clock, MeshBuilder, SimResult};
use tailor::recipe::MeshRecipe;
use tailor::render::Origins;
use tailor_mesh::error::{Error, Warnings};
use tailor_mesh::garment::Mesh;
use tailor_mesh::step::{Same, Step};

/// The simulation mesh, its UV set, whether its pattern is kept, and the options of cloth and fabrics.
type ClothInput = (Same<SimResult>, (String, bool), ClothOptions, BTreeMap<String, FabricOptions>);

/// The binding of a render mesh to a simulation mesh.
pub type BindingStep = Step<(Same<SimResult>, Same<Mesh>), Arc<Binding>>;

/// The step from a simulation mesh, which has a garment of its own, to its cloth.
#[derive(Default)]
pub struct ClothStep(Step<ClothInput, (Arc<Cloth>, Warnings)>);

/// The steps that bind points to simulation meshes of one garment.
#[derive(Default)]
pub struct BindingSteps {
    render: BindingStep,
    /// The bindings of the render mesh to the simulation mesh of each level of detail.
    pub(super) levels: Vec<BindingStep>,
    cage: Step<Same<SimResult>, Arc<Binding>>,
}

impl ClothStep {
    /// The cloth of a resolved recipe, with its warnings; none without physics. The garment has this mean edge length.
    pub fn update(
        &mut self,
        recipe: &Recipe,
        (garment, mean_edge): (&Mesh, f32),
        simulated: &Arc<SimResult>,
        clock: &mut Clock<'_>,
    ) -> Result<Option<(Arc<Cloth>, Warnings)>, Error> {
        if recipe.cloth.physics.is_empty() {
            return Ok(None);
        }
        let panels = (recipe.sim.uv_set.clone(), recipe.fit.rest == PanelRest::Pattern);
        let input = (Same::from(simulated), panels, recipe.cloth.clone(), recipe.fabric.clone());
        let cloth = self.0.get(input, |(simulated, (uv_set, is_kept), options, fabrics)| {
            let pattern = Pattern { uv_set, is_kept: *is_kept };
            let cloth =
                || Cloth::new(options, fabrics, garment, &simulated.remeshed, &simulated.mesh, pattern, mean_edge);
            clock.run("cloth", cloth).map(|(cloth, warnings)| (Arc::new(cloth), warnings))
        })?;
        Ok(Some(cloth))
    }

    /// An estimate of the memory of the kept results. \[bytes\]
    pub fn bytes(&self) -> usize {
        self.0.last().map_or(0, |(cloth, _)| cloth.bytes())
    }
}

impl BindingSteps {
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
        let of_cage = self.cage.get(Same::from(simulated), |_| {
            let origins = meshes.cage_origins()?;
            Ok(Arc::new(bound(simulated, meshes.sim_garment(), &origins)))
        })?;
        Ok([of_render, of_cage])
    }

    /// An estimate of the memory of the kept results. \[bytes\]
    pub fn bytes(&self) -> usize {
        let all = [self.render.last(), self.cage.last()].into_iter().flatten();
        all.chain(self.levels.iter().filter_map(Step::last)).map(|binding| binding.bytes()).sum()
    }
}

/// The render mesh, the simulation mesh, and the options of stitches.
type StitchInput = (Same<Mesh>, Same<Mesh>, BTreeMap<String, StitchOptions>);

/// The step from both meshes to the stitches.
#[derive(Default)]
pub struct StitchStep(Step<StitchInput, Arc<BTreeMap<String, Stitch>>>);

impl StitchStep {
    /// The stitches of a resolved recipe.
    pub fn update(
        &mut self,
        recipe: &Recipe,
        sim: &Arc<Mesh>,
        render: &Arc<Mesh>,
        clock: &mut Clock<'_>,
    ) -> Result<Arc<BTreeMap<String, Stitch>>, Error> {
        if recipe.stitch.is_empty() {
            return Ok(Arc::default());
        }
        let input = (Same::from(render), Same::from(sim), recipe.stitch.clone());
        self.0.get(input, |(render, sim, options)| clock.run("stitches", || Ok(Arc::new(sew(render, sim, options)))))
    }

    /// An estimate of the memory of the kept results. \[bytes\]
    pub fn bytes(&self) -> usize {
        self.0.last().map_or(0, |all| all.values().map(|stitch| 44 * stitch.threads.points.len()).sum())
    }
}

/// The places of the points of a mesh, with these origins, on a simulation mesh of the same garment. All are in one frame.
pub fn bound(simulated: &SimResult, mesh: &Mesh, origins: &Origins) -> Binding {
    Binding::new(&simulated.remeshed.locator(), &simulated.mesh, mesh, origins)
}
