//! Binds products that were not built together, for the preview.

use super::{Builder, SimUpdate};
use crate::binding::Binding;
use crate::recipe::Recipe;
use std::sync::Arc;
use tailor::render::Origins;
use tailor_mesh::error::Error;
use tailor_mesh::garment::Mesh;

impl Builder {
    /// The origins of the points of the last [`Builder::update_render`]. It had the same recipe, resolved.
    ///
    /// # Errors
    /// As [`Builder::update_render`].
    pub fn render_origins(&mut self, recipe: &Recipe) -> Result<Origins, Error> {
        let stack = self.stack(recipe)?;
        self.render.origins(&stack)
    }

    /// The binding of a render mesh with these origins to a simulation mesh. Builders of the same mesh made both.
    pub fn bind(&self, sim: &SimUpdate, render: &Arc<Mesh>, origins: &Origins) -> Binding {
        let (product, faces) = (&sim.simulated.remeshed.product, self.garment.faces.len());
        Binding::new(product, faces, &sim.simulated.mesh, &self.frame.enter(render), origins)
    }
}
