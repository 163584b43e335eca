//! The coarser levels of detail: products of the same garment, each of a recipe of its own.

use super::cloth::bound;
use super::{Builder, Clock, Products};
use crate::binding::Binding;
use crate::codes;
use std::sync::Arc;
use tailor::pipeline::SimResult;
use tailor_mesh::error::{Error, Warning};
use tailor_mesh::garment::Mesh;
use tailor_mesh::step::Same;

impl Builder {
    /// Adds the coarser levels to the products of the first one, and binds the render mesh of each level to the simulation mesh
    /// of each.
    pub(super) fn add_levels(&mut self, products: &mut Products) -> Result<(), Error> {
        let (recipe, mean_edge) = (products.recipe.clone(), self.mean_edge_length());
        let prim = self.garment().prim.clone();
        let coarser = recipe.lod.coarser();
        self.levels.truncate(coarser.len());
        while self.levels.len() < coarser.len() {
            self.levels.push(Self::of(self.meshes.sibling().without_warnings()));
        }
        for (number, level) in coarser.zip(&mut self.levels) {
            level.meshes.follow(&self.meshes);
            let mut coarse = level.update(&recipe.at_level(number, mean_edge))?;
            coarse.warnings.extend(repetition(&prim, &coarse, products.levels.last().unwrap_or(products)));
            products.levels.push(coarse);
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
        let Self { meshes, bindings: steps, .. } = self;
        steps.levels.resize_with(sims.len(), Default::default);
        let mut bindings = Vec::with_capacity(sims.len());
        for (step, sim) in steps.levels.iter_mut().zip(sims) {
            if Arc::ptr_eq(sim, &own.simulated) {
                bindings.push(Arc::clone(&own.binding));
                continue;
            }
            let binding = step.get((Same::from(sim), Same::from(&render)), |_| {
                clock.run("binding", || {
                    let origins = meshes.origins(&recipe)?;
                    Ok(Arc::new(bound(sim, &render, &origins)))
                })
            })?;
            bindings.push(binding);
        }
        clock.finish()?;
        Ok(bindings)
    }
}

/// The note of a level with a mesh of the one before it.
fn repetition(prim: &str, level: &Products, before: &Products) -> Option<Warning> {
    let is_same = |a: &Mesh, b: &Mesh| a.points.len() == b.points.len() && a.faces == b.faces;
    let problem = match (is_same(&level.render, &before.render), is_same(&level.sim, &before.sim)) {
        (true, true) => "both meshes repeat those of the level before",
        (true, false) => "the render mesh repeats that of the level before",
        (false, true) => "the simulation mesh repeats that of the level before",
        (false, false) => return None,
    };
    let warning = Warning::new(codes::LEVEL_REPEATS, prim, problem);
    Some(warning.remedy("Lower lod.levels, or raise render.level, sim.maxEdgeLength or lod.ratio"))
}

impl Products {
    /// The products of all levels of detail, the first one of which is these.
    pub fn all_levels(&self) -> impl Iterator<Item = &Self> {
        std::iter::once(self).chain(&self.levels)
    }
}
