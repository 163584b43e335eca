//! A recipe for one garment.

use super::Recipe;
use crate::stitch::follow_seams;
use tailor::recipe::{ResolvedMeshes, resolve_uv_set};
use tailor::sim::length_scale;
use tailor_mesh::error::{Error, Warnings};
use tailor_mesh::garment::Mesh;
use tailor_mesh::options::{OptionGroup as _, Scale, within_size_in_meters};

/// A recipe whose values are checked against one garment: lengths are in mesh units, and names are found.
#[derive(Clone, Debug, PartialEq)]
pub struct Resolved {
    /// The recipe with the lengths that are used.
    pub recipe: Recipe,
    /// The input of the two meshes. The sets of the cloth are among those of the simulation mesh.
    pub meshes: ResolvedMeshes,
}

impl Resolved {
    /// A recipe for a garment with this mean edge length \[mesh units\], and the warnings of a UV set that is missing and of empty sets.
    ///
    /// # Errors
    /// A value that its option does not take, or that does not fit the garment; a name that the garment lacks.
    pub fn new(recipe: &Recipe, garment: &Mesh, mean_edge: f32) -> Result<(Self, Warnings), Error> {
        recipe.check()?;
        let mut recipe = recipe.clone();
        follow_seams(&mut recipe.stitch, &recipe.seam)?;
        let mean_edge = length_scale(garment, &recipe.sim, mean_edge);
        let scale = Scale { mean_edge, meters: garment.units.meters() };
        recipe.resolve_lengths(scale);
        recipe.stitch.values_mut().for_each(|stitch| stitch.resolve_lengths(scale));
        let mut warnings = Warnings::from_iter(resolve_uv_set(&mut recipe.sim, garment));
        let meshes = warnings.absorb(ResolvedMeshes::of_groups(recipe.meshes(), &recipe.used(), garment)?);
        recipe.cloth.check_names(garment)?;
        for (name, fabric) in &recipe.fabric {
            within_size_in_meters(&format!("fabric.{name}.thickness"), fabric.thickness, garment)?;
        }
        Ok((Self { recipe, meshes }, warnings))
    }
}
