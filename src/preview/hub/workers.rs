//! The threads that build: one for each product, and one for the cloth of the newest simulation mesh.

use super::shot::{Rendered, Shot};
use super::{Hub, Job, Shown};
use crate::messages::{ClothMessage, Figures, Origin, ProductMessage, Role, ServerMessage, lengths};
use crate::stage::Stage;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::thread;
use std::time::Instant;
use tailor::report::RenderFigures;
use tailor_costume::pipeline::{Builder, Progress, SimUpdate};
use tailor_costume::recipe::Recipe;
use tailor_mesh::connectivity::{FaceId, IdVec};
use tailor_mesh::error::{Error, ErrorKind, Warnings};
use tailor_mesh::garment::Mesh;
use tailor_usd::{CacheFile, STACK};

/// The simulation mesh of a job, from which its cloth is made.
#[derive(Clone)]
pub struct Simulated {
    pub job: Job,
    pub update: SimUpdate,
}

/// The stage that a thread last worked on, with its builder.
pub type Known = Option<(Arc<Stage>, Builder)>;

/// The resolved recipes of the first level of detail and of the one that is shown.
type LevelRecipes = [Recipe; 2];

impl Job {
    /// The recipe of the level that is shown, of the resolved recipe of the first one.
    fn of_level(&self, recipe: &Recipe, builder: &Builder) -> Recipe {
        match self.level {
            0 => recipe.clone(),
            level => recipe.at_level(level, builder.mean_edge_length()),
        }
    }
}

impl Hub {
    /// Starts the threads that build, each with `threads` threads of its own so that none waits for another.
    ///
    /// # Errors
    /// Threads that cannot be started.
    pub fn start(self: &Arc<Self>, threads: Option<usize>) -> Result<(), Error> {
        self.spawn("render", threads, |hub, pool| hub.work(Role::Render, pool))?;
        self.spawn("sim", threads, |hub, pool| hub.work(Role::Sim, pool))?;
        self.spawn("fit", threads, |hub, pool| hub.work_on_fit(pool))?;
        self.spawn("cloth", threads, |hub, pool| hub.work_on_cloth(pool))
    }

    /// Starts the thread that plays a cache. It comes before the others, which make more where there is one.
    ///
    /// # Errors
    /// A thread that cannot be started.
    pub fn start_shot(self: &Arc<Self>, file: CacheFile, threads: Option<usize>) -> Result<(), Error> {
        self.change(|shared| shared.shot = Some(Shot::new(file)));
        self.spawn("shot", threads, |hub, pool| hub.play(pool))
    }

    fn spawn(
        self: &Arc<Self>,
        name: &str,
        threads: Option<usize>,
        work: impl FnOnce(&Arc<Self>, &ThreadPool) + Send + 'static,
    ) -> Result<(), Error> {
        let fault = |e: &dyn std::fmt::Display| Error::internal(format!("cannot start threads: {e}"));
        let pool = ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build().map_err(|e| fault(&e))?;
        let hub = Arc::clone(self);
        let spawned = thread::Builder::new().name(name.to_owned()).stack_size(STACK).spawn(move || work(&hub, &pool));
        spawned.map(drop).map_err(|e| fault(&e))
    }

    /// Waits for a job after the revision `done`.
    fn next_job(&self, done: u64) -> Job {
        self.wait_for(|shared| shared.job.clone().filter(|job| job.revision > done))
    }

    /// Builds one product for ever.
    fn work(self: &Arc<Self>, role: Role, pool: &ThreadPool) {
        let (mut done, mut known) = (0, None);
        loop {
            let job = self.next_job(done);
            done = job.revision;
            let result = guarded(pool, || self.build(role, &job, &mut known));
            known.take_if(|_| is_panic(&result));
            let origin = if role == Role::Sim { Origin::Sim } else { Origin::Render };
            self.change(|shared| {
                shared.show_step(role, None);
                shared.set_faults(origin, result.err().map_or(Vec::new(), |error| error.faults));
            });
        }
    }

    fn build(self: &Arc<Self>, role: Role, job: &Job, known: &mut Known) -> Result<(), Error> {
        let start = Instant::now();
        let builder = builder_for(known, &job.stage, || self.progress(role));
        let first = builder.resolve(&job.recipe)?;
        // A cache is one of the first level, and moves the render mesh of any.
        let is_first = role == Role::Sim && self.lock().shot.is_some();
        let shown = if is_first { first.clone() } else { job.of_level(&first, builder) };
        match role {
            Role::Sim => self.build_sim(job, builder, &[first, shown], start),
            _ => self.build_render(job, builder, [first, shown], start),
        }
    }

    fn build_sim(&self, job: &Job, builder: &mut Builder, recipes: &LevelRecipes, start: Instant) -> Result<(), Error> {
        let [first, shown] = recipes;
        let update = builder.update_sim(shown)?;
        let shown = self.show(Role::Sim, job, &update.mesh, || Arc::new(update.sources()), start);
        if shown.message.get().is_none() {
            let _ = shown.quality.set(Arc::new(update.triangle_quality()));
            let figures = Figures::from(&update.figures());
            let _ = shown.message.set(product(job, figures, None, &update.warnings, &[], first));
        }
        let simulated = Simulated { job: job.clone(), update };
        self.change(|shared| shared.simulated = Some(simulated));
        Ok(())
    }

    fn build_render(&self, job: &Job, builder: &mut Builder, of: LevelRecipes, start: Instant) -> Result<(), Error> {
        let [mut recipe, shown] = of;
        let update = builder.update_render(&shown)?;
        let level = shown.render.level;
        let drawn = self.show(Role::Render, job, &update.mesh, || update.sources, start);
        let plays = self.lock().shot.is_some();
        let origins = plays.then(|| builder.meshes().origins(&shown.meshes())).transpose()?;
        if drawn.message.get().is_none() {
            let figures = Figures::from(&RenderFigures::new(&update.mesh));
            recipe.render.seam_level = update.seam_level;
            let message = product(job, figures, Some(level), &update.warnings, &update.operators, &recipe);
            let _ = drawn.message.set(message);
        }
        let Some(origins) = origins.map(Arc::new) else { return Ok(()) };
        let rendered = Rendered { job: job.clone(), mesh: Arc::clone(&drawn.mesh), origins };
        self.change(|shared| {
            if let Some(shot) = &mut shared.shot {
                shot.rendered = Some(rendered);
            }
        });
        Ok(())
    }

    /// The handle that shows the steps of a product's build.
    fn progress(self: &Arc<Self>, role: Role) -> Progress {
        let hub = Arc::clone(self);
        Progress::new(move |step| {
            hub.change(|shared| shared.show_step(role, Some(step)));
        })
    }

    /// Waits for a simulation mesh after that of the revision `done`.
    fn next_simulated(&self, done: u64) -> Simulated {
        self.wait_for(|shared| shared.simulated.clone().filter(|simulated| simulated.job.revision > done))
    }

    /// Makes the cloth of the newest simulation mesh for ever.
    fn work_on_cloth(self: &Arc<Self>, pool: &ThreadPool) {
        let (mut done, mut known) = (0, None);
        loop {
            let simulated = self.next_simulated(done);
            done = simulated.job.revision;
            let result = guarded(pool, || cloth(&simulated, &mut known));
            known.take_if(|_| is_panic(&result));
            self.change(|shared| {
                let message = result.map(|message| shared.snapshot.messages.insert("cloth".into(), message));
                shared.set_faults(Origin::Cloth, message.err().map_or(Vec::new(), |error| error.faults));
            });
        }
    }

    /// Shows a mesh, unless it is shown already. The thread of its role alone calls this.
    fn show(
        &self,
        role: Role,
        job: &Job,
        mesh: &Arc<Mesh>,
        sources: impl FnOnce() -> Arc<IdVec<FaceId, FaceId>>,
        start: Instant,
    ) -> Arc<Shown> {
        let last = self.lock().snapshot.shown.get(&role).cloned();
        let is_shown =
            |last: &Arc<Shown>| Arc::ptr_eq(&last.mesh, mesh) && is_same_part(role, &last.recipe, &job.recipe);
        if let Some(last) = last.filter(is_shown) {
            return last;
        }
        let shown = Arc::new(Shown {
            mesh: Arc::clone(mesh),
            revision: job.revision,
            build: start.elapsed().as_secs_f64() * 1e3,
            recipe: Arc::clone(&job.recipe),
            sources: sources(),
            ..Shown::default()
        });
        self.change(|shared| {
            shared.snapshot.shown.insert(role, Arc::clone(&shown));
            shared.move_on_way(role);
        });
        shown
    }
}

/// Does work on the threads of a pool. A panic is an error of this program.
pub fn guarded<T: Send>(pool: &ThreadPool, work: impl FnOnce() -> Result<T, Error> + Send) -> Result<T, Error> {
    let result = catch_unwind(AssertUnwindSafe(|| pool.install(work)));
    result.unwrap_or_else(|_| Err(Error::internal("the work ended unexpectedly")))
}

/// True if what was half done has to be forgotten.
fn is_panic<T>(result: &Result<T, Error>) -> bool {
    result.as_ref().is_err_and(|error| error.kind == ErrorKind::Internal)
}

/// The builder for a stage: the known one, or a new one.
pub fn builder_for<'a>(
    known: &'a mut Known,
    stage: &Arc<Stage>,
    progress: impl FnOnce() -> Progress,
) -> &'a mut Builder {
    known.take_if(|(known, _)| !Arc::ptr_eq(known, stage));
    &mut known.get_or_insert_with(|| (Arc::clone(stage), stage.checks.sibling().with_progress(progress()))).1
}

/// The message of the cloth of a simulation mesh.
fn cloth(Simulated { job, update }: &Simulated, known: &mut Known) -> Result<Arc<str>, Error> {
    let builder = builder_for(known, &job.stage, Progress::default);
    let recipe = job.of_level(&builder.resolve(&job.recipe)?, builder);
    let cloth = builder.update_cloth(&recipe, update)?;
    let warnings = cloth.iter().flat_map(|cloth| cloth.warnings.iter()).collect();
    let figures = cloth.as_ref().map(|cloth| &cloth.figures);
    Ok(ServerMessage::Cloth(ClothMessage { figures, warnings }).to_text().into())
}

/// True if recipes agree in all that a product depends on.
fn is_same_part(role: Role, a: &Recipe, b: &Recipe) -> bool {
    match role {
        Role::Sim => a.sim == b.sim,
        _ => Recipe { sim: b.sim.clone(), ..a.clone() } == *b && a.sim.uv_set == b.sim.uv_set,
    }
}

/// Figures and warnings of a product: of the render mesh with its refinements, or of the simulation mesh.
fn product(
    job: &Job,
    figures: Figures,
    level: Option<u32>,
    warnings: &Warnings,
    operators: &[String],
    recipe: &Recipe,
) -> Arc<str> {
    let role = if level.is_some() { Role::Render } else { Role::Sim };
    let mut lengths = lengths(&job.recipe, recipe);
    lengths.retain(|key, _| key.starts_with("sim.") == (role == Role::Sim));
    let warnings = job.stage.checks.face_numbers().warnings_in_mesh(warnings.clone());
    let (revision, warnings) = (job.revision, warnings.iter().collect());
    let message = ProductMessage { role, revision, figures, level, warnings, operators, lengths };
    ServerMessage::Product(message).to_text().into()
}
