//! Steps in the frame of a garment, from which both meshes and more are made.

use super::frame::LocalFrame;
use super::progress::{Clock, Progress};
use super::sim::SimSteps;
use super::{MeshBuilder, RenderUpdate, SimUpdate};
use crate::recipe::{MeshRecipe, RecipeSets, ResolvedMeshes, ResolvedSim};
use crate::render::{Origins, RenderResult, RenderSteps, Stack};
use std::sync::Arc;
use tailor_mesh::error::Error;
use tailor_mesh::garment::{Mesh, Subset};

impl MeshBuilder {
    /// The frame, in which steps work.
    pub fn frame(&mut self) -> &mut LocalFrame {
        &mut self.frame
    }

    /// The garment with the derived sets of the simulation mesh.
    pub fn sim_garment(&self) -> &Arc<Mesh> {
        self.sim.garment()
    }

    /// Both meshes of a resolved recipe.
    ///
    /// # Errors
    /// As [`MeshBuilder::update`].
    pub fn update_local(&mut self, resolved: &ResolvedMeshes) -> Result<(SimUpdate, RenderUpdate), Error> {
        self.derive(&resolved.sets);
        let stack = self.stack(&resolved.recipe)?;
        let Self { sim, render, progress, max_faces, .. } = self;
        progress.join(|| simulated(sim, &resolved.sim, *max_faces, progress), || rendered(render, stack, progress))
    }

    /// Gives the steps of both products the garment with its derived sets.
    pub fn derive(&mut self, sets: &RecipeSets) {
        self.derive_sim(&sets.sim);
        self.derive_render(&sets.render);
    }

    /// The steps of the simulation mesh begin anew where its derived sets are new.
    pub fn derive_sim(&mut self, sets: &[Subset]) {
        if sets != self.sets.sim {
            self.sim = SimSteps::new(self.with_sets(sets));
            self.sets.sim = sets.to_vec();
        }
    }

    /// The steps of the render mesh begin anew where its derived sets are new.
    pub(super) fn derive_render(&mut self, sets: &[Subset]) {
        if sets != self.sets.render {
            self.render = RenderSteps::new(self.with_sets(sets));
            self.sets.render = sets.to_vec();
        }
    }

    /// The garment with more sets.
    fn with_sets(&self, sets: &[Subset]) -> Arc<Mesh> {
        let local = self.frame.enter(&self.garment);
        if sets.is_empty() {
            return local;
        }
        let subsets = local.subsets.iter().chain(sets).cloned().collect();
        Arc::new(Mesh { subsets: Arc::new(subsets), ..Mesh::clone(&local) })
    }

    /// The simulation mesh of resolved options.
    pub(super) fn simulate(&mut self, sim: &ResolvedSim) -> Result<SimUpdate, Error> {
        simulated(&mut self.sim, sim, self.max_faces, &self.progress)
    }

    /// The render mesh of a resolved recipe.
    ///
    /// # Errors
    /// As [`MeshBuilder::update`].
    pub fn render(&mut self, recipe: &MeshRecipe) -> Result<RenderUpdate, Error> {
        let stack = self.stack(recipe)?;
        rendered(&mut self.render, stack, &self.progress)
    }

    /// The origins of the points of the last render mesh, which was made of the same resolved recipe.
    ///
    /// # Errors
    /// As [`MeshBuilder::update_render`].
    pub fn origins(&mut self, recipe: &MeshRecipe) -> Result<Origins, Error> {
        let stack = self.stack(recipe)?;
        self.render.origins(&stack)
    }

    /// The origins of the garment's own points.
    ///
    /// # Errors
    /// As [`MeshBuilder::update_render`].
    pub fn cage_origins(&mut self) -> Result<Origins, Error> {
        self.render.cage_origins()
    }

    pub(super) fn stack(&self, recipe: &MeshRecipe) -> Result<Stack, Error> {
        let mut stack = Stack::new(&recipe.render, &recipe.operators())?;
        stack.names.extend(self.own_operators.iter().map(|operator| operator.label()));
        stack.operators.extend(self.own_operators.iter().cloned());
        Ok(stack)
    }
}

fn simulated(
    steps: &mut SimSteps,
    sim: &ResolvedSim,
    max_faces: usize,
    progress: &Progress,
) -> Result<SimUpdate, Error> {
    let mut clock = Clock::new(progress);
    let simulated = steps.update(sim, max_faces, &mut clock)?;
    clock.finish()?;
    let mut warnings = simulated.remeshed.warnings.clone();
    warnings.extend(simulated.warnings.iter().cloned());
    Ok(SimUpdate { mesh: Arc::clone(&simulated.mesh), warnings, timings: clock.timings, simulated })
}

fn rendered(steps: &mut RenderSteps, stack: Stack, progress: &Progress) -> Result<RenderUpdate, Error> {
    let mut clock = Clock::new(progress);
    let made = clock.run("render", || steps.update(&stack))?;
    clock.finish()?;
    let RenderResult { mesh, sources, sets, warnings, seam_level } = made;
    Ok(RenderUpdate {
        mesh,
        sources,
        operators: stack.names,
        operator_sets: sets,
        seam_level,
        warnings,
        timings: clock.timings,
    })
}
