//! Plans of builds: the sizes of their products, and their memory.

use super::{Builder, MemoryEstimate, Plan};
use crate::recipe::{Recipe, Resolved};
use tailor_mesh::error::Error;

impl Builder {
    /// An estimate of the memory that [`Builder::update`] would take at once, within a factor of two where the garment has
    /// 10,000 faces or more.
    ///
    /// # Errors
    /// As [`Builder::resolve`].
    pub fn estimate(&self, recipe: &Recipe) -> Result<MemoryEstimate, Error> {
        self.estimated(&self.resolved(recipe)?.0)
    }

    /// The estimate for all levels of detail of a resolved recipe.
    pub(super) fn estimated(&self, resolved: &Resolved) -> Result<MemoryEstimate, Error> {
        let garment = self.meshes.garment();
        let mut all = MemoryEstimate::new(garment, &resolved.meshes);
        for level in resolved.recipe.lod.coarser() {
            let coarser = self.resolved(&resolved.recipe.at_level(level, self.mean_edge_length()))?.0;
            all = all.with(&MemoryEstimate::new(garment, &coarser.meshes));
        }
        Ok(all)
    }

    /// The sizes of the products of a recipe at all its levels of detail, by less work than the products take.
    ///
    /// # Errors
    /// As [`Builder::update`].
    pub fn plan(&mut self, recipe: &Recipe) -> Result<Plan, Error> {
        let mut plan = self.plan_level(recipe)?;
        for level in plan.recipe.lod.coarser() {
            plan.levels.push(self.plan_level(&plan.recipe.at_level(level, self.mean_edge_length()))?);
        }
        Ok(plan)
    }

    fn plan_level(&mut self, recipe: &Recipe) -> Result<Plan, Error> {
        let Resolved { recipe, meshes } = self.resolved(recipe)?.0;
        Ok(Plan { meshes: self.meshes.plan(&meshes)?, levels: Vec::new(), recipe })
    }
}
