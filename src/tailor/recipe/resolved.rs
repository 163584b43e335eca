//! The options of the two meshes for one garment.

use super::uv_set::resolve_uv_set;
use super::{MeshRecipe, RecipeSets, UsedGroup};
use crate::sets::{weights_named, weights_of};
use crate::sim::{Lengths, SimOptions, length_scale};
use std::borrow::Cow;
use std::sync::Arc;
use tailor_mesh::error::{Error, Warnings};
use tailor_mesh::garment::{Mesh, Primvar, Subset};
use tailor_mesh::options::{Scale, primvar};

/// The options of the two meshes, with values that are checked against one garment: lengths are in mesh units, and names are found.
#[derive(Clone, Debug, PartialEq)]
pub struct ResolvedMeshes {
    /// The options with the lengths that are used.
    pub recipe: MeshRecipe,
    /// The options of the simulation mesh, with the primvars that they name.
    pub sim: ResolvedSim,
    /// The sets that the recipe derives.
    pub sets: RecipeSets,
}

/// Options of the simulation mesh for one garment.
#[derive(Clone, Debug, PartialEq)]
pub struct ResolvedSim {
    /// The options with the lengths that are used.
    pub options: SimOptions,
    /// Index of the UV set in the garment's primvars, if its seams are constraints.
    uv_set: Option<usize>,
    /// The density, painted or that of a set.
    density: Option<Arc<Primvar>>,
}

impl ResolvedMeshes {
    /// A recipe for a garment with this mean edge length \[mesh units\], and the warnings of a UV set that is missing and of empty sets.
    ///
    /// # Errors
    /// A value that its option does not take, or that does not fit the garment; a name that the garment lacks.
    pub fn new(recipe: &MeshRecipe, garment: &Mesh, mean_edge: f32) -> Result<(Self, Warnings), Error> {
        recipe.check()?;
        let mut recipe = recipe.clone();
        let mean_edge = length_scale(garment, &recipe.sim, mean_edge);
        recipe.resolve_lengths(Scale { mean_edge, meters: garment.units.meters() });
        let mut warnings = Warnings::from_iter(resolve_uv_set(&mut recipe.sim, garment));
        let resolved = warnings.absorb(Self::of_groups(recipe.clone(), &recipe.used(), garment)?);
        Ok((resolved, warnings))
    }

    /// A recipe with its lengths and its UV set, as part of the recipe that uses `groups`, and the warnings of empty sets.
    ///
    /// # Errors
    /// As [`ResolvedMeshes::new`].
    pub fn of_groups(recipe: MeshRecipe, groups: &[UsedGroup<'_>], garment: &Mesh) -> Result<(Self, Warnings), Error> {
        let (sets, warnings) = RecipeSets::new(groups, &recipe.sim.uv_set, garment)?;
        groups.iter().try_for_each(|(prefix, options)| options.bind(prefix, garment))?;
        let sim = ResolvedSim::new(&recipe.sim, &sets.sim, garment)?;
        Ok((Self { recipe, sim, sets }, warnings))
    }
}

/// Finds the UV set; `None` if the name is empty.
///
/// # Errors
/// A primvar that is missing or has another type.
pub fn bind_uv_set<'a>(options: &SimOptions, garment: &'a Mesh) -> Result<Option<&'a Primvar>, Error> {
    primvar(garment, "sim.uvSet", &options.uv_set, "face-varying float2 primvar", |p| p.is_uv_set())
}

impl ResolvedSim {
    /// Options with their lengths for a garment with derived sets.
    ///
    /// # Errors
    /// A primvar that the garment lacks.
    pub fn new(options: &SimOptions, derived: &[Subset], garment: &Mesh) -> Result<Self, Error> {
        let uv_set = bind_uv_set(options, garment)?.filter(|_| options.constrain_uv_seams);
        let uv_set = uv_set.and_then(|set| garment.primvars.iter().position(|primvar| primvar.name == set.name));
        let of_derived = || derived.iter().find(|set| set.name == options.density).map(|set| weights_of(garment, set));
        let density = weights_named(garment, &options.density).map(Cow::into_owned).or_else(of_derived).map(Arc::new);
        Ok(Self { options: options.clone(), uv_set, density })
    }

    /// The options that remeshing reads; those of transfer have one value.
    pub fn without_transfer(&self) -> Self {
        Self { options: self.options.without_transfer(), ..self.clone() }
    }

    /// The UV set whose shell borders are constraints.
    pub fn uv_set<'a>(&self, garment: &'a Mesh) -> Option<&'a Primvar> {
        self.uv_set.map(|index| &garment.primvars[index])
    }

    /// The target lengths.
    pub fn lengths(&self) -> Lengths<'_> {
        let density = self.density.as_deref();
        Lengths { min: self.options.min_edge_length, max: self.options.max_edge_length, density }
    }
}
