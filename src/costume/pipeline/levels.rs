//! The coarser levels of detail: products of the same garment, each of a recipe of its own.

use super::cloth::bound;
use super::{Builder, Clock, Products};
use crate::binding::Binding;
use std::sync::Arc;
use tailor::pipeline::SimResult;
use tailor_mesh::error::Error;
use tailor_mesh::step::Same;

impl Builder {
    /// Adds the coarser levels to the products of the first one, and binds the render mesh of each level to the simulation mesh
    /// of each.
    pub(super) fn add_levels(&mut self, products: &mut Products) -> Result<(), Error> {
        let (recipe, mean_edge) = (products.recipe.clone(), self.mean_edge_length());
        let coarser = recipe.lod.coarser();
        self.levels.truncate(coarser.len());
        while self.levels.len() < coarser.len() {
            self.levels.push(Self::of(self.meshes.sibling().without_warnings()));
        }
        for (number, level) in coarser.zip(&mut self.levels) {
            level.meshes.follow(&self.meshes);
            products.levels.push(level.update(&recipe.at_level(number, mean_edge))?);
        }
        if products.levels.is_empty() {
            return Ok(());
        }
        let sims: Vec<_> = products.all_levels().map(|level| Arc::clone(&level.simulated)).collect();
        products.level_bindings = self.bind_to(&sims, products)?;
        for (builder, level) in self.levels.iter_mut().zip(&mut products.levels) {
            level.level_bindings = builder.bind_to(&sims, level)?;
        }
        Ok(())
    }

    /// The places of the points of the last render mesh, that of `own`, on some simulation meshes of the same garment.
    fn bind_to(&mut self, sims: &[Arc<SimResult>], own: &Products) -> Result<Vec<Arc<Binding>>, Error> {
        let recipe = own.recipe.meshes();
        let render = self.meshes.render(&recipe)?.mesh;
        let progress = self.meshes.progress().clone();
        let mut clock = Clock::new(&progress);
        let Self { meshes, cloth, .. } = self;
        cloth.level_bindings.resize_with(sims.len(), Default::default);
        let mut bindings = Vec::with_capacity(sims.len());
        for (step, sim) in cloth.level_bindings.iter_mut().zip(sims) {
            if Arc::ptr_eq(sim, &own.simulated) {
                bindings.push(Arc::clone(&own.binding));
                continue;
            }
            let binding = step.get((Same::from(sim), Same::from(&render)), |_| {
                clock.run("binding", || {
                    let origins = meshes.origins(&recipe)?;
                    Ok(Arc::new(bound(&cloth.garment, sim, &render, &origins)))
                })
            })?;
            bindings.push(binding);
        }
        clock.finish()?;
        Ok(bindings)
    }
}

impl Products {
    /// The products of all levels of detail, the first one of which is these.
    pub fn all_levels(&self) -> impl Iterator<Item = &Self> {
        std::iter::once(self).chain(&self.levels)
    }
}
