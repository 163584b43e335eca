//! The stages of a render mesh in their order. Who runs them decides whether results are kept.
//!
//! An operator and a refinement are two stages each: what the mesh is made of, and where its points are. A stage is known
//! by its name and by what it depends on beside the garment: the connectivity on `structure`, the points on `options`.
//!
//! ```text
//! cage → gaps ┬→ shape, form → shape, form → … → level → attributes    what the mesh is made of
//!             └─→ ground, points → ground, points → … → level points
//! ```
//!
//! The second chain waits for each shape and each level of the first, which goes on meanwhile: in both there is work that
//! one thread does.
//!
//! The connectivity of each cage with its masks, and of each refinement, is a stage by what it is made of and not by the
//! options that led there: mostly, other widths of a seam change no face.

use super::front::Front;
use super::placed::{Placed, Room};
use super::placing::Placing;
use super::shape::{Formed, Origin, Shaped};
use super::{Stack, check_size, first_cage};
use crate::error::{Error, Warnings};
use crate::garment::Garment;
use crate::memo::{Footprint, Made};
use crate::mesh::{Faces, IdVec, VertexId};
use crate::subdivide::{Cage, Channels, Connectivity, Fingerprint, Level, carried_points};
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
    let ((shaped, next_shaped), (levels, next_level)) = (mpsc::channel(), mpsc::channel());
    let (base, clearance) = (Base::first(&cage), Arc::new(first.value.rooms.clone()));
    let frame = || plan.frame(cage, base.clone(), clearance, &Sent { shaped, levels });
    let (frame, points) = at_once(frame, || plan.points(first, base.clone(), &next_shaped, &next_level));
    let (frame, points) = (frame?, points?);
    let mut warnings = stack.warnings.clone();
    for (shaped, placed) in frame.shaped.iter().zip(&points.placed) {
        warnings.extend(&shaped.shape.warnings);
        warnings.extend(&placed.warnings);
    }
    let subsets = frame.shaped.iter().flat_map(|shaped| &shaped.shape.subsets);
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
    shaped: Sender<(Arc<Shaped>, Base)>,
    /// Levels to refine.
    levels: Sender<Arc<Level>>,
}

/// The level of a cage that is not refined.
#[derive(Clone)]
struct Base {
    level: Arc<Level>,
    fingerprint: Fingerprint,
}

impl Base {
    fn first(cage: &Cage) -> Self {
        Self { level: cage.shared_level(), fingerprint: Level::fingerprint(cage.garment()) }
    }
}

/// All of a mesh but its points.
struct Frame {
    shaped: Vec<Arc<Shaped>>,
    mesh: Arc<Garment>,
}

/// The points of a mesh.
struct Points {
    /// After each operator.
    placed: Vec<Arc<Made<Placed>>>,
    last: IdVec<VertexId, Vec3>,
}

impl<'a, S: Stages> Plan<'a, S> {
    fn new(stack: &'a Stack, reach: f32, stages: &'a S) -> Self {
        let structure = stack.operators.iter().map(|operator| operator.structure()).collect();
        let all = stack.operators.iter().map(|operator| operator.options());
        Self { stack, stages, structure, options: std::iter::once(reach.to_string()).chain(all).collect() }
    }

    /// The connectivity and the attributes.
    fn frame(
        &self,
        first: Arc<Cage>,
        mut base: Base,
        clearance: Arc<IdVec<VertexId, Room>>,
        sent: &Sent,
    ) -> Result<Frame, Error> {
        let mut shaped: Vec<Arc<Shaped>> = Vec::with_capacity(self.structure.len());
        let mut cage = Arc::clone(&first);
        if !self.structure.is_empty() {
            let front = self.stages.get("front", &(), || Ok(Front::first(&first)))?;
            let faces = Arc::new(first.garment().faces.ids().collect());
            let mut origin = Origin { clearance, front, cage: first, faces };
            for (number, operator) in self.stack.operators.iter().enumerate() {
                let structure = &&self.structure[..=number];
                // The same for every reach, as operators ask for no clearance beyond their own.
                let stage = self.stages.get("shape", structure, || Shaped::new(operator.as_ref(), &cage, &origin))?;
                base = self.base(&stage)?;
                // Nobody waits for it where the points have failed.
                drop(sent.shaped.send((Arc::clone(&stage), base.clone())));
                let level = Arc::clone(&base.level);
                let form = || Ok(cage.derived(&stage.shape.derivation, stage.frame.clone(), level));
                cage = self.stages.get("form", structure, form)?;
                origin = stage.origin.clone();
                shaped.push(stage);
            }
        }
        check_size(cage.garment(), self.stack.level)?;
        Ok(Frame { shaped, mesh: self.refined(cage, base.fingerprint, sent)? })
    }

    fn base(&self, Shaped { frame, fingerprint, .. }: &Shaped) -> Result<Base, Error> {
        let level = self.stages.get("base level", fingerprint, || Ok(Level::base(frame)))?;
        Ok(Base { level, fingerprint: *fingerprint })
    }

    fn connectivity(&self, base: Base) -> Result<Arc<Connectivity>, Error> {
        self.stages.get("connectivity", &base.fingerprint, || Ok(Connectivity::new(base.level)))
    }

    /// The last cage, whose level has this fingerprint, after the refinements.
    fn refined(&self, mut cage: Arc<Cage>, fingerprint: Fingerprint, sent: &Sent) -> Result<Arc<Garment>, Error> {
        let last = self.stack.level;
        let key = (&self.structure, last);
        if last == 0 {
            return self.stages.get("attributes", &key, || Ok(Cage::clone(&cage).into_garment()));
        }
        drop(sent.levels.send(cage.shared_level()));
        let sharing = Channels::fingerprint(cage.garment());
        let known_by = |step: u32| (fingerprint, sharing, step);
        let mut channels = self.stages.get("channels", &known_by(0), || Ok(Channels::new(&cage)))?;
        for step in 1..last {
            let level = self.stages.get("refined level", &(fingerprint, step), || Ok(cage.level().refined()))?;
            drop(sent.levels.send(Arc::clone(&level)));
            let refined = || Ok(cage.refined(Arc::clone(&level), &channels));
            let refined = self.stages.get("level", &(&self.structure, step), refined)?;
            let next = || Ok(channels.refined(cage.level(), &level));
            channels = self.stages.get("channels", &known_by(step), next)?;
            cage = refined;
        }
        let faces = || Ok(cage.level().refined_faces());
        let faces: Arc<Faces> = self.stages.get("refined faces", &(fingerprint, last), faces)?;
        self.stages.get("attributes", &key, || Ok(cage.refined_garment(Faces::clone(&faces), &channels)))
    }

    /// The points, in what is sent from the other chain.
    fn points(
        &self,
        first: Arc<Made<Placed>>,
        base: Base,
        shaped: &Receiver<(Arc<Shaped>, Base)>,
        levels: &Receiver<Arc<Level>>,
    ) -> Result<Points, Error> {
        let (mut last, mut placed) = (first, Vec::with_capacity(self.structure.len()));
        if self.structure.is_empty() {
            return Ok(Points { last: self.refined_points(&last.value.points, None, levels)?, placed });
        }
        let mut connectivity = self.connectivity(base)?;
        for (number, operator) in self.stack.operators.iter().enumerate() {
            let (shaped, base) = received(shaped)?;
            let parent = std::mem::replace(&mut connectivity, self.connectivity(base)?);
            let formed = Formed { shaped, child: Arc::clone(&connectivity), parent };
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
        Ok(Points { last: self.refined_points(&last.value.points, Some(&connectivity), levels)?, placed })
    }

    /// The points after the refinements, of which the first is that of `connectivity` where there is one. Those of the last
    /// one go into the mesh and are not kept by themselves.
    fn refined_points(
        &self,
        points: &IdVec<VertexId, Vec3>,
        connectivity: Option<&Connectivity>,
        levels: &Receiver<Arc<Level>>,
    ) -> Result<IdVec<VertexId, Vec3>, Error> {
        let refined = |level: &Level, step: u32, points: &IdVec<VertexId, Vec3>| {
            // Masks that are known need not be computed again.
            let known = connectivity.filter(|_| step == 1);
            carried_points(&known.map_or_else(|| level.vertex_rows(), Connectivity::vertex_rows), points)
        };
        let (mut kept, last): (Option<Arc<IdVec<VertexId, Vec3>>>, u32) = (None, self.stack.level);
        for step in 1..last {
            let (level, points) = (received(levels)?, kept.as_deref().unwrap_or(points));
            let stage = self.stages.get("level points", &(&self.options, step), || Ok(refined(&level, step, points)));
            kept = Some(stage?);
        }
        let points = kept.as_deref().unwrap_or(points);
        if last == 0 {
            return Ok(points.clone());
        }
        let level = received(levels)?;
        Ok(self.stages.make(|| refined(&level, last, points)))
    }
}

/// What the other chain sends; where it has failed, its own fault is told.
fn received<T>(from: &Receiver<T>) -> Result<T, Error> {
    from.recv().map_err(|_| Error::Internal("a stage before the points was not made".to_owned()))
}
