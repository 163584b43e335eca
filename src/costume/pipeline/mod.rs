//! From a mesh and a recipe to the products. [`Builder`] is the one object that the command, the plugin and other programs
//! run; it keeps the result of each step and repeats those whose input has changed.
//!
//! ```text
//! mesh → check ┬→ remesh → transfer                 sim
//!              └→ operators → refinements           render
//! ```

mod check;
mod cloth;
mod frame;
mod levels;
mod marks;
mod memory;
mod parts;
mod plan;
mod products;
mod progress;
mod sim;

pub use check::mean_edge_length;
pub use memory::MemoryEstimate;
pub use products::{ClothUpdate, Plan, Products, RenderPanel, RenderUpdate, SimUpdate};
pub use progress::{Progress, Timing};
pub use sim::baseline;

use crate::recipe::{Recipe, RecipeSets, Resolved, ResolvedSim};
use cloth::ClothSteps;
use frame::LocalFrame;
use progress::Clock;
use sim::SimSteps;
use std::sync::Arc;
use tailor::render::operator::Operator;
use tailor::render::{RenderResult, RenderSteps, Stack};
use tailor::sets::{DerivedSet, ListedSet, SetEvaluator};
use tailor_mesh::connectivity::Elements;
use tailor_mesh::error::{Error, Warning, Warnings};
use tailor_mesh::garment::{FaceNumbers, Garment, Mesh, Scheme, Subset, check_garment, split_repeats};

/// Largest simulation mesh by default. \[triangles\]
pub const DEFAULT_MAX_FACES: usize = 5_000_000;

/// The products of a mesh.
///
/// # Errors
/// Faults of the mesh or of the recipe, and products that would be too large.
pub fn build(mesh: &Garment, recipe: &Recipe) -> Result<Products, Error> {
    Builder::new(mesh.clone())?.update(recipe)
}

/// Builds the products of one mesh, again and again with other recipes.
///
/// ```
/// use std::sync::Arc;
/// use tailor::{Builder, Garment, Recipe, SeamOptions, SubsetInput};
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
/// let mut recipe = Recipe::default();
/// recipe.seam.insert("waist".into(), SeamOptions { edges: vec!["waist".into()], ..SeamOptions::default() });
/// let mut builder = Builder::new(mesh)?;
/// let first = builder.update(&recipe)?;
/// for step in 1..5 {
///     // A drag of one slider: points of the render mesh move, and the simulation mesh stays the same.
///     recipe.seam.get_mut("waist").expect("the seam").normal_offset = -0.01 * step as f32;
///     let products = builder.update(&recipe)?;
///     assert!(Arc::ptr_eq(&first.sim, &products.sim));
///     assert_eq!(first.render.faces, products.render.faces);
/// }
/// # Ok(())
/// # }
/// ```
pub struct Builder {
    garment: Arc<Mesh>,
    /// Of the faces that warnings name; the steps have those of the mesh.
    face_numbers: FaceNumbers,
    frame: LocalFrame,
    mean_edge: f32,
    warnings: Warnings,
    sim: SimSteps,
    render: RenderSteps,
    cloth: ClothSteps,
    /// The derived sets that the steps have.
    sets: RecipeSets,
    own_operators: Vec<Arc<dyn Operator>>,
    /// The builders of the coarser levels of detail.
    levels: Vec<Self>,
    progress: Progress,
    max_faces: usize,
    max_memory: usize,
}

impl Builder {
    /// A builder for a mesh.
    ///
    /// # Errors
    /// Faults of the mesh.
    pub fn new(mut mesh: Garment) -> Result<Self, Error> {
        let mut warnings: Warnings = split_repeats(&mut mesh).into_iter().collect();
        let face_numbers = std::mem::take(&mut mesh.face_numbers);
        let (garment, of_check) = check_garment(mesh)?;
        warnings.extend(face_numbers.warnings_in_file(of_check));
        let mean_edge = check::mean_edge_length(&garment);
        check::extent(&garment, mean_edge)?;
        if garment.prim.rfind('/') == Some(0) {
            let problem = "the model is a root prim, and so are the products: a reference to the file's default prim \
                           leaves them out";
            warnings.push(
                Warning::new(tailor::codes::ROOT_MESH, &garment.prim, problem).remedy("Put the model below an Xform"),
            );
        }
        if garment.rules.scheme == Scheme::None {
            let problem = "subdivisionScheme is none: faces stay flat and are split in quads";
            let warning = Warning::new(tailor::codes::POLYGONAL_CAGE, &garment.prim, problem);
            warnings.push(warning.remedy("Set it to catmullClark for a smooth surface"));
        }
        let frame = LocalFrame::of(&garment);
        warnings.extend(frame.check(&garment, mean_edge)?);
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
            render: RenderSteps::new(Arc::clone(&local)),
            cloth: ClothSteps::new(local, mean_edge),
            sets: RecipeSets::default(),
            garment,
            face_numbers,
            frame,
            mean_edge,
            warnings,
            own_operators: Vec::new(),
            levels: Vec::new(),
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

    /// The render mesh of `products` with the elements that their warnings name as sets, one for each code: `mark_flipped_uvs`.
    /// None if they name none.
    ///
    /// # Errors
    /// As [`Builder::update_render`].
    pub fn marked(&self, products: &Products) -> Result<Option<Arc<Mesh>>, Error> {
        let warnings = self.warnings_in_mesh(&products.warnings);
        let Some(garment) = marks::marked(&self.garment, &warnings) else { return Ok(None) };
        let garment = (Arc::new(garment), FaceNumbers::default());
        let mut marked = Self::in_frame(self.frame.sibling(), garment, self.mean_edge, Warnings::default());
        marked.own_operators.clone_from(&self.own_operators);
        Ok(Some(marked.update_render(&products.recipe)?.mesh))
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

    /// Sets your own operators, which run in this order after the operators of the recipe. They replace the ones set before:
    /// to edit an operator, set a new one. An operator that [`Operator::is_same`] as before is not run again. A mesh farther
    /// from the origin than eight of its sizes is moved near it before they run, and their result is moved back.
    pub fn set_operators(&mut self, operators: Vec<Arc<dyn Operator>>) {
        self.own_operators = operators;
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

    /// Warnings of its own, or of its products, with the elements of the checked mesh: they have those of the file.
    pub fn warnings_in_mesh(&self, warnings: &Warnings) -> Warnings {
        self.face_numbers.warnings_in_mesh(warnings.clone())
    }

    /// Warnings of the checked mesh with the elements of the file, from which faces may be left out.
    pub fn warnings_in_file(&self, warnings: Warnings) -> Warnings {
        self.face_numbers.warnings_in_file(warnings)
    }

    /// Elements of the checked mesh as those of the file, from which faces may be left out.
    pub fn in_file(&self, elements: Elements) -> Elements {
        self.face_numbers.in_file(elements)
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
        let resolved = Resolved::new(recipe, &self.garment, self.mean_edge)?;
        check::levels(&self.garment, &resolved.0.recipe)?;
        Ok(resolved)
    }

    /// The sets that the mesh offers besides its subsets, in the words of a recipe; `recipe` is a resolved one.
    pub fn listed_sets(&self, recipe: &Recipe) -> Vec<ListedSet> {
        SetEvaluator::new(&self.garment, &recipe.sim.uv_set).list()
    }

    /// The elements of an expression of a set; `recipe` is a resolved one. Errors name `place`.
    ///
    /// # Errors
    /// A text that is not an expression, or that does not fit the mesh.
    pub fn derived_set(&self, recipe: &Recipe, place: &str, expression: &str) -> Result<DerivedSet, Error> {
        SetEvaluator::new(&self.garment, &recipe.sim.uv_set).evaluate(expression).map_err(|fault| fault.at(place))
    }

    /// The products of a recipe, at all its levels of detail. Steps whose input is the same as before are not repeated.
    ///
    /// # Errors
    /// Faults of the recipe, products that would be too large, and cancellation. The results of earlier steps stay.
    pub fn update(&mut self, recipe: &Recipe) -> Result<Products, Error> {
        let (resolved, of_recipe) = self.checked(recipe)?;
        let mut products = self.update_first(resolved, of_recipe)?;
        self.add_levels(&mut products)?;
        Ok(products)
    }

    /// The products of the first level.
    fn update_first(&mut self, resolved: Resolved, of_recipe: Warnings) -> Result<Products, Error> {
        let Resolved { recipe, sim, sets } = resolved;
        self.derive(sets);
        let sim = self.simulate(&sim)?;
        let render = self.render(&recipe)?;
        let stack = self.stack(&recipe)?;
        let mut clock = Clock::new(&self.progress);
        let cloth = self.cloth.cloth(&recipe, &sim.simulated, &mut clock)?;
        let origins = || self.render.origins(&stack);
        let binding = self.cloth.binding(&sim.simulated, &render.mesh, origins, &mut clock)?;
        let cage_binding = self.cloth.cage_binding(&sim.simulated, || self.render.cage_origins())?;
        clock.finish()?;
        let (cloth, of_cloth) = cloth.unzip();
        let mut of_steps = of_recipe;
        of_steps.extend(sim.warnings);
        of_steps.extend(render.warnings);
        of_steps.extend(of_cloth.unwrap_or_default());
        let mut warnings = self.warnings.clone();
        warnings.extend(self.face_numbers.warnings_in_file(of_steps));
        Ok(Products {
            sim: self.frame.sim(&sim.mesh)?,
            render: self.frame.render(&render.mesh)?,
            cloth: cloth.map(|cloth| self.frame.cloth(&cloth)).transpose()?,
            binding,
            cage_binding,
            levels: Vec::new(),
            level_bindings: Vec::new(),
            recipe,
            operators: render.operators,
            operator_sets: render.operator_sets,
            warnings,
            timings: [sim.timings, render.timings, clock.timings].concat(),
            simulated: sim.simulated,
        })
    }

    /// The resolved recipe of products that are not too large.
    fn checked(&self, recipe: &Recipe) -> Result<(Resolved, Warnings), Error> {
        let (resolved, warnings) = self.resolved(recipe)?;
        sim::check_size(&self.garment, &resolved.sim, self.max_faces)?;
        self.estimated(&resolved)?.check(self.max_memory)?;
        Ok((resolved, warnings))
    }

    /// Gives the steps of both products the garment with its derived sets.
    fn derive(&mut self, sets: RecipeSets) {
        self.derive_sim(sets.sim);
        self.derive_render(sets.render);
    }

    /// The steps of the simulation mesh begin anew where its derived sets are new.
    fn derive_sim(&mut self, sets: Vec<Subset>) {
        if sets != self.sets.sim {
            let local = self.with_sets(&sets);
            self.sim = SimSteps::new(Arc::clone(&local));
            self.cloth = ClothSteps::new(local, self.mean_edge);
            self.sets.sim = sets;
        }
    }

    /// The steps of the render mesh begin anew where its derived sets are new.
    fn derive_render(&mut self, sets: Vec<Subset>) {
        if sets != self.sets.render {
            self.render = RenderSteps::new(self.with_sets(&sets));
            self.sets.render = sets;
        }
    }

    /// The garment in its frame, with more sets.
    fn with_sets(&self, sets: &[Subset]) -> Arc<Mesh> {
        let local = self.frame.enter(&self.garment);
        if sets.is_empty() {
            return local;
        }
        let subsets = local.subsets.iter().chain(sets).cloned().collect();
        Arc::new(Mesh { subsets: Arc::new(subsets), ..Mesh::clone(&local) })
    }

    /// The simulation mesh alone.
    ///
    /// # Errors
    /// As [`Builder::update`].
    pub fn update_sim(&mut self, recipe: &Recipe) -> Result<SimUpdate, Error> {
        let (resolved, warnings) = self.resolved(recipe)?;
        sim::check_size(&self.garment, &resolved.sim, self.max_faces)?;
        self.derive_sim(resolved.sets.sim);
        let mut update = self.simulate(&resolved.sim)?;
        update.warnings.extend(warnings);
        let warnings = self.face_numbers.warnings_in_file(update.warnings);
        Ok(SimUpdate { mesh: self.frame.sim(&update.mesh)?, warnings, ..update })
    }

    /// The render mesh alone.
    ///
    /// # Errors
    /// As [`Builder::update`].
    pub fn update_render(&mut self, recipe: &Recipe) -> Result<RenderUpdate, Error> {
        let Resolved { recipe, sets, .. } = self.resolved(recipe)?.0;
        self.derive_render(sets.render);
        let update = self.render(&recipe)?;
        let warnings = self.face_numbers.warnings_in_file(update.warnings);
        Ok(RenderUpdate { mesh: self.frame.render(&update.mesh)?, warnings, ..update })
    }

    /// The simulation mesh of resolved options, in the frame.
    fn simulate(&mut self, sim: &ResolvedSim) -> Result<SimUpdate, Error> {
        let mut clock = Clock::new(&self.progress);
        let simulated = self.sim.update(sim, self.max_faces, &mut clock)?;
        clock.finish()?;
        let mut warnings = simulated.remeshed.warnings.clone();
        warnings.extend(simulated.warnings.iter().cloned());
        Ok(SimUpdate { mesh: Arc::clone(&simulated.mesh), warnings, timings: clock.timings, simulated })
    }

    /// The render mesh of a resolved recipe, in the frame.
    fn render(&mut self, recipe: &Recipe) -> Result<RenderUpdate, Error> {
        let mut clock = Clock::new(&self.progress);
        let stack = self.stack(recipe)?;
        let made = clock.run("render", || self.render.update(&stack))?;
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

    fn stack(&self, recipe: &Recipe) -> Result<Stack, Error> {
        let mut stack = Stack::new(&recipe.render, &recipe.operators())?;
        stack.names.extend(self.own_operators.iter().map(|operator| operator.label()));
        stack.operators.extend(self.own_operators.iter().cloned());
        Ok(stack)
    }

    /// An estimate of the memory that the kept results hold. \[bytes\]
    pub fn bytes(&self) -> usize {
        let own = self.sim.bytes() + self.render.bytes() + self.cloth.bytes() + self.frame.bytes();
        self.garment.bytes() + own + self.levels.iter().map(Self::bytes).sum::<usize>()
    }
}
