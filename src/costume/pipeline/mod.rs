//! From a mesh and a recipe to the products. [`Builder`] is the one object that the command, the plugin and other programs
//! run. The two meshes are those of a [`MeshBuilder`]; cloth, bindings and levels of detail are made of them here, by steps of
//! the same kind.
//!
//! ```text
//! MeshBuilder: sim, render ┬→ cloth
//!                          ├→ bindings
//!                          └→ levels: the same again, coarser
//! ```

mod cloth;
mod levels;
mod plan;
mod products;

pub use cloth::bound;
pub use products::{ClothUpdate, Plan, Products, RenderPanel};
pub use tailor::pipeline::{
    Clock, DEFAULT_MAX_FACES, MemoryEstimate, MeshBuilder, Progress, RenderUpdate, SimUpdate, Timing, back,
};

use crate::cloth::{Cloth, Rest};
use crate::recipe::{Recipe, Resolved};
use cloth::{BindingSteps, ClothStep, StitchStep};
use std::sync::Arc;
use tailor::render::operator::Operator;
use tailor::sets::{DerivedSet, ListedSet};
use tailor_mesh::error::{Error, Warnings};
use tailor_mesh::garment::{FaceNumbers, Garment, Mesh};
use tailor_mesh::step::{Same, Step};

/// The products of a mesh.
///
/// # Errors
/// Faults of the mesh or of the recipe, and products that would be too large.
pub fn build(mesh: &Garment, recipe: &Recipe) -> Result<Products, Error> {
    Builder::new(mesh.clone())?.update(recipe)
}

/// Builds the products of one mesh, again and again with other recipes. Steps whose input is the same as before are not repeated.
///
/// ```
/// use tailor_costume::{Builder, Recipe};
/// use tailor_mesh::Garment;
///
/// # fn main() -> Result<(), tailor_mesh::Error> {
/// # let mut mesh = Garment::default();
/// # mesh.points = (0..25).map(|i| glam::Vec3::new((i % 5) as f32, (i / 5) as f32, 0.0)).collect();
/// # mesh.face_vertex_counts = vec![4; 16];
/// # mesh.face_vertex_indices = (0..20).filter(|i| i % 5 < 4).flat_map(|i| [i, i + 1, i + 6, i + 5]).collect();
/// let mut recipe = Recipe::default();
/// recipe.lod.levels = 2;
/// let products = Builder::new(mesh)?.update(&recipe)?;
/// assert!(products.levels[0].sim.faces.len() < products.sim.faces.len());
/// assert!(products.cloth.is_some_and(|cloth| !cloth.fabrics.is_empty()));
/// # Ok(())
/// # }
/// ```
pub struct Builder {
    meshes: MeshBuilder,
    cloth: ClothStep,
    bindings: BindingSteps,
    /// The cloth in the garment's own space.
    moved_cloth: Step<Same<Cloth>, Arc<Cloth>>,
    stitches: StitchStep,
    /// The builders of the coarser levels of detail.
    levels: Vec<Self>,
}

impl Builder {
    /// A builder for a mesh.
    ///
    /// # Errors
    /// Faults of the mesh.
    pub fn new(mesh: Garment) -> Result<Self, Error> {
        Ok(Self::of(MeshBuilder::new(mesh)?))
    }

    fn of(meshes: MeshBuilder) -> Self {
        let (cloth, bindings, moved_cloth, stitches) = Default::default();
        Self { meshes, cloth, bindings, moved_cloth, stitches, levels: Vec::new() }
    }

    /// A builder of the same checked mesh, without results and operators of its own.
    #[must_use]
    pub fn sibling(&self) -> Self {
        Self::of(self.meshes.sibling())
    }

    /// The render mesh of `products` with the elements that their warnings name as sets, one for each code: `mark_flipped_uvs`.
    /// None if they name none.
    ///
    /// # Errors
    /// As [`Builder::update_render`].
    pub fn marked(&self, products: &Products) -> Result<Option<Arc<Mesh>>, Error> {
        self.meshes.marked(&products.recipe.meshes(), &products.warnings)
    }

    /// Sets the handle that hears of progress and can cancel a build.
    #[must_use]
    pub fn with_progress(self, progress: Progress) -> Self {
        Self { meshes: self.meshes.with_progress(progress), ..self }
    }

    /// Sets the size above which no simulation mesh is begun. \[triangles\]
    #[must_use]
    pub fn with_max_faces(self, max_faces: usize) -> Self {
        Self { meshes: self.meshes.with_max_faces(max_faces), ..self }
    }

    /// Sets the memory above which no build is begun; none by default. \[bytes\]
    #[must_use]
    pub fn with_max_memory(self, max_memory: usize) -> Self {
        Self { meshes: self.meshes.with_max_memory(max_memory), ..self }
    }

    /// Adds warnings of whoever read the mesh, before its own.
    #[must_use]
    pub fn with_warnings(self, warnings: Warnings) -> Self {
        Self { meshes: self.meshes.with_warnings(warnings), ..self }
    }

    /// Sets your own operators, as [`MeshBuilder::set_operators`] does.
    pub fn set_operators(&mut self, operators: Vec<Arc<dyn Operator>>) {
        self.meshes.set_operators(operators);
    }

    /// The builder of the two meshes.
    pub fn meshes(&mut self) -> &mut MeshBuilder {
        &mut self.meshes
    }

    /// The checked mesh.
    pub fn garment(&self) -> &Arc<Mesh> {
        self.meshes.garment()
    }

    /// Mean length of the mesh's edges. \[mesh units\]
    pub fn mean_edge_length(&self) -> f32 {
        self.meshes.mean_edge_length()
    }

    /// Warnings of the mesh alone.
    pub fn warnings(&self) -> &Warnings {
        self.meshes.warnings()
    }

    /// The faces of the file, which its own warnings and those of its products name, and of the checked mesh.
    pub fn face_numbers(&self) -> &FaceNumbers {
        self.meshes.face_numbers()
    }

    /// The recipe with automatic lengths replaced by multiples of the mean edge length.
    ///
    /// # Errors
    /// Values out of their range, and names that the mesh lacks.
    pub fn resolve(&self, recipe: &Recipe) -> Result<Recipe, Error> {
        Ok(self.resolved(recipe)?.0.recipe)
    }

    /// The resolved recipe, with its warnings.
    fn resolved(&self, recipe: &Recipe) -> Result<(Resolved, Warnings), Error> {
        let resolved = Resolved::new(recipe, self.garment(), self.mean_edge_length())?;
        self.meshes.check_levels(&resolved.0.meshes.recipe)?;
        Ok(resolved)
    }

    /// The sets that the mesh offers besides its subsets, in the words of a recipe; `recipe` is a resolved one.
    pub fn listed_sets(&self, recipe: &Recipe) -> Vec<ListedSet> {
        self.meshes.listed_sets(&recipe.sim.uv_set)
    }

    /// The elements of an expression of a set; `recipe` is a resolved one. Errors name `place`.
    ///
    /// # Errors
    /// A text that is not an expression, or that does not fit the mesh.
    pub fn derived_set(&self, recipe: &Recipe, place: &str, expression: &str) -> Result<DerivedSet, Error> {
        self.meshes.derived_set(&recipe.sim.uv_set, place, expression)
    }

    /// The products of a recipe, at all its levels of detail. Steps whose input is the same as before are not repeated.
    ///
    /// # Errors
    /// Faults of the recipe, products that would be too large, and cancellation. The results of earlier steps stay.
    pub fn update(&mut self, recipe: &Recipe) -> Result<Products, Error> {
        let (resolved, of_recipe) = self.resolved(recipe)?;
        self.meshes.check_sizes(&resolved.meshes.sim, &self.estimated(&resolved)?)?;
        let mut products = self.update_first(resolved, of_recipe)?;
        self.add_levels(&mut products)?;
        Ok(products)
    }

    /// The products of the first level.
    fn update_first(&mut self, resolved: Resolved, of_recipe: Warnings) -> Result<Products, Error> {
        let Resolved { recipe, meshes: resolved } = resolved;
        let (sim, render) = self.meshes.update_local(&resolved)?;
        let progress = self.meshes.progress().clone();
        let [mut clock, mut beside] = [Clock::new(&progress), Clock::new(&progress)];
        let Self { meshes, cloth, bindings, .. } = self;
        let (garment, mean_edge) = (Arc::clone(meshes.sim_garment()), meshes.mean_edge_length());
        let (cloth, [binding, cage_binding]) = progress.join(
            || cloth.update(&recipe, (&garment, mean_edge), &sim.simulated, &mut clock),
            || bindings.update(&sim.simulated, &render.mesh, meshes, &resolved.recipe, &mut beside),
        )?;
        let frame = meshes.frame();
        let (sim_mesh, render_mesh) = (frame.sim(&sim.mesh)?, frame.render(&render.mesh)?);
        let stitches = self.stitches.update(&recipe, &sim_mesh, &render_mesh, &mut clock)?;
        clock.finish()?;
        let (cloth, of_cloth) = cloth.unzip();
        let mut of_steps = of_recipe;
        of_steps.extend(sim.warnings);
        of_steps.extend(render.warnings);
        of_steps.extend(of_cloth.unwrap_or_default());
        let warnings = self.meshes.with_own_warnings(of_steps);
        Ok(Products {
            sim: sim_mesh,
            render: render_mesh,
            stitches,
            cloth: cloth.map(|cloth| self.in_garment_space(&cloth)).transpose()?,
            binding,
            cage_binding,
            levels: Vec::new(),
            level_bindings: Vec::new(),
            recipe,
            operators: render.operators,
            operator_sets: render.operator_sets,
            warnings,
            timings: [sim.timings, render.timings, clock.timings, beside.timings].concat(),
            simulated: sim.simulated,
        })
    }

    /// A cloth out of the frame of the build.
    fn in_garment_space(&mut self, cloth: &Arc<Cloth>) -> Result<Arc<Cloth>, Error> {
        back(&mut self.moved_cloth, self.meshes.frame().origin(), cloth, |cloth, by| Cloth {
            rest: cloth.rest.as_ref().map(|rest| Rest { points: rest.moved(by), ..rest.clone() }),
            ..cloth.clone()
        })
    }

    /// The simulation mesh alone.
    ///
    /// # Errors
    /// As [`Builder::update`].
    pub fn update_sim(&mut self, recipe: &Recipe) -> Result<SimUpdate, Error> {
        let (resolved, warnings) = self.resolved(recipe)?;
        self.meshes.update_resolved_sim(&resolved.meshes, warnings)
    }

    /// The render mesh alone.
    ///
    /// # Errors
    /// As [`Builder::update`].
    pub fn update_render(&mut self, recipe: &Recipe) -> Result<RenderUpdate, Error> {
        let resolved = self.resolved(recipe)?.0;
        self.meshes.update_resolved_render(&resolved.meshes)
    }

    /// The cloth of a simulation mesh that a builder of the same mesh made of the same recipe; none without physics.
    ///
    /// # Errors
    /// As [`Builder::update`].
    pub fn update_cloth(&mut self, recipe: &Recipe, sim: &SimUpdate) -> Result<Option<ClothUpdate>, Error> {
        let Resolved { recipe, meshes } = self.resolved(recipe)?.0;
        self.meshes.derive_sim(&meshes.sets.sim);
        let progress = self.meshes.progress().clone();
        let mut clock = Clock::new(&progress);
        let garment = (&**self.meshes.sim_garment(), self.meshes.mean_edge_length());
        let cloth = self.cloth.update(&recipe, garment, &sim.simulated, &mut clock)?;
        clock.finish()?;
        Ok(cloth.map(|(cloth, warnings)| ClothUpdate { figures: cloth.figures(&sim.simulated.mesh), warnings }))
    }

    /// An estimate of the memory that the kept results hold. \[bytes\]
    pub fn bytes(&self) -> usize {
        let moved = self.moved_cloth.last().map_or(0, |cloth| cloth.bytes());
        self.meshes.bytes()
            + self.cloth.bytes()
            + self.bindings.bytes()
            + self.stitches.bytes()
            + moved
            + self.levels.iter().map(Self::bytes).sum::<usize>()
    }
}
