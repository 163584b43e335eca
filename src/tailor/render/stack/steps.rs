//! The cached steps from a garment through a stack of operators to its render mesh, stage by stage.
//!
//! ```text
//! garment → folds → refinements → seams and what follows → refinements → render mesh
//!           '---- first stage ---'  '------ second stage -----------'
//! ```
//!
//! The paper's order: fold-over thickness on the coarse cage, refinement, seams. A seam replaces control points beside
//! its edges, and the coarser the cage, the more of the surface depends on each. The second stage takes the mesh of the
//! first one as its garment.

use super::stage::{InputVertices, OriginTrace, Origins, SourceFaces, StageSteps, Start};
use super::{Stack, Stage};
use std::sync::Arc;
use tailor_mesh::connectivity::{IdVec, VertexId};
use tailor_mesh::error::{Error, Warnings};
use tailor_mesh::garment::Mesh;
use tailor_mesh::step::{Same, Step};
use tailor_mesh::subdivide::to_unit_length;

/// A render mesh.
#[derive(Clone, Debug)]
pub struct RenderResult {
    /// The mesh.
    pub mesh: Arc<Mesh>,
    /// The face of the garment that each of its faces is part of.
    pub sources: Arc<SourceFaces>,
    /// Names of the face sets of operators.
    pub sets: Vec<String>,
    /// Warnings of the operators.
    pub warnings: Warnings,
    /// Refinements before the first seam. \[levels\]
    pub seam_level: u32,
}

/// The cached steps from a garment to its render mesh.
pub struct RenderSteps {
    start: Start,
    stages: [StageSteps; 2],
    mesh: Step<Same<Mesh>, Arc<Mesh>>,
}

impl RenderSteps {
    /// The steps of a garment.
    pub fn new(garment: Arc<Mesh>) -> Self {
        let inputs: InputVertices = (0..garment.points.len()).map(VertexId::new).collect();
        let sources = Arc::new(garment.faces.ids().collect());
        let covers = Arc::new(IdVec::filled(false, garment.faces.len()));
        let start = Start { garment, inputs: Arc::new(inputs), sources, covers };
        Self { start, stages: Default::default(), mesh: Step::default() }
    }

    /// The render mesh.
    ///
    /// # Errors
    /// Operators that do not fit the garment; a mesh that would be too large.
    pub fn update(&mut self, stack: &Stack) -> Result<RenderResult, Error> {
        if stack.is_empty() {
            let Start { garment: mesh, sources, .. } = self.start.clone();
            let warnings = stack.warnings.clone();
            return Ok(RenderResult { mesh, sources, sets: Vec::new(), warnings, seam_level: 0 });
        }
        // Parallel loops start faster from a thread of the pool.
        rayon::scope(|_| self.update_in_pool(stack))
    }

    fn update_in_pool(&mut self, stack: &Stack) -> Result<RenderResult, Error> {
        let mut warnings = stack.warnings.clone();
        let mut sets = Vec::new();
        let mut start = self.start.clone();
        let stages = self.stages_of(stack)?;
        for (steps, stage) in self.stages.iter_mut().zip(&stages) {
            let made = steps.update(&start, stage)?;
            sets.extend(made.sets);
            warnings.extend(made.warnings);
            start = made.end;
        }
        let mesh = self.mesh.get(Same::from(&start.garment), |made| Ok(Arc::new(finished(Mesh::clone(made)))))?;
        Ok(RenderResult { mesh, sources: start.sources, sets, warnings, seam_level: seam_level(&stages) })
    }

    fn stages_of(&mut self, stack: &Stack) -> Result<Vec<Stage>, Error> {
        let topology = &self.stages[0].first_cage(&self.start)?.level.topology;
        Ok(stack.stages(&self.start.garment, topology))
    }

    /// The refinements before the first seam of a stack. \[levels\]
    ///
    /// # Errors
    /// None that [`RenderSteps::update`] has not.
    pub fn seam_level(&mut self, stack: &Stack) -> Result<u32, Error> {
        Ok(seam_level(&self.stages_of(stack)?))
    }

    /// The number of faces of [`RenderSteps::update`]. The points of the last stage are not computed.
    ///
    /// # Errors
    /// As [`RenderSteps::update`].
    pub fn face_count(&mut self, stack: &Stack) -> Result<usize, Error> {
        let stages = self.stages_of(stack)?;
        let mut start = self.start.clone();
        let (last, before) = stages.split_last().expect("a stack has a stage");
        for (steps, stage) in self.stages.iter_mut().zip(before) {
            start = steps.update(&start, stage)?.end;
        }
        self.stages[before.len()].face_count(&start, last)
    }

    /// The origins of the garment's own vertices.
    ///
    /// # Errors
    /// A mesh whose refinement would be too large.
    pub fn cage_origins(&mut self) -> Result<Origins, Error> {
        self.stages[0].cage_origins(&self.start)
    }

    /// The origins of the vertices of the last [`RenderSteps::update`], which had the same stack.
    ///
    /// # Errors
    /// As [`RenderSteps::update`].
    pub fn origins(&mut self, stack: &Stack) -> Result<Origins, Error> {
        let mut trace = OriginTrace::first(&self.start.garment);
        let mut start = self.start.clone();
        let stages = self.stages_of(stack)?;
        for (number, (steps, stage)) in self.stages.iter_mut().zip(&stages).enumerate() {
            trace = steps.origins(&start, stage, trace, number + 1 == stages.len())?;
            start = steps.update(&start, stage)?.end;
        }
        Ok(trace.origins(&start.sources))
    }

    /// An estimate of the memory of all cached steps. \[bytes\]
    pub fn bytes(&self) -> usize {
        self.stages.iter().map(StageSteps::bytes).sum()
    }
}

/// The refinements before the second of two stages. \[levels\]
fn seam_level(stages: &[Stage]) -> u32 {
    if let [before, _] = stages { before.level } else { 0 }
}

/// A garment as a product: directions have unit length, and joint influences are back in their primvars.
fn finished(mut garment: Mesh) -> Mesh {
    Arc::make_mut(&mut garment.primvars).iter_mut().for_each(to_unit_length);
    garment.pack_influences();
    garment
}
