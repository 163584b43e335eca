//! Read, check, subdivide, simulate, render, transfer: what the command, the plugin and the crate's users all run.

use crate::error::{EXAMPLES, Error, Warning, Warnings};
use crate::garment::{BoundaryInterpolation, Garment, GarmentError, GarmentInput, Problem, Scheme, check_garment};
use crate::mesh::{FaceId, IdVec, Topology, VertexId};
use crate::recipe::{Bound, Layers, Recipe, bind};
use crate::render::{Afresh, Rendered, Stack, render};
use crate::report::{RenderFigures, SimFigures, SubsetArea, subset_areas};
use crate::sim::{Baseline, CurveGap, Lengths, RemeshReport, SimProduct, holes, simulate};
use crate::subdivide::{Level, MAX_REFINED_FACES, refined_faces};
use crate::transfer::{Transferred, transfer};
use serde::Serialize;
use std::sync::Arc;
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

/// Mean edges with which areas, and ratios of areas, stay within 32 bits. \[stage units\]
const USABLE_LENGTHS: std::ops::RangeInclusive<f32> = 1e-8..=1e8;

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
    /// The operators of the render mesh, in their order.
    pub operators: Vec<String>,
    /// Names of the face sets that they made.
    pub operator_sets: Vec<String>,
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
pub(crate) struct Clock<'a> {
    stages: Vec<Stage>,
    progress: &'a (dyn Fn(&str) + Sync),
}

impl Default for Clock<'_> {
    fn default() -> Self {
        Self { stages: Vec::new(), progress: &|_| () }
    }
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

/// A garment that can be worked on, whatever the recipe.
#[derive(Clone)]
pub struct Checked {
    /// The garment.
    pub garment: Arc<Garment>,
    mean_edge: f32,
}

impl Checked {
    /// Checks a garment.
    ///
    /// # Errors
    /// Faults of the garment.
    pub fn new(input: GarmentInput, warnings: &mut Warnings) -> Result<Self, Error> {
        let garment = check_garment(input, warnings)?;
        let mean_edge = mean_edge_length(&garment);
        check_extent(&garment, mean_edge)?;
        if garment.prim.rfind('/') == Some(0) {
            warnings.push(Warning::RootMesh { prim: garment.prim.clone() });
        }
        if garment.rules.scheme == Scheme::None {
            warnings.push(Warning::PolygonalCage);
        }
        Ok(Self { garment: Arc::new(garment), mean_edge })
    }

    /// Settles the recipe of the garment.
    ///
    /// # Errors
    /// Faults of the recipe.
    pub fn prepare(&self, layers: &Layers) -> Result<Prepared, Error> {
        let mut recipe = layers.recipe()?;
        settle_lengths(self.mean_edge, &mut recipe);
        let uv_set_was_given = layers.says("sim", "uvSet");
        bind(&recipe, &self.garment, uv_set_was_given)?;
        Ok(Prepared { garment: Arc::clone(&self.garment), recipe, uv_set_was_given })
    }
}

/// A checked garment with the recipe that is its own, and the stages that make its products.
pub struct Prepared {
    /// The garment.
    pub garment: Arc<Garment>,
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
        Checked::new(input, warnings)?.prepare(layers)
    }

    fn bound(&self) -> Result<Bound<'_>, Error> {
        bind(&self.recipe, &self.garment, self.uv_set_was_given)
    }

    fn baseline(&self) -> Result<Baseline, Error> {
        let (sim, bound) = (&self.recipe.sim, self.bound()?);
        let lengths = Lengths { min: sim.min_edge_length, max: sim.max_edge_length, density: bound.density };
        Ok(Baseline::new(&self.garment, sim, lengths, bound.uv_set))
    }

    /// What [`Prepared::build`] would do.
    ///
    /// # Errors
    /// As [`Prepared::build`].
    pub fn plan(&self) -> Result<Plan, Error> {
        self.check_levels()?;
        let baseline = self.baseline()?;
        Ok(Plan {
            recipe: self.recipe.clone(),
            expected_faces: self.expected_faces()?,
            chains: baseline.chains.len(),
            render_faces: self.render_faces()?,
        })
    }

    /// Triangles that the target lengths ask for on the cage, all of them equilateral.
    fn expected_faces(&self) -> Result<usize, Error> {
        let (sim, garment) = (&self.recipe.sim, &self.garment);
        let lengths = Lengths { min: sim.min_edge_length, max: sim.max_edge_length, density: self.bound()?.density };
        let wanted = garment.faces.ids().map(|face| {
            let vertices = garment.faces.vertices_of(face);
            let sum: f64 = vertices.iter().map(|&v| f64::from(lengths.at(v))).sum();
            let target = sum / vertices.len() as f64;
            0.5 * doubled_area(garment, face) / (0.25 * 3f64.sqrt() * target * target)
        });
        // Rounds up, and saturates where the lengths are absurdly small.
        Ok(wanted.sum::<f64>().ceil() as usize)
    }

    fn fault(&self, fault: &str, hint: &str) -> Error {
        Error::Recipe(format!("{}: {fault}\n  hint: {hint}", self.garment.prim))
    }

    /// Whether the simulation mesh is of a size that was allowed, before any work.
    fn check_sizes(&self, max_faces: usize) -> Result<(), Error> {
        let expected = self.expected_faces()?;
        if expected > max_faces {
            let fault = format!("the target lengths ask for about {expected} triangles, more than {max_faces}");
            return Err(
                self.fault(&fault, "raise sim.minEdgeLength or sim.maxEdgeLength, or --max-faces of the command")
            );
        }
        self.check_levels()
    }

    /// Whether the refined meshes can be held.
    fn check_levels(&self) -> Result<(), Error> {
        let (sim, render) = (self.recipe.sim.baseline_level, self.recipe.render.level);
        for (key, level) in [("sim.baselineLevel", sim), ("render.level", render)] {
            let faces = refined_faces(&self.garment, level);
            if faces > MAX_REFINED_FACES && level > 0 {
                let fault = format!("{key} {level} makes {faces} faces, more than {MAX_REFINED_FACES}");
                return Err(self.fault(&fault, "lower the level"));
            }
        }
        Ok(())
    }

    /// The simulation mesh with its places on the surface: the stages "baseline" and "remesh".
    pub(crate) fn remesh(
        &self,
        max_faces: usize,
        clock: &mut Clock<'_>,
        warnings: &mut Warnings,
    ) -> Result<SimProduct, Error> {
        self.check_sizes(max_faces)?;
        let baseline = clock.run("baseline", || self.baseline())?;
        // Constraints may need more than the lengths alone ask for, but not without bound.
        let cap = max_faces.saturating_mul(4);
        let product = clock.run("remesh", || simulate(baseline, self.recipe.sim.iterations, cap));
        if product.triangles.len() >= cap {
            warnings.push(Warning::FaceLimit { faces: product.triangles.len() });
        }
        warn_of_gaps(&product, warnings);
        Ok(product)
    }

    /// The simulation mesh with all its attributes, and the areas of its face subsets: the stage "transfer".
    pub(crate) fn transfer(
        &self,
        product: &SimProduct,
        clock: &mut Clock<'_>,
        warnings: &mut Warnings,
    ) -> Result<(Transferred, Vec<SubsetArea>), Error> {
        let uv_set = self.bound()?.uv_set;
        clock.run("transfer", || {
            let transferred = transfer(&self.garment, product, &self.recipe.sim, uv_set, warnings);
            let areas = subset_areas(product, &transferred, &self.garment);
            warn_of_area(&areas, warnings);
            Ok((transferred, areas))
        })
    }

    /// The operators of the render mesh in their order.
    ///
    /// # Errors
    /// Names of operators that the recipe does not have.
    pub(crate) fn stack(&self) -> Result<Stack, Error> {
        self.check_levels()?;
        Stack::new(self.garment.points.len(), &self.recipe.render, &self.recipe.instances())
    }

    /// The render mesh: the stage "render".
    fn render(&self, stack: &Stack, clock: &mut Clock<'_>, warnings: &mut Warnings) -> Result<Rendered, Error> {
        let rendered = clock.run("render", || render(&self.garment, stack, &Afresh))?;
        warnings.extend(&rendered.warnings);
        Ok(rendered)
    }

    /// Faces of the render mesh: what operators make of the cage, and then each refinement.
    fn render_faces(&self) -> Result<usize, Error> {
        let stack = self.stack()?;
        let level = stack.level;
        let cage = render(&self.garment, &Stack { level: 0, ..stack }, &Afresh)?.mesh;
        Ok(refined_faces(&cage, level))
    }

    /// Builds both products.
    ///
    /// # Errors
    /// A mesh that would be too large.
    pub fn build(&self, limits: &Limits<'_>, warnings: &mut Warnings) -> Result<Products, Error> {
        let mut clock = Clock { stages: Vec::new(), progress: limits.progress };
        let product = self.remesh(limits.max_faces, &mut clock, warnings)?;
        let (transferred, areas) = self.transfer(&product, &mut clock, warnings)?;
        let stack = self.stack()?;
        let Rendered { mesh: render, sets, .. } = self.render(&stack, &mut clock, warnings)?;
        let (sim_figures, render_figures) =
            clock.run("figures", || (SimFigures::new(&product, &transferred, areas), RenderFigures::new(&render)));
        Ok(Products {
            sim: transferred.mesh,
            render,
            sim_figures,
            render_figures,
            remesh: product.report,
            recipe: self.recipe.clone(),
            operators: stack.names,
            operator_sets: sets,
            stages: clock.stages,
        })
    }
}

/// Checks that there is a surface to work on: faces that are drawn, of some area, in numbers that can be squared.
fn check_extent(garment: &Garment, mean: f32) -> Result<(), Error> {
    let fault = |attribute: &str, fault: String, remedy: &str| {
        let problem = Problem { attribute: attribute.into(), fault, remedy: remedy.into() };
        Err(GarmentError { prim: garment.prim.clone(), problems: vec![problem], more: 0 }.into())
    };
    let mut places = garment.faces.corners().iter().map(|&v| garment.points[v]);
    let first = places.next();
    if places.all(|p| Some(p) == first) {
        let all = "the edges have no length: all points are in one place";
        return fault("points", all.into(), "give the points their positions");
    }
    if !USABLE_LENGTHS.contains(&mean) {
        let remedy = "scale the points, and metersPerUnit with them, so that a garment measures 0.1 to 1000 units";
        return fault("points", format!("the mean edge length is {mean:e}, too far from 1 to compute with"), remedy);
    }
    if garment.faces.ids().all(|f| doubled_area(garment, f) == 0.0) {
        return fault("points", "no face has an area".into(), "give the points their positions");
    }
    let has_holes = !garment.holes.is_empty() || garment.rules.boundary == BoundaryInterpolation::None;
    if has_holes && holes(garment, &Level::base(garment)).iter().all(|&h| h) {
        let all = "no face is left: all are holes, or at a border with interpolateBoundary \"none\"";
        return fault(
            "holeIndices",
            all.into(),
            "take faces out of holeIndices, or set interpolateBoundary to edgeAndCorner",
        );
    }
    Ok(())
}

/// Twice the area of a face, up to its sign.
fn doubled_area(garment: &Garment, face: FaceId) -> f64 {
    let vertices = garment.faces.vertices_of(face);
    let at = |v: &VertexId| garment.points[*v].as_dvec3();
    let origin = at(&vertices[0]);
    let fan = vertices.windows(2).map(|p| (at(&p[0]) - origin).cross(at(&p[1]) - origin));
    fan.sum::<glam::DVec3>().length()
}

/// Distance of a curve from its edges that is worth a warning. \[target lengths\]
const CURVE_GAP: f32 = 0.1;

/// Warns of borders, seams and constraints that the mesh's edges do not follow.
fn warn_of_gaps(product: &SimProduct, warnings: &mut Warnings) {
    let given = product.gaps.iter().zip(product.baseline.chains.iter()).filter(|(_, chain)| !chain.kind.ridge);
    let mut gaps: Vec<&CurveGap> = given.map(|(gap, _)| gap).filter(|gap| gap.distance > CURVE_GAP).collect();
    gaps.sort_by(|a, b| b.distance.total_cmp(&a.distance).then(a.near.cmp(&b.near)));
    let Some(first) = gaps.first() else { return };
    let examples = gaps.iter().take(EXAMPLES).map(|gap| gap.near.index()).collect();
    warnings.push(Warning::CurvesCut { count: gaps.len(), farthest: first.distance, examples });
}

/// Share of a face subset's area whose loss or gain is worth a warning. Chords of a curved border alone stay below it.
const AREA_CHANGE: f64 = 0.05;

/// Warns of face subsets that have another area than on the surface.
fn warn_of_area(areas: &[SubsetArea], warnings: &mut Warnings) {
    let change = |s: &SubsetArea| (s.area - s.source_area).abs() / s.source_area;
    let changed: Vec<&SubsetArea> = areas.iter().filter(|s| s.source_area > 0.0 && change(s) > AREA_CHANGE).collect();
    if !changed.is_empty() {
        warnings.push(Warning::AreaChanged {
            largest: changed.iter().map(|s| change(s)).fold(0.0, f64::max) as f32,
            sets: changed.iter().map(|s| s.name.clone()).collect(),
        });
    }
}

/// Replaces automatic lengths by multiples of the garment's mean edge length.
fn settle_lengths(mean_edge: f32, recipe: &mut Recipe) {
    let sim = &mut recipe.sim;
    if sim.max_edge_length <= 0.0 {
        sim.max_edge_length = (0.5 * mean_edge).max(sim.min_edge_length);
    }
    if sim.min_edge_length <= 0.0 {
        sim.min_edge_length = sim.max_edge_length * if sim.density.is_empty() { 1.0 } else { 0.5 };
    }
    recipe.instances_mut().for_each(|options| options.settle(mean_edge));
}

/// Mean length of the garment's edges. \[stage units\]
pub fn mean_edge_length(garment: &Garment) -> f32 {
    let t = Topology::new(garment.faces.clone(), garment.points.len());
    let points: &IdVec<VertexId, glam::Vec3> = &garment.points;
    let sum: f64 = t.edges.iter().map(|&[a, b]| f64::from(points[a].distance(points[b]))).sum();
    (sum / t.edges.len().max(1) as f64) as f32
}
