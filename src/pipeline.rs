//! Read, check, subdivide, simulate, render, transfer: what the command, the plugin and the crate's users all run.

use crate::error::{Error, Warning, Warnings};
use crate::garment::{Garment, GarmentInput, Primvar, Scheme, check_garment};
use crate::mesh::{IdVec, Topology, VertexId};
use crate::recipe::{Layers, Recipe, bind};
use crate::render::render;
use crate::report::{RenderFigures, SimFigures};
use crate::sim::{Baseline, Lengths, RemeshReport, simulate};
use crate::transfer::transfer;
use serde::Serialize;
use std::time::Instant;

/// Limits and receivers of a run that are no part of the recipe.
pub struct Limits<'a> {
    /// Triangles above which the simulation mesh is not begun. \[triangles\]
    pub max_faces: usize,
    /// Told the name of each stage as it begins.
    pub progress: &'a (dyn Fn(&str) + Sync),
}

/// Largest simulation mesh by default. \[triangles\]
pub const DEFAULT_MAX_FACES: usize = 5_000_000;

/// Time that a stage took.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stage {
    /// Name of the stage.
    pub name: &'static str,
    /// \[seconds\]
    pub seconds: f64,
}

/// The products of one garment.
pub struct Products {
    /// The simulation mesh.
    pub sim: Garment,
    /// The render mesh.
    pub render: Garment,
    /// Figures of the simulation mesh.
    pub sim_figures: SimFigures,
    /// What the remesher did.
    pub remesh: RemeshReport,
    /// Figures of the render mesh.
    pub render_figures: RenderFigures,
    /// The recipe with the lengths that were used.
    pub recipe: Recipe,
    /// Time of each stage.
    pub stages: Vec<Stage>,
}

/// What a garment would become.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Plan {
    /// The recipe with the lengths that would be used.
    pub recipe: Recipe,
    /// Triangles that the target lengths ask for, all of them equilateral.
    pub expected_faces: usize,
    /// Constraint chains.
    pub chains: usize,
    /// Faces of the render mesh.
    pub render_faces: usize,
}

/// Clock of the stages of a run.
struct Clock<'a> {
    stages: Vec<Stage>,
    progress: &'a (dyn Fn(&str) + Sync),
}

impl Clock<'_> {
    fn run<T>(&mut self, name: &'static str, work: impl FnOnce() -> T) -> T {
        (self.progress)(name);
        let start = Instant::now();
        let result = work();
        self.stages.push(Stage { name, seconds: start.elapsed().as_secs_f64() });
        result
    }
}

/// A checked garment with the options that are its own.
pub struct Prepared {
    /// The garment.
    pub garment: Garment,
    /// The recipe with the lengths to use.
    pub recipe: Recipe,
    uv_set_was_given: bool,
}

impl Prepared {
    /// Checks a garment and settles its recipe.
    ///
    /// # Errors
    /// Faults of the garment or of the recipe.
    pub fn new(input: GarmentInput, layers: &Layers, warnings: &mut Warnings) -> Result<Self, Error> {
        let garment = check_garment(input, warnings)?;
        let mut recipe = layers.recipe()?;
        settle_lengths(&garment, &mut recipe);
        let uv_set_was_given = layers.says("sim", "uvSet");
        bind(&recipe, &garment, uv_set_was_given)?;
        if garment.rules.scheme == Scheme::None {
            warnings.push(Warning::PolygonalCage);
        }
        Ok(Self { garment, recipe, uv_set_was_given })
    }

    fn baseline(&self) -> Result<(Baseline, Option<&Primvar>), Error> {
        let bound = bind(&self.recipe, &self.garment, self.uv_set_was_given)?;
        let sim = &self.recipe.sim;
        let lengths = Lengths { min: sim.min_edge_length, max: sim.max_edge_length, density: bound.density };
        Ok((Baseline::new(&self.garment, sim, lengths, bound.uv_set), bound.uv_set))
    }

    /// What [`Prepared::build`] would do.
    ///
    /// # Errors
    /// As [`Prepared::build`].
    pub fn plan(&self) -> Result<Plan, Error> {
        let (baseline, _) = self.baseline()?;
        let corners = self.garment.faces.corners().len();
        let quads = corners * 4usize.pow(self.recipe.render.level.saturating_sub(1));
        Ok(Plan {
            recipe: self.recipe.clone(),
            expected_faces: baseline.expected_faces(),
            chains: baseline.chains.len(),
            render_faces: if self.recipe.render.level == 0 { self.garment.faces.len() } else { quads },
        })
    }

    /// Builds both products.
    ///
    /// # Errors
    /// A simulation mesh that would be too large.
    pub fn build(&self, limits: &Limits<'_>, warnings: &mut Warnings) -> Result<Products, Error> {
        let mut clock = Clock { stages: Vec::new(), progress: limits.progress };
        let (baseline, uv_set) = clock.run("baseline", || self.baseline())?;
        let expected = baseline.expected_faces();
        if expected > limits.max_faces {
            return Err(Error::Recipe(format!(
                "{}: the target lengths ask for about {expected} triangles, more than {}\n  hint: raise sim.minEdgeLength or sim.maxEdgeLength, or --max-faces",
                self.garment.prim, limits.max_faces
            )));
        }
        // Constraints may need more than the lengths alone ask for, but not without bound.
        let cap = limits.max_faces.saturating_mul(4);
        let product = clock.run("remesh", || simulate(baseline, self.recipe.sim.iterations, cap));
        if product.triangles.len() >= cap {
            warnings.push(Warning::FaceLimit { faces: product.triangles.len() });
        }
        let sim = clock.run("transfer", || transfer(&self.garment, &product, &self.recipe.sim, uv_set, warnings));
        let render_mesh = clock.run("render", || render(&self.garment, &self.recipe.render));
        let (sim_figures, render_figures) =
            clock.run("figures", || (SimFigures::new(&product, &sim, &self.garment), RenderFigures::new(&render_mesh)));
        Ok(Products {
            sim,
            render: render_mesh,
            sim_figures,
            render_figures,
            remesh: product.report,
            recipe: self.recipe.clone(),
            stages: clock.stages,
        })
    }
}

/// Replaces automatic lengths by multiples of the garment's mean edge length.
fn settle_lengths(garment: &Garment, recipe: &mut Recipe) {
    let sim = &mut recipe.sim;
    if sim.max_edge_length <= 0.0 {
        sim.max_edge_length = (0.5 * mean_edge_length(garment)).max(sim.min_edge_length);
    }
    if sim.min_edge_length <= 0.0 {
        sim.min_edge_length = sim.max_edge_length * if sim.density.is_empty() { 1.0 } else { 0.5 };
    }
}

/// Mean length of the garment's edges. \[stage units\]
pub fn mean_edge_length(garment: &Garment) -> f32 {
    let t = Topology::new(garment.faces.clone(), garment.points.len());
    let points: &IdVec<VertexId, glam::Vec3> = &garment.points;
    let sum: f64 = t.edges.iter().map(|&[a, b]| f64::from(points[a].distance(points[b]))).sum();
    (sum / t.edges.len().max(1) as f64) as f32
}
