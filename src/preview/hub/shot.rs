//! Plays a cache on the newest meshes.

use super::workers::{Known, Simulated, builder_for};
use super::{Hub, Job, Shown};
use crate::messages::{Role, ServerMessage, ShotMessage};
use glam::Vec3;
use rayon::ThreadPool;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use tailor::render::Origins;
use tailor_costume::drive::{BindPose, Driver};
use tailor_costume::pipeline::{Progress, bound as bound_to};
use tailor_mesh::connectivity::{IdVec, VertexId};
use tailor_mesh::error::Error;
use tailor_mesh::garment::Mesh;
use tailor_usd::{CacheFile, Playback};

/// The cache that is played.
pub struct Shot {
    file: CacheFile,
    /// The frame that a page asked for last; none at bind.
    pub wanted: Option<usize>,
    /// The newest render mesh.
    pub rendered: Option<Rendered>,
}

impl Shot {
    pub fn new(file: CacheFile) -> Self {
        Self { file, wanted: None, rendered: None }
    }
}

/// A render mesh, with what binds it to a simulation mesh.
#[derive(Clone)]
pub struct Rendered {
    pub job: Job,
    pub mesh: Arc<Mesh>,
    pub origins: Arc<Origins>,
}

/// A frame to show on two meshes of one recipe.
struct Pose {
    file: CacheFile,
    simulated: Simulated,
    rendered: Rendered,
    frame: Option<usize>,
}

/// The revision of the meshes and the frame.
type PoseKey = (u64, Option<usize>);

impl Pose {
    fn key(&self) -> PoseKey {
        (self.rendered.job.revision, self.frame)
    }
}

/// Two meshes that are bound, and the cache that moves them.
struct Bound {
    sim: Arc<Mesh>,
    render: Arc<Mesh>,
    driver: Driver,
    playback: Playback,
}

impl Hub {
    /// Shows a frame of the cache, or the meshes at bind.
    pub fn pose(&self, frame: Option<usize>) {
        self.change(|shared| {
            if let Some(shot) = &mut shared.shot {
                shot.wanted = frame;
            }
        });
    }

    /// Waits for meshes or a frame other than those of `done`. Both meshes are of one recipe then.
    fn next_pose(&self, done: Option<PoseKey>) -> Pose {
        self.wait_for(|shared| {
            let pose = shared.shot.as_ref().zip(shared.simulated.as_ref()).and_then(|(shot, simulated)| {
                let rendered = shot.rendered.clone().filter(|made| made.job.revision == simulated.job.revision)?;
                Some(Pose { file: shot.file.clone(), simulated: simulated.clone(), rendered, frame: shot.wanted })
            });
            pose.filter(|pose| Some(pose.key()) != done)
        })
    }

    /// Plays for ever.
    pub fn play(self: &Arc<Self>, pool: &ThreadPool) {
        let (mut done, mut known, mut bound) = (None, None, None);
        loop {
            let pose = self.next_pose(done);
            done = Some(pose.key());
            let posed = catch_unwind(AssertUnwindSafe(|| self.posed(&pose, &mut known, &mut bound, pool)));
            let posed = posed.unwrap_or_else(|_| Err(Error::internal("the cache could not be played")));
            let (message, posed) = posed.unwrap_or_else(|error| {
                (known, bound) = (None, None);
                (ShotMessage { fault: error.faults.into_iter().next(), ..ShotMessage::default() }, BTreeMap::new())
            });
            self.change(|shared| {
                shared.snapshot.posed = posed;
                shared.tell("shot", &ServerMessage::Shot(&message));
            });
        }
    }

    /// The meshes of a pose, and the message about it.
    fn posed(
        &self,
        pose: &Pose,
        known: &mut Known,
        bound: &mut Option<Bound>,
        pool: &ThreadPool,
    ) -> Result<(ShotMessage, BTreeMap<Role, Arc<Shown>>), Error> {
        let is_of = |bound: &Bound| {
            Arc::ptr_eq(&bound.sim, &pose.simulated.update.mesh) && Arc::ptr_eq(&bound.render, &pose.rendered.mesh)
        };
        let bound = match bound.take().filter(is_of) {
            Some(kept) => bound.insert(kept),
            None => bound.insert(Bound::new(pose, known, pool)?),
        };
        let times = bound.playback.times();
        let frame = pose.frame.map(|frame| frame.min(times.len() - 1));
        let message = ShotMessage {
            file: pose.file.file.display().to_string(),
            frames: times.len(),
            rate: bound.playback.rate(),
            frame,
            time: frame.map(|frame| times[frame]),
            fault: None,
        };
        let Some(frame) = frame else { return Ok((message, BTreeMap::new())) };
        let sim = bound.playback.points(frame)?;
        let render = pool.install(|| bound.driver.points(&sim));
        let shown = self.snapshot().shown;
        let moved = [(Role::Sim, &bound.sim, sim), (Role::Render, &bound.render, render)];
        let moved = moved.into_iter().filter_map(|(role, mesh, points)| {
            // A newer mesh stays at bind until it is bound itself.
            let at_bind = shown.get(&role).filter(|shown| Arc::ptr_eq(&shown.mesh, mesh))?;
            Some((role, Arc::new(at_bind.moved(points))))
        });
        Ok((message, moved.collect()))
    }
}

impl Bound {
    fn new(pose: &Pose, known: &mut Known, pool: &ThreadPool) -> Result<Self, Error> {
        let (sim, render) = (&pose.simulated.update.mesh, &pose.rendered.mesh);
        let source = &pose.rendered.job.stage.source;
        let below = source.prim().rsplit_once('/').map_or("", |(parent, _)| parent);
        // The cache is checked first: it is what a user may have to change.
        let playback = Playback::open(&pose.file, &format!("{below}/sim"), sim, source)?;
        let builder = builder_for(known, &pose.rendered.job.stage, Progress::default);
        let local = builder.meshes().frame().enter(render);
        let binding = pool.install(|| bound_to(&pose.simulated.update.simulated, &local, &pose.rendered.origins));
        let triangles: Vec<[u32; 3]> = sim.faces.fans().map(|triangle| triangle.map(|v| v.index() as u32)).collect();
        let (sim_points, points) = (sim.points.as_slice(), render.points.as_slice());
        let (triangles, faces, coords) = (&triangles[..], &binding.faces[..], &binding.coords[..]);
        let bind = BindPose { sim_points, triangles, points, faces, coords };
        let driver = pool.install(|| Driver::new(&bind))?;
        Ok(Self { sim: Arc::clone(sim), render: Arc::clone(render), driver, playback })
    }
}

impl Shown {
    /// The mesh with other points.
    pub fn moved(&self, points: Vec<Vec3>) -> Self {
        let points: IdVec<VertexId, Vec3> = points.into();
        Self { mesh: Arc::new(Mesh { points, ..Mesh::clone(&self.mesh) }), ..self.clone() }
    }
}
