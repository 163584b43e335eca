//! The steps from both meshes to cloth and binding.

use super::products::{ClothUpdate, SimUpdate};
use super::progress::Clock;
use super::sim::SimResult;
use super::{Builder, Resolved};
use crate::binding::Binding;
use crate::cloth::{Cloth, ClothOptions, FabricOptions};
use crate::error::{Error, Warnings};
use crate::garment::Mesh;
use crate::recipe::Recipe;
use crate::render::Origins;
use crate::step::{Same, Step};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The simulation mesh, its UV set, and the options of cloth and fabrics.
type ClothInput = (Same<SimResult>, String, ClothOptions, BTreeMap<String, FabricOptions>);

/// The steps of one garment.
pub struct ClothSteps {
    garment: Arc<Mesh>,
    mean_edge: f32,
    cloth: Step<ClothInput, (Arc<Cloth>, Warnings)>,
    binding: Step<(Same<SimResult>, Same<Mesh>), Arc<Binding>>,
    cage_binding: Step<Same<SimResult>, Arc<Binding>>,
}

impl ClothSteps {
    /// The steps of a garment with its mean edge length.
    pub fn new(garment: Arc<Mesh>, mean_edge: f32) -> Self {
        Self { garment, mean_edge, cloth: Step::default(), binding: Step::default(), cage_binding: Step::default() }
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
        let input = (Same::from(simulated), recipe.sim.uv_set.clone(), recipe.cloth.clone(), recipe.fabric.clone());
        let cloth = self.cloth.get(input, |(simulated, uv_set, options, fabrics)| {
            let product = &simulated.remeshed.product;
            let cloth = || Cloth::new(options, fabrics, garment, product, &simulated.mesh, uv_set, mean_edge);
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
        let source_faces = self.garment.faces.len();
        self.binding.get((Same::from(simulated), Same::from(render)), |(simulated, render)| {
            clock.run("binding", || {
                let product = &simulated.remeshed.product;
                Ok(Arc::new(Binding::new(product, source_faces, &simulated.mesh, render, &origins()?)))
            })
        })
    }

    /// The binding of the garment's own points, whose `origins` are computed if they are needed.
    pub fn cage_binding(
        &mut self,
        simulated: &Arc<SimResult>,
        origins: impl FnOnce() -> Result<Origins, Error>,
    ) -> Result<Arc<Binding>, Error> {
        let garment = &self.garment;
        self.cage_binding.get(Same::from(simulated), |simulated| {
            let (product, faces) = (&simulated.remeshed.product, garment.faces.len());
            Ok(Arc::new(Binding::new(product, faces, &simulated.mesh, garment, &origins()?)))
        })
    }

    /// An estimate of the memory of the kept results. \[bytes\]
    pub fn bytes(&self) -> usize {
        let cloth = self.cloth.last().map_or(0, |(cloth, _)| cloth.bytes());
        let bindings = [self.binding.last(), self.cage_binding.last()];
        cloth + bindings.into_iter().flatten().map(|binding| binding.bytes()).sum::<usize>()
    }
}

impl Builder {
    /// The cloth of a simulation mesh that a builder of the same mesh made of the same recipe; none without physics.
    ///
    /// # Errors
    /// As [`Builder::update`].
    pub fn update_cloth(&mut self, recipe: &Recipe, sim: &SimUpdate) -> Result<Option<ClothUpdate>, Error> {
        let Resolved { recipe, sets, .. } = self.resolved(recipe)?.0;
        self.derive_sim(sets.sim);
        let mut clock = Clock::new(&self.progress);
        let cloth = self.cloth.cloth(&recipe, &sim.simulated, &mut clock)?;
        clock.finish()?;
        Ok(cloth.map(|(cloth, warnings)| ClothUpdate { figures: cloth.figures(&sim.simulated.mesh), warnings }))
    }
}
