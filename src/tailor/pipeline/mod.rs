//! From a mesh and options to the two meshes. [`MeshBuilder`] keeps the result of each step and repeats those whose input has
//! changed.
//!
//! ```text
//! mesh → check ┬→ remesh → transfer                 sim
//!              └→ operators → refinements           render
//! ```

mod check;
mod frame;
mod local;
mod marks;
mod memory;
mod plan;
mod products;
mod progress;
mod sim;
mod thick;

pub use crate::sim::mean_edge_length;
pub use check::check_extent;
pub use frame::{LocalFrame, back};
pub use memory::MemoryEstimate;
pub use plan::MeshPlan;
pub use products::{Meshes, RenderUpdate, SimUpdate};
pub use progress::{Clock, Progress, Timing};
pub use sim::{RemeshResult, SimResult, baseline};

use crate::codes;
use crate::recipe::{MeshRecipe, RecipeSets, ResolvedMeshes, ResolvedSim};
use crate::render::RenderSteps;
use crate::render::operator::Operator;
use crate::sets::{DerivedSet, ListedSet, SetEvaluator};
use sim::SimSteps;
use std::sync::Arc;
use tailor_mesh::error::{Error, Warning, Warnings};
use tailor_mesh::garment::{FaceNumbers, Garment, Mesh, Scheme, check_garment, split_repeats};

/// Largest simulation mesh by default. \[triangles\]
pub const DEFAULT_MAX_FACES: usize = 5_000_000;

/// The two meshes of a garment.
///
/// # Errors
/// Faults of the mesh or of the recipe, and meshes that would be too large.
pub fn build(mesh: &Garment, recipe: &MeshRecipe) -> Result<Meshes, Error> {
    MeshBuilder::new(mesh.clone())?.update(recipe)
}

/// Builds the two meshes of one garment, again and again with other recipes.
///
/// ```
/// use std::sync::Arc;
/// use tailor::{Garment, MeshBuilder, MeshRecipe, SeamOptions, SubsetInput};
///
/// # fn main() -> Result<(), tailor::Error> {
/// # let mut mesh = Garment::default();
/// # mesh.points = (0..25).map(|i| glam::Vec3::new((i % 5) as f32, (i / 5) as f32, 0.0)).collect();
/// # mesh.face_vertex_counts = vec![4; 16];
/// # mesh.face_vertex_indices = (0..20).filter(|i| i % 5 < 4).flat_map(|i| [i, i + 1, i + 6, i + 5]).collect();
/// // An edge set across a sheet of 4 by 4 quads, each edge a pair of points.
/// mesh.subsets = vec![SubsetInput {
///     name: "waist".into(),
///     element_type: "edge".into(),
///     family: String::new(),
///     indices: vec![10, 11, 11, 12, 12, 13, 13, 14],
/// }];
/// let mut recipe = MeshRecipe::default();
/// recipe.seam.insert("waist".into(), SeamOptions { edges: vec!["waist".into()], ..SeamOptions::default() });
/// let mut builder = MeshBuilder::new(mesh)?;
/// let first = builder.update(&recipe)?;
/// for step in 1..5 {
///     // A drag of one slider: points of the render mesh move, and the simulation mesh stays the same.
///     recipe.seam.get_mut("waist").expect("the seam").normal_offset = -0.01 * step as f32;
///     let meshes = builder.update(&recipe)?;
///     assert!(Arc::ptr_eq(&first.sim, &meshes.sim));
///     assert_eq!(first.render.faces, meshes.render.faces);
/// }
/// # Ok(())
/// # }
/// ```
pub struct MeshBuilder {
    garment: Arc<Mesh>,
    /// Of the faces that warnings name; the steps have those of the mesh.
    face_numbers: FaceNumbers,
    frame: LocalFrame,
    mean_edge: f32,
    warnings: Warnings,
    sim: SimSteps,
    render: RenderSteps,
    /// The derived sets that the steps have.
    sets: RecipeSets,
    own_operators: Vec<Arc<dyn Operator>>,
    progress: Progress,
    max_faces: usize,
    max_memory: usize,
}

impl MeshBuilder {
    /// A builder for a mesh.
    ///
    /// # Errors
    /// Faults of the mesh.
    pub fn new(mut mesh: Garment) -> Result<Self, Error> {
        let mut warnings: Warnings = split_repeats(&mut mesh).into_iter().collect();
        let face_numbers = std::mem::take(&mut mesh.face_numbers);
        let (garment, of_check) = check_garment(mesh)?;
        warnings.extend(face_numbers.warnings_in_file(of_check));
        let mean_edge = check_extent(&garment)?;
        check::drawn(&garment)?;
        if garment.prim.rfind('/') == Some(0) {
            let problem = "the products are root prims, as the garment is: a reference to this file misses them";
            warnings
                .push(Warning::new(codes::ROOT_MESH, &garment.prim, problem).remedy("Put the model below an Xform"));
        }
        if garment.rules.scheme == Scheme::None {
            let problem = "subdivisionScheme is none: faces stay flat and are split in quads";
            let warning = Warning::new(codes::POLYGONAL_CAGE, &garment.prim, problem);
            warnings.push(warning.remedy("Set it to catmullClark for a smooth surface"));
        }
        let frame = LocalFrame::of(&garment);
        let of_mesh = frame.check(&garment, mean_edge)?.into_iter().chain(thick::thick_cloth(&garment));
        warnings.extend(face_numbers.warnings_in_file(of_mesh.collect()));
        Ok(Self::in_frame(frame, (Arc::new(garment), face_numbers), mean_edge, warnings))
    }

    /// A builder without results and operators of its own. All steps work on the garment in its frame.
    fn in_frame(
        frame: LocalFrame,
        (garment, face_numbers): (Arc<Mesh>, FaceNumbers),
        mean_edge: f32,
        warnings: Warnings,
    ) -> Self {
        let local = frame.enter(&garment);
        Self {
            sim: SimSteps::new(Arc::clone(&local)),
            render: RenderSteps::new(local),
            sets: RecipeSets::default(),
            garment,
            face_numbers,
            frame,
            mean_edge,
            warnings,
            own_operators: Vec::new(),
            progress: Progress::default(),
            max_faces: DEFAULT_MAX_FACES,
            max_memory: usize::MAX,
        }
    }

    /// A builder of the same checked mesh, without results and operators of its own.
    #[must_use]
    pub fn sibling(&self) -> Self {
        let garment = (Arc::clone(&self.garment), self.face_numbers.clone());
        let sibling = Self::in_frame(self.frame.sibling(), garment, self.mean_edge, self.warnings.clone());
        sibling.with_max_faces(self.max_faces).with_max_memory(self.max_memory)
    }

    /// The render mesh of a recipe with the elements that `warnings` name as sets, one for each code: `mark_flipped_uvs`. None if
    /// they name none.
    ///
    /// # Errors
    /// As [`MeshBuilder::update_render`].
    pub fn marked(&self, recipe: &MeshRecipe, warnings: &Warnings) -> Result<Option<Arc<Mesh>>, Error> {
        let warnings = self.face_numbers.warnings_in_mesh(warnings.clone());
        let Some(garment) = marks::marked(&self.garment, &warnings) else { return Ok(None) };
        let garment = (Arc::new(garment), FaceNumbers::default());
        let mut marked = Self::in_frame(self.frame.sibling(), garment, self.mean_edge, Warnings::default());
        marked.own_operators.clone_from(&self.own_operators);
        Ok(Some(marked.update_render(recipe)?.mesh))
    }

    /// Sets the handle that hears of progress and can cancel a build.
    #[must_use]
    pub fn with_progress(self, progress: Progress) -> Self {
        Self { progress, ..self }
    }

    /// Sets the size above which no simulation mesh is begun. \[triangles\]
    #[must_use]
    pub fn with_max_faces(self, max_faces: usize) -> Self {
        Self { max_faces, ..self }
    }

    /// Sets the memory above which no build is begun; none by default. \[bytes\]
    #[must_use]
    pub fn with_max_memory(self, max_memory: usize) -> Self {
        Self { max_memory, ..self }
    }

    /// Adds warnings of whoever read the mesh, before its own.
    #[must_use]
    pub fn with_warnings(mut self, warnings: Warnings) -> Self {
        let own = std::mem::replace(&mut self.warnings, warnings);
        self.warnings.extend(own);
        self
    }

    /// Drops the warnings of the mesh.
    #[must_use]
    pub fn without_warnings(self) -> Self {
        Self { warnings: Warnings::default(), ..self }
    }

    /// Sets your own operators, which run in this order after the operators of the recipe. They replace the ones set before:
    /// to edit an operator, set a new one. An operator that [`Operator::is_same`] as before is not run again. A mesh farther
    /// from the origin than eight of its sizes is moved near it before they run, and their result is moved back.
    pub fn set_operators(&mut self, operators: Vec<Arc<dyn Operator>>) {
        self.own_operators = operators;
    }

    /// Takes over the operators of its own and the handle of progress that another builder has.
    pub fn follow(&mut self, other: &Self) {
        self.own_operators.clone_from(&other.own_operators);
        self.progress = other.progress.clone();
    }

    /// The checked mesh.
    pub fn garment(&self) -> &Arc<Mesh> {
        &self.garment
    }

    /// Mean length of the mesh's edges. \[mesh units\]
    pub fn mean_edge_length(&self) -> f32 {
        self.mean_edge
    }

    /// Warnings of the mesh alone.
    pub fn warnings(&self) -> &Warnings {
        &self.warnings
    }

    /// The faces of the file, which its own warnings and those of its products name, and of the checked mesh.
    pub fn face_numbers(&self) -> &FaceNumbers {
        &self.face_numbers
    }

    /// The handle that hears of progress.
    pub fn progress(&self) -> &Progress {
        &self.progress
    }

    /// The sets that the mesh offers besides its subsets, in the words of a recipe; `uv_set` is that of a resolved one.
    pub fn listed_sets(&self, uv_set: &str) -> Vec<ListedSet> {
        SetEvaluator::new(&self.garment, uv_set).list()
    }

    /// The elements of an expression of a set; `uv_set` is that of a resolved recipe. Errors name `place`.
    ///
    /// # Errors
    /// A text that is not an expression, or that does not fit the mesh.
    pub fn derived_set(&self, uv_set: &str, place: &str, expression: &str) -> Result<DerivedSet, Error> {
        SetEvaluator::new(&self.garment, uv_set).evaluate(expression).map_err(|fault| fault.at(place))
    }

    /// The recipe for the mesh, with its warnings.
    ///
    /// # Errors
    /// Values out of their range, and names that the mesh lacks.
    pub fn resolve(&self, recipe: &MeshRecipe) -> Result<(ResolvedMeshes, Warnings), Error> {
        let resolved = ResolvedMeshes::new(recipe, &self.garment, self.mean_edge)?;
        check::levels(&self.garment, &resolved.0.recipe)?;
        Ok(resolved)
    }

    /// Checks that the refined meshes of a resolved recipe fit in memory.
    ///
    /// # Errors
    /// A level of more faces than fit.
    pub fn check_levels(&self, recipe: &MeshRecipe) -> Result<(), Error> {
        check::levels(&self.garment, recipe)
    }

    /// Checks that products are not too large.
    ///
    /// # Errors
    /// More triangles, or more memory, than are allowed.
    pub fn check_sizes(&self, sim: &ResolvedSim, estimate: &MemoryEstimate) -> Result<(), Error> {
        sim::check_size(&self.garment, sim, self.max_faces)?;
        estimate.check(self.max_memory)
    }

    /// The two meshes of a recipe. Steps whose input is the same as before are not repeated.
    ///
    /// # Errors
    /// Faults of the recipe, meshes that would be too large, and cancellation. The results of earlier steps stay.
    pub fn update(&mut self, recipe: &MeshRecipe) -> Result<Meshes, Error> {
        let (resolved, mut of_steps) = self.resolve(recipe)?;
        self.check_sizes(&resolved.sim, &MemoryEstimate::new(&self.garment, &resolved))?;
        let (sim, render) = self.update_local(&resolved)?;
        of_steps.extend(sim.warnings);
        of_steps.extend(render.warnings);
        Ok(Meshes {
            sim: self.frame.sim(&sim.mesh)?,
            render: self.frame.render(&render.mesh)?,
            recipe: resolved.recipe,
            operators: render.operators,
            operator_sets: render.operator_sets,
            warnings: self.with_own_warnings(of_steps),
            timings: [sim.timings, render.timings].concat(),
            simulated: sim.simulated,
        })
    }

    /// Warnings of steps, with the elements of the file, after those of the mesh.
    pub fn with_own_warnings(&self, of_steps: Warnings) -> Warnings {
        let mut warnings = self.warnings.clone();
        warnings.extend(self.face_numbers.warnings_in_file(of_steps));
        warnings
    }

    /// The simulation mesh alone.
    ///
    /// # Errors
    /// As [`MeshBuilder::update`].
    pub fn update_sim(&mut self, recipe: &MeshRecipe) -> Result<SimUpdate, Error> {
        let (resolved, warnings) = self.resolve(recipe)?;
        self.update_resolved_sim(&resolved, warnings)
    }

    /// The simulation mesh of a resolved recipe, with `warnings` of it.
    ///
    /// # Errors
    /// As [`MeshBuilder::update`].
    pub fn update_resolved_sim(&mut self, resolved: &ResolvedMeshes, warnings: Warnings) -> Result<SimUpdate, Error> {
        sim::check_size(&self.garment, &resolved.sim, self.max_faces)?;
        self.derive_sim(&resolved.sets.sim);
        let mut update = self.simulate(&resolved.sim)?;
        update.warnings.extend(warnings);
        let warnings = self.face_numbers.warnings_in_file(update.warnings);
        Ok(SimUpdate { mesh: self.frame.sim(&update.mesh)?, warnings, ..update })
    }

    /// The render mesh alone.
    ///
    /// # Errors
    /// As [`MeshBuilder::update`].
    pub fn update_render(&mut self, recipe: &MeshRecipe) -> Result<RenderUpdate, Error> {
        let resolved = self.resolve(recipe)?.0;
        self.update_resolved_render(&resolved)
    }

    /// The render mesh of a resolved recipe.
    ///
    /// # Errors
    /// As [`MeshBuilder::update`].
    pub fn update_resolved_render(&mut self, resolved: &ResolvedMeshes) -> Result<RenderUpdate, Error> {
        self.derive_render(&resolved.sets.render);
        let update = self.render(&resolved.recipe)?;
        let warnings = self.face_numbers.warnings_in_file(update.warnings);
        Ok(RenderUpdate { mesh: self.frame.render(&update.mesh)?, warnings, ..update })
    }

    /// An estimate of the memory that the kept results hold. \[bytes\]
    pub fn bytes(&self) -> usize {
        self.garment.bytes() + self.sim.bytes() + self.render.bytes() + self.frame.bytes()
    }
}
