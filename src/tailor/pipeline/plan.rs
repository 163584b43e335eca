//! Plans of builds: the sizes of their meshes.

use super::{MemoryEstimate, MeshBuilder, sim};
use crate::recipe::ResolvedMeshes;
use serde::Serialize;
use tailor_mesh::error::Error;

/// The sizes of the two meshes before they are built.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
#[non_exhaustive]
pub struct MeshPlan {
    /// Triangles that the target lengths ask for, all of them equilateral.
    pub expected_faces: usize,
    /// Constraint chains.
    pub chains: usize,
    /// Faces of the render mesh.
    pub render_faces: usize,
    /// Refinements before the first seam. \[levels\]
    pub seam_level: u32,
}

impl MeshBuilder {
    /// The sizes of the meshes of a resolved recipe, by less work than they take.
    ///
    /// # Errors
    /// As [`MeshBuilder::update`].
    pub fn plan(&mut self, resolved: &ResolvedMeshes) -> Result<MeshPlan, Error> {
        let ResolvedMeshes { recipe, sim, sets } = resolved;
        MemoryEstimate::surface(&self.garment, sim).check(self.max_memory)?;
        self.derive(sets);
        let stack = self.stack(recipe)?;
        let garment = self.sim_garment();
        Ok(MeshPlan {
            expected_faces: sim::expected_faces(garment, sim),
            chains: sim::baseline(garment, sim).chains.len(),
            render_faces: self.render.face_count(&stack)?,
            seam_level: self.render.seam_level(&stack)?,
        })
    }
}
