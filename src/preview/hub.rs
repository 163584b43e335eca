//! The state that all pages share, and the two threads that build.
//!
//! A change of the document gives a new revision. Each thread builds the newest one and skips those between; the two
//! products do not wait for one another. Results that are the same as before keep their `Arc`, by which pages know that
//! they have them.

pub mod keep;

use super::document::{Before, EditHistory, Options};
use super::messages::{Figures, KeptEdits, Origin, ProductMessage, Role, ServerMessage, StateMessage, lengths};
use super::stage::Stage;
use crate::error::{Error, Fault, Warnings};
use crate::garment::Mesh;
use crate::pipeline::{Builder, Progress};
use crate::recipe::{Layers, Recipe};
use crate::report::{RenderFigures, TriangleQuality};
use crate::session::Input;
use crate::usd::{ReadOptions, Selection};
use keep::{Kept, checksum_of};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread;
use std::time::{Instant, SystemTime, UNIX_EPOCH};
use tokio::sync::watch;

/// A mesh that pages may show.
pub struct Shown {
    /// The mesh.
    pub mesh: Arc<Mesh>,
    /// The first revision that gave it.
    pub revision: u64,
    /// Time to build it. \[milliseconds\]
    pub build: f64,
    /// The recipe that it was built from.
    pub recipe: Arc<Recipe>,
    /// Quality of its triangles, once measured.
    pub quality: OnceLock<Arc<TriangleQuality>>,
    /// Figures and warnings for the page, once measured.
    pub message: OnceLock<Arc<str>>,
}

/// The state at one moment, as a page sees it.
#[derive(Clone)]
pub struct Snapshot {
    /// The garment.
    pub stage: Arc<Stage>,
    /// The document; the page adds its own serial.
    pub state: Arc<State>,
    /// Faults by origin.
    pub faults: Arc<BTreeMap<Origin, Vec<Fault>>>,
    /// Steps that are being worked on.
    pub progress: BTreeMap<Role, String>,
    /// The meshes.
    pub shown: BTreeMap<Role, Arc<Shown>>,
}

/// The document as pages show it.
pub struct State {
    pub revision: u64,
    pub edits: Options,
    /// The edits over the options of the stage.
    layers: Layers,
    can_undo: bool,
    can_redo: bool,
    unsaved: bool,
    comparing: Option<Before>,
    kept: Option<KeptEdits>,
}

impl State {
    fn new(document: &EditHistory, stage: &Stage, kept: Option<&Kept>, revision: u64) -> Self {
        Self {
            revision,
            edits: document.edits().clone(),
            layers: stage.layers(document.edits()),
            can_undo: document.can_undo(),
            can_redo: document.can_redo(),
            unsaved: document.is_unsaved(),
            comparing: document.comparing,
            kept: kept
                .map(|kept| KeptEdits { time: kept.time, is_current: kept.upstream == checksum_of(&stage.upstream) }),
        }
    }

    /// The message for a page whose last edit was `serial`.
    pub fn message(&self, upstream: &Options, serial: u64) -> String {
        ServerMessage::State(StateMessage {
            revision: self.revision,
            serial,
            upstream,
            edits: &self.edits,
            merged: self.layers.map(),
            stack: self.layers.operators(),
            can_undo: self.can_undo,
            can_redo: self.can_redo,
            unsaved: self.unsaved,
            comparing: self.comparing,
            kept: self.kept,
        })
        .to_text()
    }
}

/// A recipe to build.
#[derive(Clone)]
struct Job {
    revision: u64,
    stage: Arc<Stage>,
    recipe: Arc<Recipe>,
}

struct HubState {
    input: Input,
    document: EditHistory,
    /// Edits of earlier servers that the user may have back, oldest first.
    kept: Vec<Kept>,
    snapshot: Snapshot,
    job: Option<Job>,
}

/// The state that all pages share.
pub struct Hub {
    shared: Mutex<HubState>,
    /// Held while the stage is read, so that a slow read does not end after a newer one.
    reading: Mutex<()>,
    work: Condvar,
    changed: watch::Sender<()>,
}

impl Hub {
    /// Shows a garment.
    pub fn new(input: Input, stage: Stage) -> Arc<Self> {
        let document = EditHistory::new(stage.given.clone());
        let snapshot = Snapshot {
            state: Arc::new(State::new(&document, &stage, None, 0)),
            stage: Arc::new(stage),
            faults: Arc::default(),
            progress: BTreeMap::new(),
            shown: BTreeMap::new(),
        };
        let shared = HubState { input, document, kept: Vec::new(), snapshot, job: None };
        let (shared, reading, changed) = (Mutex::new(shared), Mutex::default(), watch::Sender::new(()));
        let hub = Arc::new(Self { shared, reading, work: Condvar::new(), changed });
        hub.change(HubState::show_model);
        hub
    }

    /// Starts the threads that build, each with `threads` threads of its own so that neither waits for the other.
    ///
    /// # Errors
    /// Threads that cannot be started.
    pub fn start(self: &Arc<Self>, threads: Option<usize>) -> Result<(), Error> {
        let fault = |e: &dyn std::fmt::Display| Error::internal(format!("cannot start threads: {e}"));
        for role in [Role::Render, Role::Sim] {
            let pool = ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build().map_err(|e| fault(&e))?;
            let hub = Arc::clone(self);
            let name = format!("{role:?}").to_lowercase();
            thread::Builder::new().name(name).spawn(move || hub.work(role, &pool)).map_err(|e| fault(&e))?;
        }
        Ok(())
    }

    fn lock(&self) -> MutexGuard<'_, HubState> {
        // No change of the state can panic half-way.
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Wakes up at each change.
    pub fn subscribe(&self) -> watch::Receiver<()> {
        self.changed.subscribe()
    }

    /// The state.
    pub fn snapshot(&self) -> Snapshot {
        self.lock().snapshot.clone()
    }

    /// Changes the document, and builds what follows from it.
    pub fn edit(&self, edit: impl FnOnce(&mut EditHistory)) {
        self.change(|shared| {
            edit(&mut shared.document);
            shared.refresh();
        });
    }

    /// Offers edits that earlier servers kept. Those that the document has are not.
    pub fn offer(&self, mut kept: Vec<Kept>) {
        self.change(|shared| {
            kept.retain(|kept| kept.edits != *shared.document.edits());
            shared.kept = kept;
            shared.refresh();
        });
    }

    /// Answers the offer of the edits of a time: they replace those of the document, or are forgotten.
    pub fn answer(&self, time: u64, is_wanted: bool) {
        self.change(|shared| {
            let Some(at) = shared.kept.iter().position(|kept| kept.time == time) else { return };
            let Kept { edits, .. } = shared.kept.remove(at);
            if is_wanted {
                shared.document.edit(edits, String::new());
            }
            shared.refresh();
        });
    }

    /// The revision of the document, and all edits that are in no file, once it is later than `seen`.
    pub fn next_unsaved(&self, seen: u64) -> (u64, Vec<Kept>) {
        let mut shared = self.lock();
        while shared.snapshot.state.revision <= seen {
            shared = self.work.wait(shared).unwrap_or_else(PoisonError::into_inner);
        }
        shared.unsaved()
    }

    /// As [`Hub::next_unsaved`], at once.
    pub fn unsaved(&self) -> (u64, Vec<Kept>) {
        self.lock().unsaved()
    }

    /// Replaces the edits.
    pub fn replace(&self, edits: Options, gesture: String) {
        self.change(|shared| {
            let edits = shared.snapshot.stage.tidied(edits);
            shared.document.edit(edits, gesture);
            shared.refresh();
        });
    }

    fn change(&self, change: impl FnOnce(&mut HubState)) {
        change(&mut self.lock());
        self.work.notify_all();
        self.changed.send_replace(());
    }

    /// Selects a variant of the garment and reads it again.
    pub fn select(&self, variant: Selection) {
        self.read(|ReadOptions { variants, .. }| {
            variants.retain(|v| (&v.prim, &v.set) != (&variant.prim, &variant.set));
            variants.push(variant);
            variants.sort();
        });
    }

    /// Reads the files again. The document stays; after a fault the last garment stays too.
    pub fn reload(&self) {
        self.read(|_| ());
    }

    fn read(&self, change: impl FnOnce(&mut ReadOptions)) {
        let _reading = self.reading.lock().unwrap_or_else(PoisonError::into_inner);
        let mut input = self.lock().input.clone();
        change(&mut input.read);
        let opened = Stage::open(&input);
        self.change(|shared| match opened {
            Ok(stage) => {
                shared.input = input;
                shared.snapshot.stage = Arc::new(stage);
                shared.set_faults(Origin::File, Vec::new());
                shared.show_model();
            }
            Err(error) => shared.set_faults(Origin::File, error.faults),
        });
    }

    /// The prim, time and variants that are read.
    pub fn read_options(&self) -> ReadOptions {
        self.lock().input.read.clone()
    }

    /// Waits for a job after the revision `done`.
    fn next_job(&self, done: u64) -> Job {
        let mut shared = self.lock();
        loop {
            match &shared.job {
                Some(job) if job.revision > done => return job.clone(),
                _ => shared = self.work.wait(shared).unwrap_or_else(PoisonError::into_inner),
            }
        }
    }

    /// Builds one product for ever.
    fn work(self: &Arc<Self>, role: Role, pool: &ThreadPool) {
        let (mut done, mut known) = (0, None);
        loop {
            let job = self.next_job(done);
            done = job.revision;
            let result = catch_unwind(AssertUnwindSafe(|| pool.install(|| self.build(role, &job, &mut known))));
            let result = result.unwrap_or_else(|_| {
                known = None;
                Err(Error::internal("the build ended unexpectedly"))
            });
            let (origin, faults) = match (role, result) {
                (Role::Sim, result) => (Origin::Sim, result),
                (_, result) => (Origin::Render, result),
            };
            self.change(|shared| {
                shared.snapshot.progress.remove(&role);
                shared.set_faults(origin, faults.err().map_or(Vec::new(), |error| error.faults));
            });
        }
    }

    fn build(self: &Arc<Self>, role: Role, job: &Job, known: &mut Option<(Arc<Stage>, Builder)>) -> Result<(), Error> {
        let start = Instant::now();
        let is_known = known.as_ref().is_some_and(|(stage, _)| Arc::ptr_eq(stage, &job.stage));
        let (_, builder) = match known {
            Some(known) if is_known => known,
            known => {
                let hub = Arc::clone(self);
                let progress = Progress::new(move |step| {
                    hub.change(|shared| drop(shared.snapshot.progress.insert(role, step.to_owned())));
                });
                let builder = job.stage.checks.sibling().with_progress(progress);
                known.insert((Arc::clone(&job.stage), builder))
            }
        };
        let recipe = builder.resolve(&job.recipe)?;
        if role == Role::Sim {
            let update = builder.update_sim(&recipe)?;
            let shown = self.show(role, job, &update.mesh, start);
            if shown.message.get().is_none() {
                let _ = shown.quality.set(Arc::new(update.triangle_quality()));
                let figures = Figures::from(&update.figures());
                let _ = shown.message.set(product(role, job, figures, &update.warnings, &[], &recipe));
            }
        } else {
            let update = builder.update_render(&recipe)?;
            let shown = self.show(role, job, &update.mesh, start);
            if shown.message.get().is_none() {
                let figures = Figures::from(&RenderFigures::new(&update.mesh));
                let mut recipe = recipe;
                recipe.render.seam_level = update.seam_level;
                let _ = shown.message.set(product(role, job, figures, &update.warnings, &update.operators, &recipe));
            }
        }
        Ok(())
    }

    /// Shows a mesh, unless it is shown already.
    fn show(&self, role: Role, job: &Job, mesh: &Arc<Mesh>, start: Instant) -> Arc<Shown> {
        let shown = Shown {
            mesh: Arc::clone(mesh),
            revision: job.revision,
            build: start.elapsed().as_secs_f64() * 1e3,
            recipe: Arc::clone(&job.recipe),
            quality: OnceLock::new(),
            message: OnceLock::new(),
        };
        let mut result = Arc::new(shown);
        self.change(|shared| {
            let last = shared.snapshot.shown.get(&role);
            match last.filter(|last| Arc::ptr_eq(&last.mesh, mesh) && is_same_part(role, &last.recipe, &job.recipe)) {
                Some(last) => result = Arc::clone(last),
                None => drop(shared.snapshot.shown.insert(role, Arc::clone(&result))),
            }
        });
        result
    }
}

impl HubState {
    fn unsaved(&self) -> (u64, Vec<Kept>) {
        let mut all = self.kept.clone();
        if self.document.is_unsaved() {
            let time = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_millis() as u64);
            let upstream = checksum_of(&self.snapshot.stage.upstream);
            all.push(Kept { time, upstream, edits: self.document.edits().clone() });
        }
        (self.snapshot.state.revision, all)
    }

    /// A new revision, and its job if the recipe has no fault.
    fn refresh(&mut self) {
        let revision = self.snapshot.state.revision + 1;
        self.snapshot.state = Arc::new(State::new(&self.document, &self.snapshot.stage, self.kept.last(), revision));
        let stage = &self.snapshot.stage;
        let recipe = stage.recipe(self.document.shown());
        let checked = recipe.and_then(|recipe| stage.checks.resolve(&recipe).map(|_| recipe));
        let faults = match checked {
            Ok(recipe) => {
                self.job = Some(Job { revision, stage: Arc::clone(stage), recipe: Arc::new(recipe) });
                Vec::new()
            }
            Err(error) => error.faults,
        };
        self.set_faults(Origin::Recipe, faults);
    }

    /// Shows the garment's cage and builds its products.
    fn show_model(&mut self) {
        self.refresh();
        let shown = Shown {
            mesh: Arc::clone(&self.snapshot.stage.shown),
            revision: self.snapshot.state.revision,
            build: 0.0,
            recipe: Arc::default(),
            quality: OnceLock::new(),
            message: OnceLock::new(),
        };
        self.snapshot.shown.insert(Role::Model, Arc::new(shown));
    }

    fn set_faults(&mut self, origin: Origin, faults: Vec<Fault>) {
        if self.snapshot.faults.get(&origin) != Some(&faults) {
            Arc::make_mut(&mut self.snapshot.faults).insert(origin, faults);
        }
    }
}

/// True if recipes agree in all that a product depends on.
fn is_same_part(role: Role, a: &Recipe, b: &Recipe) -> bool {
    match role {
        Role::Sim => a.sim == b.sim,
        _ => Recipe { sim: b.sim.clone(), ..a.clone() } == *b && a.sim.uv_set == b.sim.uv_set,
    }
}

/// Figures and warnings of a product.
fn product(
    role: Role,
    job: &Job,
    figures: Figures,
    warnings: &Warnings,
    operators: &[String],
    recipe: &Recipe,
) -> Arc<str> {
    let mut lengths = lengths(&job.recipe, recipe);
    lengths.retain(|key, _| key.starts_with("sim.") == (role == Role::Sim));
    let warnings = job.stage.checks.warnings_in_mesh(warnings);
    let (revision, warnings) = (job.revision, warnings.iter().collect());
    ServerMessage::Product(ProductMessage { role, revision, figures, warnings, operators, lengths }).to_text().into()
}
