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
//! The second chain follows the first with each shape and each level, which goes on meanwhile: in both there is work that
//! one thread does.
//!
//! The connectivity of each cage with its masks, and of each refinement with its subsets, is a stage by what it is made of
//! and not by the options that led there: mostly, other widths of a seam change no face.

use super::front::Front;
use super::placed::{Placed, Room};
use super::placing::Placing;
use super::shape::{Formed, Origin, Shaped};
use super::{Stack, check_size, first_cage};
use crate::error::{Error, Warnings};
use crate::garment::Garment;
use crate::memo::{Footprint, Made};
use crate::mesh::{Faces, IdVec, VertexId};
use crate::parallel::Follower;
use crate::subdivide::{Cage, Channels, Connectivity, Fingerprint, Level, carried_points};
use glam::Vec3;
use serde::Serialize;
use std::sync::Arc;

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

    /// Makes what is never kept, within the pool.
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
    // A loop within the pool need not be handed over to it.
    stages.make(|| Plan::new(garment, stack, stages).rendered(garment))
}

/// What makes the mesh, and by which names.
struct Plan<'a, S> {
    stack: &'a Stack,
    stages: &'a S,
    /// What the connectivity after each operator depends on, one after the other.
    structure: Vec<String>,
    /// How far gaps are looked for. \[stage units\]
    reach: f32,
    /// What the points depend on, from before the first operator on.
    options: Vec<String>,
}

/// What the points are made of, as soon as it is there.
enum Step {
    /// The cage before the operators.
    Cage(Base),
    /// What an operator makes of it.
    Shape(Arc<Shaped>, Base),
    /// A level to refine.
    Level(Arc<Level>),
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

/// The points, as far as they are made.
struct Points<'a, S> {
    plan: &'a Plan<'a, S>,
    /// That of the last cage.
    connectivity: Option<Arc<Connectivity>>,
    last: Arc<Made<Placed>>,
    /// After each operator.
    placed: Vec<Arc<Made<Placed>>>,
    /// Refinements that were made.
    step: u32,
    refined: Option<Arc<IdVec<VertexId, Vec3>>>,
    /// Those of the mesh, if it is refined.
    of_mesh: Option<IdVec<VertexId, Vec3>>,
}

impl<'a, S: Stages> Plan<'a, S> {
    fn new(garment: &Garment, stack: &'a Stack, stages: &'a S) -> Self {
        let structure = stack.operators.iter().map(|operator| operator.structure()).collect();
        // All heights depend on how far gaps were looked for.
        let reach = stack.reach(garment);
        let all = stack.operators.iter().map(|operator| operator.options());
        let options = std::iter::once(reach.to_string()).chain(all).collect();
        Self { stack, stages, structure, reach, options }
    }

    fn rendered(&self, garment: &Garment) -> Result<Rendered, Error> {
        let cage: Arc<Cage> = self.stages.get("cage", &(), || Ok(first_cage(garment)))?;
        let first = || Ok(Made::from(Placed::first(&cage, self.reach)));
        let first = self.stages.get("first", &self.reach, first)?;
        let clearance = Arc::new(first.value.rooms.clone());
        let (mut points, mut followed) = (Points::new(self, first), Ok(()));
        let follower = Follower::new(|step| {
            if followed.is_ok() {
                followed = points.follow(step);
            }
        });
        let frame = rayon::scope(|scope| self.frame(cage, clearance, &|step| follower.send(scope, step)))?;
        drop(follower);
        followed?;
        let mut warnings = self.stack.warnings.clone();
        for (shaped, placed) in frame.shaped.iter().zip(&points.placed) {
            warnings.extend(&shaped.shape.warnings);
            warnings.extend(&placed.warnings);
        }
        let subsets = frame.shaped.iter().flat_map(|shaped| &shaped.shape.subsets);
        let sets = subsets.map(|set| set.name.clone()).collect();
        // Attributes are shared with those of other points.
        let mesh = Garment { points: points.into_mesh(), ..Garment::clone(&frame.mesh) };
        Ok(Rendered { mesh, sets, warnings })
    }

    /// The connectivity and the attributes.
    fn frame(
        &self,
        first: Arc<Cage>,
        clearance: Arc<IdVec<VertexId, Room>>,
        send: &impl Fn(Step),
    ) -> Result<Frame, Error> {
        let mut base = Base::first(&first);
        let mut shaped: Vec<Arc<Shaped>> = Vec::with_capacity(self.structure.len());
        let mut cage = Arc::clone(&first);
        if !self.structure.is_empty() {
            send(Step::Cage(base.clone()));
            let front = self.stages.get("front", &(), || Ok(Front::first(&first)))?;
            let faces = Arc::new(first.garment().faces.ids().collect());
            let mut origin = Origin { clearance, front, cage: first, faces };
            for (number, operator) in self.stack.operators.iter().enumerate() {
                let structure = &&self.structure[..=number];
                // The same for every reach, as operators ask for no clearance beyond their own.
                let stage = self.stages.get("shape", structure, || Shaped::new(operator.as_ref(), &cage, &origin))?;
                base = self.base(&stage)?;
                send(Step::Shape(Arc::clone(&stage), base.clone()));
                let level = Arc::clone(&base.level);
                let form = || Ok(cage.derived(&stage.shape.derivation, stage.frame.clone(), level));
                cage = self.stages.get("form", structure, form)?;
                origin = stage.origin.clone();
                shaped.push(stage);
            }
        }
        check_size(cage.garment(), self.stack.level)?;
        Ok(Frame { shaped, mesh: self.refined(cage, base.fingerprint, send)? })
    }

    fn base(&self, Shaped { frame, fingerprint, .. }: &Shaped) -> Result<Base, Error> {
        let level = self.stages.get("base level", fingerprint, || Ok(Level::base(frame)))?;
        Ok(Base { level, fingerprint: *fingerprint })
    }

    fn connectivity(&self, base: Base) -> Result<Arc<Connectivity>, Error> {
        self.stages.get("connectivity", &base.fingerprint, || Ok(Connectivity::new(base.level)))
    }

    /// The last cage, whose level has this fingerprint, after the refinements.
    fn refined(
        &self,
        mut cage: Arc<Cage>,
        fingerprint: Fingerprint,
        send: &impl Fn(Step),
    ) -> Result<Arc<Garment>, Error> {
        let last = self.stack.level;
        let key = (&self.structure, last);
        if last == 0 {
            return self.stages.get("attributes", &key, || Ok(Cage::clone(&cage).into_garment()));
        }
        send(Step::Level(cage.shared_level()));
        let (sharing, sets) = (Channels::fingerprint(cage.garment()), cage.subsets_fingerprint());
        let (channels_of, subsets_of) =
            (|step: u32| (fingerprint, sharing, step), |step: u32| (fingerprint, sets, step));
        let mut channels = self.stages.get("channels", &channels_of(0), || Ok(Channels::new(&cage)))?;
        for step in 1..last {
            let level = self.stages.get("refined level", &(fingerprint, step), || Ok(cage.level().refined()))?;
            send(Step::Level(Arc::clone(&level)));
            let refinement = cage.refinement(level.topology.faces.clone(), &channels);
            let subsets = self.stages.get("subsets", &subsets_of(step), || Ok(refinement.subsets()))?;
            let refined = || Ok(refinement.cage(Arc::clone(&level), Arc::clone(&subsets)));
            let refined = self.stages.get("level", &(&self.structure, step), refined)?;
            let next = || Ok(channels.refined(cage.level(), &level));
            channels = self.stages.get("channels", &channels_of(step), next)?;
            cage = refined;
        }
        let faces = || Ok(cage.level().refined_faces());
        let faces: Arc<Faces> = self.stages.get("refined faces", &(fingerprint, last), faces)?;
        let refinement = cage.refinement(Faces::clone(&faces), &channels);
        let subsets = self.stages.get("subsets", &subsets_of(last), || Ok(refinement.subsets()))?;
        self.stages.get("attributes", &key, || Ok(refinement.garment(Arc::clone(&subsets))))
    }
}

impl<'a, S: Stages> Points<'a, S> {
    fn new(plan: &'a Plan<'a, S>, first: Arc<Made<Placed>>) -> Self {
        Self { plan, connectivity: None, last: first, placed: Vec::new(), step: 0, refined: None, of_mesh: None }
    }

    fn follow(&mut self, step: Step) -> Result<(), Error> {
        match step {
            Step::Cage(base) => self.connectivity = Some(self.plan.connectivity(base)?),
            Step::Shape(shaped, base) => self.raise(shaped, base)?,
            Step::Level(level) => self.refine(&level)?,
        }
        Ok(())
    }

    /// The points of the next cage.
    fn raise(&mut self, shaped: Arc<Shaped>, base: Base) -> Result<(), Error> {
        let Plan { stack, stages, structure, options, .. } = self.plan;
        let child = self.plan.connectivity(base)?;
        let parent = self.connectivity.replace(Arc::clone(&child));
        let parent = parent.ok_or_else(|| Error::Internal("a shape came before its cage".to_owned()))?;
        let formed = Formed { shaped, child, parent };
        let number = self.placed.len();
        let structure = &structure[..=number];
        let placing = stages.get("placing", &structure, || Ok(Placing::new(formed)))?;
        let (before, options) = (&options[..=number], &options[..=number + 1]);
        let ground = stages.get("ground", &(structure, before), || Ok(placing.ground(&self.last.value)))?;
        let is_last = number + 1 == stack.operators.len();
        self.last = stages.get("points", &(options, is_last), || {
            let (value, warnings) = placing.raised(stack.operators[number].as_ref(), &ground, is_last);
            Ok(Made { value, warnings })
        })?;
        self.placed.push(Arc::clone(&self.last));
        Ok(())
    }

    /// The points after a refinement. Those of the last one go into the mesh and are not kept by themselves.
    fn refine(&mut self, level: &Level) -> Result<(), Error> {
        let Plan { stack, stages, options, .. } = self.plan;
        self.step += 1;
        let points = self.refined.as_deref().unwrap_or(&self.last.value.points);
        // Masks that are known need not be computed again.
        let known = self.connectivity.as_deref().filter(|_| self.step == 1);
        let rows = known.map_or_else(|| level.vertex_rows(), Connectivity::vertex_rows);
        if self.step == stack.level {
            self.of_mesh = Some(stages.make(|| carried_points(&rows, points)));
        } else {
            let refined = || Ok(carried_points(&rows, points));
            self.refined = Some(stages.get("level points", &(options, self.step), refined)?);
        }
        Ok(())
    }

    fn into_mesh(self) -> IdVec<VertexId, Vec3> {
        self.of_mesh.unwrap_or_else(|| self.last.value.points.clone())
    }
}
