//! The cached steps of one stage: a garment through operators, then through refinements.
//!
//! ```text
//! cage → operator → operator → … → refinement → …    connectivity and attributes
//! points → points → points → …  → points → …          in parallel with the next step above
//! ```
//!
//! Each [`Step`] caches its last result by its input. An edit of heights recomputes points alone. An edit of widths
//! mostly gives the same faces, which keeps levels and refinements too.

mod origins;
mod refinement;

pub use origins::{OriginTrace, Origins};

use super::Stage;
use crate::contact::Clearance;
use crate::render::fold::halving;
use crate::render::operator::{Ancestry, DerivedCage, Operator, OperatorInput};
use crate::render::placement::{FlatPoints, LimitSurface, Placement};
use crate::render::points::CagePoints;
use crate::render::reference::ReferenceNormals;
use crate::render::{add_border_holes, check_size};
use glam::Vec3;
use refinement::{Refined, RefinementSteps, from_parents, refined, refined_inputs, refined_points};
use std::sync::Arc;
use tailor_mesh::connectivity::{FaceId, IdVec, VertexId};
use tailor_mesh::error::{Error, Warnings};
use tailor_mesh::garment::Mesh;
use tailor_mesh::step::{Same, Step};
use tailor_mesh::subdivide::{Carrier, Connectivity, Level, refined_faces, same_level};

/// The product of a stage. Its joint influences are lists for each vertex, as operators and refinements need them.
#[derive(Clone)]
pub struct Made {
    /// The mesh, from which the next stage starts.
    pub end: Start,
    /// Names of the face sets of operators.
    pub sets: Vec<String>,
    /// Warnings of the operators.
    pub warnings: Warnings,
}

/// The start of a stage.
#[derive(Clone)]
pub struct Start {
    /// The mesh.
    pub garment: Arc<Mesh>,
    /// The vertex of the input garment at or beside each of its vertices.
    pub inputs: Arc<InputVertices>,
    /// The face of the input garment that each of its faces is part of.
    pub sources: Arc<SourceFaces>,
    /// Which of its faces are of hems and inner layers.
    pub covers: Arc<Covers>,
}

/// For each vertex of a mesh, the vertex of the input garment at or beside it, for messages.
pub type InputVertices = IdVec<VertexId, VertexId>;

/// For each face of a mesh, the face of the input garment that it is part of.
pub type SourceFaces = IdVec<FaceId, FaceId>;

/// For each face of a mesh, whether it is of a hem or of an inner layer.
pub type Covers = IdVec<FaceId, bool>;

/// An operator, compared by its output.
struct SameOutput(Arc<dyn Operator>);

impl PartialEq for SameOutput {
    fn eq(&self, other: &Self) -> bool {
        self.0.has_same_output(other.0.as_ref())
    }
}

/// An operator, compared by all of its options.
struct SameOperator(Arc<dyn Operator>);

impl PartialEq for SameOperator {
    fn eq(&self, other: &Self) -> bool {
        self.0.is_same(other.0.as_ref())
    }
}

/// A cage, compared by the inputs of its level.
struct SameLevel(Arc<DerivedCage>);

impl PartialEq for SameLevel {
    fn eq(&self, other: &Self) -> bool {
        same_level(&self.0.frame, &other.0.frame)
    }
}

/// A cage of the stage. Its points are without heights.
#[derive(Clone)]
pub(super) struct Cage {
    garment: Arc<Mesh>,
    pub(super) level: Arc<Level>,
}

/// The output of an operator, and the cage with all attributes.
#[derive(Clone)]
struct OperatorCage {
    derived: Arc<DerivedCage>,
    cage: Cage,
}

/// The points of an operator's cage, the masks of its refinement, and warnings of reduced heights.
#[derive(Clone)]
struct CageResult {
    points: Arc<CagePoints>,
    connectivity: Arc<Connectivity>,
    warnings: Arc<Warnings>,
}

/// The input of an operator's output: the operator, its parent, the clearance there, and whether sets are named.
/// The rest of the ancestry follows from the parent.
type OutputInput = (SameOutput, Same<Mesh>, Same<IdVec<VertexId, Clearance>>, bool);

/// Steps to the cage of an operator.
#[derive(Default)]
struct CageSteps {
    derived: Step<OutputInput, Arc<DerivedCage>>,
    level: Step<SameLevel, Arc<Level>>,
    garment: Step<Same<DerivedCage>, Arc<Mesh>>,
}

impl CageSteps {
    fn update(
        &mut self,
        operator: &Arc<dyn Operator>,
        parent: &Cage,
        context: &Context,
    ) -> Result<OperatorCage, Error> {
        let (operator, clearance) = (SameOutput(Arc::clone(operator)), Same::from(&context.ancestry.clearance));
        let input = (operator, Same::from(&parent.garment), clearance, context.names_sets);
        let derived = self.derived.get(input, |(operator, ..)| {
            let input = OperatorInput {
                garment: &parent.garment,
                level: &parent.level,
                clearance: &context.ancestry.clearance,
                inputs: &context.inputs,
                covers: &context.ancestry.covers,
                names_sets: context.names_sets,
            };
            DerivedCage::new(operator.0.as_ref(), &input, &context.ancestry).map(Arc::new)
        })?;
        let level = self.level.get(SameLevel(Arc::clone(&derived)), |_| Ok(Arc::new(Level::base(&derived.frame))))?;
        let garment = self.garment.get(Same::from(&derived), |_| {
            let carrier = Carrier::new(&parent.garment, &derived.output.derivation);
            let (primvars, influences) = (carrier.primvars(), carrier.influences());
            Ok(Arc::new(Mesh { primvars, influences, ..derived.frame.clone() }))
        })?;
        Ok(OperatorCage { derived, cage: Cage { garment, level } })
    }
}

/// Inputs of an operator besides its cage.
struct Context {
    ancestry: Ancestry,
    inputs: Arc<InputVertices>,
    names_sets: bool,
}

/// The input of a placement: the cage, its connectivity and its parent's.
type PlacementInput = (Same<DerivedCage>, Same<Connectivity>, Same<Connectivity>);
type Points = IdVec<VertexId, Vec3>;
/// The input of a limit surface: the parent, its points, and the faces where it is asked for.
type SurfaceInput = (Same<Connectivity>, Points, Vec<FaceId>);
/// The input of raised points; true for the last cage.
type RaisedInput = (SameOperator, Same<FlatPoints>, bool);

/// Steps to the points of an operator's cage.
#[derive(Default)]
struct PointSteps {
    connectivity: Step<Same<Level>, Arc<Connectivity>>,
    placement: Step<PlacementInput, Arc<Placement>>,
    surface: Step<SurfaceInput, Arc<LimitSurface>>,
    flat: Step<(Same<Placement>, Same<CagePoints>), Arc<FlatPoints>>,
    raised: Step<RaisedInput, (Arc<CagePoints>, Arc<Warnings>)>,
    surface_without_heights: Step<SurfaceInput, Arc<LimitSurface>>,
    origins: Step<(Same<Placement>, Points), Arc<Points>>,
}

impl PointSteps {
    fn update(
        &mut self,
        operator: &Arc<dyn Operator>,
        child: &OperatorCage,
        parent: (&Arc<Connectivity>, &Arc<CagePoints>),
        is_last: bool,
    ) -> Result<CageResult, Error> {
        let connectivity = connectivity(&mut self.connectivity, &child.cage.level)?;
        let input = (Same::from(&child.derived), Same::from(&connectivity), Same::from(parent.0));
        let placement = self.placement.get(input, |(derived, child, parent)| {
            Ok(Arc::new(Placement::new(Arc::clone(&derived.0), Arc::clone(&child.0), Arc::clone(&parent.0))))
        })?;
        let surface = surface(&mut self.surface, &placement, &parent.1.points)?;
        let input = (Same::from(&placement), Same::from(parent.1));
        let flat = self.flat.get(input, |(placement, parent)| Ok(Arc::new(placement.flat(&surface, parent))))?;
        let input = (SameOperator(Arc::clone(operator)), Same::from(&flat), is_last);
        let (points, warnings) = self.raised.get(input, |_| {
            let (points, warnings) = placement.raised(operator.as_ref(), &flat, is_last);
            Ok((Arc::new(points), Arc::new(warnings)))
        })?;
        Ok(CageResult { points, connectivity, warnings })
    }

    /// The points without the heights of any operator, from those of the parent. None before [`PointSteps::update`].
    fn origins(&mut self, parent: Points) -> Result<Option<Arc<Points>>, Error> {
        let Some(placement) = self.placement.last() else { return Ok(None) };
        let known = self.flat.last().and_then(|flat| flat.fitted_on(&parent));
        let of_surface = &mut self.surface_without_heights;
        let points = self.origins.get((Same::from(placement), parent), |(placement, parent)| match known {
            Some(points) => Ok(Arc::new(points.clone())),
            None => Ok(Arc::new(placement.fitted(&*surface(of_surface, placement, parent)?, parent))),
        });
        points.map(Some)
    }
}

fn surface(
    step: &mut Step<SurfaceInput, Arc<LimitSurface>>,
    placement: &Placement,
    points: &Points,
) -> Result<Arc<LimitSurface>, Error> {
    let (parent, faces) = placement.surface_inputs();
    let input = (Same::from(parent), points.clone(), faces.to_vec());
    step.get(input, |(_, points, _)| Ok(Arc::new(placement.surface(points))))
}

fn connectivity(
    step: &mut Step<Same<Level>, Arc<Connectivity>>,
    level: &Arc<Level>,
) -> Result<Arc<Connectivity>, Error> {
    step.get(Same::from(level), |level| Ok(Arc::new(Connectivity::new(Arc::clone(&level.0)))))
}

/// The input vertices, the source faces and the covering faces of a product.
type Carried = (Arc<InputVertices>, Arc<SourceFaces>, Arc<Covers>);

/// The cached steps of a stage.
#[derive(Default)]
pub struct StageSteps {
    first: Step<Same<Mesh>, Cage>,
    first_points: Step<(Same<Mesh>, u32), Arc<CagePoints>>,
    first_ancestry: Step<(Same<CagePoints>, Same<Covers>), Ancestry>,
    first_connectivity: Step<Same<Level>, Arc<Connectivity>>,
    cages: Vec<CageSteps>,
    points: Vec<PointSteps>,
    refinements: Vec<RefinementSteps>,
    carried: Step<(Same<Mesh>, Same<SourceFaces>), Carried>,
    mesh: Step<(Same<Mesh>, Same<CagePoints>, u32), Arc<Mesh>>,
}

/// The cage before all operators, and its points.
type First = (Cage, Arc<CagePoints>);

/// Cages and points of all operators.
struct StageCages {
    cages: Vec<OperatorCage>,
    raised: Vec<CageResult>,
}

impl StageSteps {
    /// The mesh of a stage from a garment.
    ///
    /// A polygonal mesh (`subdivisionScheme = "none"`) is refined as if bilinear and stays polygonal.
    ///
    /// # Errors
    /// Operators that do not fit the garment; a mesh that would be too large.
    pub fn update(&mut self, start: &Start, stage: &Stage) -> Result<Made, Error> {
        let stage = &self.with_halving(start, stage)?;
        let first = self.first(start, stage)?;
        let (StageCages { cages, raised }, (refined, refinements)) = self.operate(&first, start, stage)?;
        let points = raised.last().map_or(&first.1, |last| &last.points);
        let mesh = self.mesh.get((Same::from(&refined), Same::from(points), stage.level), |_| {
            let known = raised.last().map(|last| last.connectivity.as_ref());
            let points = refined_points(&points.points, known, &refinements);
            Ok(Arc::new(Mesh { points, ..Mesh::clone(&refined) }))
        })?;
        let input = (Same::from(&refined), Same::from(&start.sources));
        let (inputs, sources, covers) = self.carried.get(input, |_| {
            let of_cage = cages.last().map(|cage| (&cage.derived.output.inputs, &cage.derived.ancestry));
            let (inputs, sources, covers) = match of_cage {
                None => (&start.inputs, SourceFaces::clone(&start.sources), &start.covers),
                Some((inputs, a)) => (inputs, a.faces.iter().map(|&face| start.sources[face]).collect(), &a.covers),
            };
            let inputs = refined_inputs(InputVertices::clone(inputs), &refinements);
            let covers = from_parents(Covers::clone(covers), &refinements);
            Ok((Arc::new(inputs), Arc::new(from_parents(sources, &refinements)), Arc::new(covers)))
        })?;
        let mut warnings = Warnings::default();
        for (cage, raised) in cages.iter().zip(&raised) {
            warnings.extend(cage.derived.output.warnings.iter().chain(raised.warnings.iter()).cloned());
        }
        let subsets = cages.iter().flat_map(|cage| &cage.derived.output.subsets);
        let sets = subsets.map(|set| set.name.clone()).collect();
        Ok(Made { end: Start { garment: mesh, inputs, sources, covers }, sets, warnings })
    }

    /// The stage, after operators that halve faces at its folds if some bend too far.
    fn with_halving(&mut self, start: &Start, stage: &Stage) -> Result<Stage, Error> {
        let folds = stage.operators.iter().filter(|operator| !operator.folded_sets().is_empty());
        let amount = folds.clone().map(|fold| fold.reach(&start.garment)).fold(0.0, f32::max);
        let folded: Vec<String> = folds.flat_map(|fold| fold.folded_sets()).collect();
        let mut stage = stage.clone();
        if !folded.is_empty() {
            let first = self.first_cage(start)?;
            stage.operators.splice(0..0, halving(&first.garment, &first.level, &folded, amount));
        }
        Ok(stage)
    }

    pub(super) fn first_cage(&mut self, start: &Start) -> Result<Cage, Error> {
        self.first.get(Same::from(&start.garment), |garment| Ok(Cage::first(garment)))
    }

    /// The cage before all operators, and its points with the clearance within the reach of the stage.
    fn first(&mut self, start: &Start, stage: &Stage) -> Result<First, Error> {
        let first = self.first_cage(start)?;
        let reach = stage.reach(&start.garment);
        let points = || Ok(Arc::new(CagePoints::first(&first.garment, &first.level, reach)));
        let points = self.first_points.get((Same::from(&start.garment), reach.to_bits()), |_| points())?;
        Ok((first, points))
    }

    fn context(&mut self, (first, points): &First, start: &Start, stage: &Stage) -> Result<Context, Error> {
        let input = (Same::from(points), Same::from(&start.covers));
        let ancestry = self.first_ancestry.get(input, |(points, covers)| Ok(first.ancestry(points, &covers.0)))?;
        Ok(Context { ancestry, inputs: Arc::clone(&start.inputs), names_sets: stage.names_sets })
    }

    /// Runs all operators and refines the attributes of the last cage. The points of a cage are computed in parallel
    /// with the connectivity of the next operator, those of the last cage in parallel with the refinement.
    fn operate(&mut self, begin: &First, start: &Start, stage: &Stage) -> Result<(StageCages, Refined), Error> {
        let (first, points) = begin;
        let mut done = StageCages { cages: Vec::new(), raised: Vec::new() };
        let count = stage.operators.len();
        self.refinements.resize_with(stage.level as usize, RefinementSteps::default);
        if count == 0 {
            return Ok((done, refined(&mut self.refinements, first)?));
        }
        let mut context = self.context(begin, start, stage)?;
        let Self { cages, points: point_steps, refinements, .. } = self;
        cages.resize_with(count, CageSteps::default);
        point_steps.resize_with(count, PointSteps::default);
        let first_connectivity = connectivity(&mut self.first_connectivity, &first.level)?;
        let mut raise = |done: &StageCages| {
            let Some((number, child)) = done.cages.iter().enumerate().next_back() else { return Ok(None) };
            let parent = done.raised.last().map_or((&first_connectivity, points), |r| (&r.connectivity, &r.points));
            let operator = &stage.operators[number];
            point_steps[number].update(operator, child, parent, number + 1 == count).map(Some)
        };
        for (operator, steps) in stage.operators.iter().zip(cages) {
            let parent = done.cages.last().map_or(first, |last| &last.cage);
            let (raised, cage) = rayon::join(|| raise(&done), || steps.update(operator, parent, &context));
            let cage = cage?;
            context.ancestry = cage.derived.ancestry.clone();
            context.inputs = Arc::clone(&cage.derived.output.inputs);
            done.raised.extend(raised?);
            done.cages.push(cage);
        }
        let last = done.cages.last().map_or(first, |last| &last.cage);
        check_size(&last.garment, stage.level)?;
        let (raised, refined) = rayon::join(|| raise(&done), || refined(refinements, last));
        let refined = refined?;
        done.raised.extend(raised?);
        Ok((done, refined))
    }

    /// The number of faces of [`StageSteps::update`], computed without points.
    ///
    /// # Errors
    /// As [`StageSteps::update`].
    pub fn face_count(&mut self, start: &Start, stage: &Stage) -> Result<usize, Error> {
        let stage = &self.with_halving(start, stage)?;
        let first = self.first(start, stage)?;
        self.cages.resize_with(stage.operators.len(), CageSteps::default);
        let mut context = self.context(&first, start, stage)?;
        let mut cage = first.0;
        for (operator, steps) in stage.operators.iter().zip(&mut self.cages) {
            let next = steps.update(operator, &cage, &context)?;
            context.ancestry = next.derived.ancestry.clone();
            context.inputs = Arc::clone(&next.derived.output.inputs);
            cage = next.cage;
        }
        Ok(refined_faces(&cage.garment, stage.level))
    }
}

impl StageSteps {
    /// Memory per corner of a cage: level, masks, limits, parents, placement. Measured on garments of 10 to 100
    /// thousand corners. \[bytes\]
    const CAGE_CORNER: usize = 300;

    /// An estimate of the memory of all cached steps. \[bytes\]
    pub fn bytes(&self) -> usize {
        let cages = self.cages.iter().filter_map(|steps| steps.garment.last());
        let cages = cages.map(|garment| 2 * garment.bytes() + Self::CAGE_CORNER * garment.faces.corners().len());
        let surfaces =
            self.points.iter().flat_map(|steps| [steps.surface.last(), steps.surface_without_heights.last()]);
        let surfaces = surfaces.flatten().map(|surface| surface.bytes());
        let refinements = self.refinements.iter().map(RefinementSteps::bytes);
        let mesh = self.mesh.last().map_or(0, |mesh| size_of_val(mesh.points.as_slice()));
        self.first.last().map_or(0, |cage| cage.garment.bytes())
            + cages.chain(surfaces).chain(refinements).sum::<usize>()
            + mesh
    }
}

impl Cage {
    /// The cage of a garment before all operators.
    fn first(garment: &Mesh) -> Self {
        let level = Level::base(garment);
        let mut garment = garment.clone();
        add_border_holes(&mut garment, &level);
        if garment.influences.is_none() {
            garment.unpack_influences();
        }
        Self { garment: Arc::new(garment), level: Arc::new(level) }
    }

    fn ancestry(&self, points: &CagePoints, covers: &Arc<Covers>) -> Ancestry {
        Ancestry {
            clearance: Arc::new(points.clearance.clone()),
            reference: Arc::new(ReferenceNormals::first(&self.garment, &self.level)),
            garment: Arc::clone(&self.garment),
            level: Arc::clone(&self.level),
            faces: Arc::new(self.garment.faces.ids().collect()),
            covers: Arc::clone(covers),
        }
    }
}
