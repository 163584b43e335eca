//! The stages of a render mesh in their order. Who runs them decides whether results are kept.
//!
//! An operator and a refinement are two stages each: what the mesh is made of, and where its points are. A stage is known
//! by its name and by what it depends on beside the garment: the connectivity on `structure`, the points on `options`.
//!
//! ```text
//! cage → gaps ┬→ form → form → … → level → attributes    what the mesh is made of
//!             └─→ ground, points → ground, points → … → level points
//! ```
//!
//! The second chain waits for each form and each level of the first, which goes on meanwhile: in both there is work that
//! one thread does.

use super::front::Front;
use super::placed::{Placed, Room};
use super::placing::Placing;
use super::shape::{Formed, Origin};
use super::{Stack, check_size, first_cage};
use crate::error::{Error, Warnings};
use crate::garment::Garment;
use crate::memo::{Footprint, Made};
use crate::mesh::{IdVec, VertexId};
use crate::subdivide::Cage;
use glam::Vec3;
use serde::Serialize;
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread;

/// Where results of stages come from.
pub trait Stages: Sync {
    /// The result of a stage, which depends on the garment and on `options` alone.
    ///
    /// # Errors
    /// What `make` reports.
    fn get<V: Footprint + Send + Sync + 'static>(
        &self,
        name: &'static str,
        options: &impl Serialize,
        make: impl FnOnce() -> Result<V, Error> + Send,
    ) -> Result<Arc<V>, Error>;

    /// Makes what is never kept.
    fn make<V: Send>(&self, make: impl FnOnce() -> V + Send) -> V;
}

/// Every stage is made, and none is kept.
pub struct Afresh;

impl Stages for Afresh {
    fn get<V: Footprint + Send + Sync + 'static>(
        &self,
        _: &'static str,
        _: &impl Serialize,
        make: impl FnOnce() -> Result<V, Error> + Send,
    ) -> Result<Arc<V>, Error> {
        self.make(make).map(Arc::new)
    }

    fn make<V: Send>(&self, make: impl FnOnce() -> V + Send) -> V {
        // Within the pool, where a loop need not be handed over to it.
        rayon::scope(|_| make())
    }
}

/// A render mesh.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// The mesh.
    pub mesh: Garment,
    /// Names of the face sets that operators made.
    pub sets: Vec<String>,
    /// What was met on the way.
    pub warnings: Warnings,
}

/// The render mesh of a checked garment.
///
/// A polygonal mesh (`subdivisionScheme = "none"`) is refined as if bilinear and stays polygonal.
///
/// # Errors
/// Operators that do not fit the garment; a mesh that would be too large.
pub fn render(garment: &Garment, stack: &Stack, stages: &impl Stages) -> Result<Rendered, Error> {
    if stack.level == 0 && stack.operators.is_empty() {
        return Ok(Rendered { mesh: garment.clone(), sets: Vec::new(), warnings: stack.warnings.clone() });
    }
    let cage: Arc<Cage> = stages.get("cage", &(), || Ok(first_cage(garment)))?;
    // All heights depend on how far gaps were looked for.
    let reach = stack.reach(garment);
    let first = stages.get("first", &reach, || Ok(Made::from(Placed::first(&cage, reach))))?;
    let plan = Plan::new(stack, reach, stages);
    let ((formed, next_formed), (cages, next_cage)) = (mpsc::channel(), mpsc::channel());
    let clearance = Arc::new(first.value.rooms.clone());
    let frame = || plan.frame(cage, clearance, &Sent { formed, cages });
    let (frame, points) = at_once(frame, || plan.points(first, &next_formed, &next_cage));
    let (frame, points) = (frame?, points?);
    let mut warnings = stack.warnings.clone();
    for (formed, placed) in frame.formed.iter().zip(&points.placed) {
        warnings.extend(&formed.shape.warnings);
        warnings.extend(&placed.warnings);
    }
    let subsets = frame.formed.iter().flat_map(|formed| &formed.shape.subsets);
    let sets = subsets.map(|set| set.name.clone()).collect();
    // Attributes are shared with those of other points.
    let mesh = Garment { points: points.last, ..Garment::clone(&frame.mesh) };
    Ok(Rendered { mesh, sets, warnings })
}

/// Runs two chains of stages at the same time, of which the second may wait for what the first sends.
fn at_once<A: Send, B>(first: impl FnOnce() -> A + Send, second: impl FnOnce() -> B) -> (A, B) {
    // A thread of a pool may not wait: what it waits for may be left to that thread.
    if rayon::current_thread_index().is_some() || rayon::current_num_threads() == 1 {
        return (first(), second());
    }
    thread::scope(|scope| {
        let first = scope.spawn(first);
        let second = second();
        (first.join().unwrap_or_else(|panic| resume_unwind(panic)), second)
    })
}

/// What makes the mesh, and by which names.
struct Plan<'a, S> {
    stack: &'a Stack,
    stages: &'a S,
    /// What the connectivity after each operator depends on, one after the other.
    structure: Vec<String>,
    /// What the points depend on, from before the first operator on.
    options: Vec<String>,
}

/// To where the points are made.
struct Sent {
    formed: Sender<Arc<Formed>>,
    /// Cages to refine.
    cages: Sender<Base>,
}

/// All of a mesh but its points.
struct Frame {
    formed: Vec<Arc<Formed>>,
    mesh: Arc<Garment>,
}

/// The points of a mesh.
struct Points {
    /// After each operator.
    placed: Vec<Arc<Made<Placed>>>,
    last: IdVec<VertexId, Vec3>,
}

/// A cage, as a stage has it.
#[derive(Clone)]
enum Base {
    Plain(Arc<Cage>),
    Formed(Arc<Formed>),
}

impl Base {
    fn cage(&self) -> &Cage {
        match self {
            Self::Plain(cage) => cage,
            Self::Formed(formed) => &formed.cage,
        }
    }
}

impl<'a, S: Stages> Plan<'a, S> {
    fn new(stack: &'a Stack, reach: f32, stages: &'a S) -> Self {
        let structure = stack.operators.iter().map(|operator| operator.structure()).collect();
        let all = stack.operators.iter().map(|operator| operator.options());
        Self { stack, stages, structure, options: std::iter::once(reach.to_string()).chain(all).collect() }
    }

    /// The connectivity and the attributes.
    fn frame(&self, first: Arc<Cage>, clearance: Arc<IdVec<VertexId, Room>>, sent: &Sent) -> Result<Frame, Error> {
        let mut formed: Vec<Arc<Formed>> = Vec::with_capacity(self.structure.len());
        let faces = Arc::new(first.garment().faces.ids().collect());
        let mut cage = Base::Plain(Arc::clone(&first));
        let front = || Ok(if self.structure.is_empty() { Front::default() } else { Front::first(cage.cage()) });
        let front = self.stages.get("front", &self.structure.is_empty(), front)?;
        let mut origin = Origin { clearance, front, cage: first, faces };
        for (number, operator) in self.stack.operators.iter().enumerate() {
            // The same for every reach, as operators ask for no clearance beyond their own.
            let form = || Formed::new(operator.as_ref(), cage.cage(), &origin);
            let stage = self.stages.get("form", &&self.structure[..=number], form)?;
            origin = stage.origin.clone();
            cage = Base::Formed(Arc::clone(&stage));
            // Nobody waits for it where the points have failed.
            drop(sent.formed.send(Arc::clone(&stage)));
            formed.push(stage);
        }
        let level = self.stack.level;
        check_size(cage.cage().garment(), level)?;
        drop(sent.cages.send(cage.clone()));
        for step in 1..level {
            cage = Base::Plain(self.stages.get("level", &(&self.structure, step), || Ok(cage.cage().refined()))?);
            drop(sent.cages.send(cage.clone()));
        }
        let mesh = self.stages.get("attributes", &(&self.structure, level), || {
            Ok(if level == 0 { cage.cage().clone().into_garment() } else { cage.cage().refined_garment() })
        })?;
        Ok(Frame { formed, mesh })
    }

    /// The points, in what is sent from the other chain.
    fn points(
        &self,
        first: Arc<Made<Placed>>,
        formed: &Receiver<Arc<Formed>>,
        cages: &Receiver<Base>,
    ) -> Result<Points, Error> {
        let (mut last, mut placed) = (first, Vec::with_capacity(self.structure.len()));
        for (number, operator) in self.stack.operators.iter().enumerate() {
            let formed = received(formed)?;
            let structure = &self.structure[..=number];
            let placing = self.stages.get("placing", &structure, || Ok(Placing::new(formed)))?;
            let (before, options) = (&self.options[..=number], &self.options[..=number + 1]);
            let ground = || Ok(placing.ground(&last.value));
            let ground = self.stages.get("ground", &(structure, before), ground)?;
            let is_last = number + 1 == self.structure.len();
            last = self.stages.get("points", &(options, is_last), || {
                let (value, warnings) = placing.raised(operator.as_ref(), &ground, is_last);
                Ok(Made { value, warnings })
            })?;
            placed.push(Arc::clone(&last));
        }
        Ok(Points { last: self.refined_points(&last.value.points, cages)?, placed })
    }

    /// The points after the refinements. Those of the last one go into the mesh and are not kept by themselves.
    fn refined_points(
        &self,
        points: &IdVec<VertexId, Vec3>,
        cages: &Receiver<Base>,
    ) -> Result<IdVec<VertexId, Vec3>, Error> {
        let mut kept: Option<Arc<IdVec<VertexId, Vec3>>> = None;
        for step in 1..self.stack.level {
            let cage = received(cages)?;
            let refined = || Ok(cage.cage().refined_points(kept.as_deref().unwrap_or(points)));
            kept = Some(self.stages.get("level points", &(&self.options, step), refined)?);
        }
        let points = kept.as_deref().unwrap_or(points);
        if self.stack.level == 0 {
            return Ok(points.clone());
        }
        let cage = received(cages)?;
        Ok(self.stages.make(|| cage.cage().refined_points(points)))
    }
}

/// What the other chain sends; where it has failed, its own fault is told.
fn received<T>(from: &Receiver<T>) -> Result<T, Error> {
    from.recv().map_err(|_| Error::Internal("a stage before the points was not made".to_owned()))
}
