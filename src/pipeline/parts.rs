//! What the preview needs of products that are not built together: where their faces and points are from.

use super::{Builder, SimUpdate};
use crate::binding::Binding;
use crate::error::Error;
use crate::garment::Mesh;
use crate::mesh::FaceId;
use crate::recipe::Recipe;
use crate::render::Origins;
use rayon::prelude::*;
use std::sync::Arc;

impl Builder {
    /// The face of the mesh that each face of the last [`Builder::update_render`] is part of. It had the same recipe, resolved.
    ///
    /// # Errors
    /// As [`Builder::update_render`].
    pub(crate) fn render_sources(&mut self, recipe: &Recipe) -> Result<Vec<FaceId>, Error> {
        let stack = self.stack(recipe)?;
        Ok(self.render.source_faces(&stack)?.as_slice().to_vec())
    }

    /// The origins of the points of the last [`Builder::update_render`], which had the same recipe.
    ///
    /// # Errors
    /// As [`Builder::update_render`].
    pub(crate) fn render_origins(&mut self, recipe: &Recipe) -> Result<Origins, Error> {
        let recipe = self.resolve(recipe)?;
        let stack = self.stack(&recipe)?;
        self.render.origins(&stack)
    }

    /// The binding of a render mesh with these origins to a simulation mesh. Builders of the same mesh made both.
    pub(crate) fn bind(&self, sim: &SimUpdate, render: &Arc<Mesh>, origins: &Origins) -> Binding {
        let (product, faces) = (&sim.simulated.remeshed.product, self.garment.faces.len());
        Binding::new(product, faces, &sim.simulated.mesh, &self.frame.enter(render), origins)
    }
}

impl SimUpdate {
    /// The face of the garment under the centroid of each triangle.
    pub(crate) fn source_faces(&self) -> Vec<FaceId> {
        let product = &self.simulated.remeshed.product;
        (0..product.triangles.len()).into_par_iter().map(|i| product.source_face(FaceId::new(i))).collect()
    }
}
