//! The state that all pages share, and the threads that build.
//!
//! A change of the document gives a new revision. Each thread (`workers`) builds the newest one and skips those between; the two
//! products do not wait for one another. Results that are the same as before keep their `Arc`, by which pages know that
//! they have them.

mod builds;
mod fit;
pub mod keep;
mod shot;
mod workers;

use super::document::{EditHistory, Options};
use super::messages::{Origin, ProgressMessage, Role, ServerMessage, StateMessage};
use super::stage::Stage;
use builds::SavedAs;
use keep::{Kept, checksum_of};
use shot::Shot;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};
use tailor::report::TriangleQuality;
use tailor_costume::fit::BodyOptions;
use tailor_costume::recipe::Recipe;
use tailor_mesh::connectivity::{FaceId, IdVec};
use tailor_mesh::error::{Error, Fault};
use tailor_mesh::garment::Mesh;
use tailor_usd::session::Input;
use tailor_usd::{ReadOptions, Selection};
use tokio::sync::watch;
use workers::Simulated;

/// A mesh that pages may show.
#[derive(Clone, Default)]
pub struct Shown {
    /// The mesh.
    pub mesh: Arc<Mesh>,
    /// The first revision that gave it.
    pub revision: u64,
    /// Time to build it. \[milliseconds\]
    pub build: f64,
    /// The recipe that it was built from.
    pub recipe: Arc<Recipe>,
    /// The model's face of each face; empty for the model.
    pub sources: Arc<IdVec<FaceId, FaceId>>,
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
    pub state: Arc<StateMessage>,
    /// Faults by origin.
    pub faults: Arc<BTreeMap<Origin, Vec<Fault>>>,
    /// The meshes.
    pub shown: BTreeMap<Role, Arc<Shown>>,
    /// The meshes of a frame of the cache, which are shown in place of those at bind.
    pub posed: BTreeMap<Role, Arc<Shown>>,
    /// The meshes on the way of the fit, in place of those at its end.
    pub on_way: BTreeMap<Role, Arc<Shown>>,
    /// The last message of each kind that pages get when it is new.
    pub messages: BTreeMap<String, Arc<str>>,
}

/// A recipe to build.
#[derive(Clone)]
struct Job {
    revision: u64,
    stage: Arc<Stage>,
    recipe: Arc<Recipe>,
    /// The level of detail that is shown.
    level: u32,
}

struct HubState {
    input: Input,
    document: EditHistory,
    /// Edits of earlier servers that the user may have back, oldest first.
    kept: Vec<Kept>,
    snapshot: Snapshot,
    job: Option<Job>,
    /// The level of detail that was asked for.
    level: u32,
    /// The bodies by which the garment is to be fitted again.
    wanted_fit: Option<BodyOptions>,
    failed_fit: Option<(BodyOptions, Vec<Fault>)>,
    /// The share of the way of the fit that is shown.
    share: f64,
    is_building: bool,
    /// The newest simulation mesh.
    simulated: Option<Simulated>,
    /// The file that has the edits as they were last saved.
    saved: SavedAs,
    shot: Option<Shot>,
}

/// The state that all pages share.
pub struct Hub {
    shared: Mutex<HubState>,
    /// Held while the stage is read, so that a slow read does not end after a newer one.
    reading: Mutex<()>,
    /// Held while bodies are looked for.
    finding: Mutex<()>,
    work: Condvar,
    changed: watch::Sender<()>,
}

impl Hub {
    /// Shows a garment.
    pub fn new(input: Input, stage: Stage) -> Arc<Self> {
        let document = EditHistory::new(stage.given.clone());
        let snapshot = Snapshot {
            state: Arc::default(),
            stage: Arc::new(stage),
            faults: Arc::default(),
            shown: BTreeMap::new(),
            posed: BTreeMap::new(),
            on_way: BTreeMap::new(),
            messages: BTreeMap::new(),
        };
        let saved = SavedAs::opened(&input);
        let shared = HubState {
            input,
            document,
            kept: Vec::new(),
            snapshot,
            job: None,
            level: 0,
            wanted_fit: None,
            failed_fit: None,
            share: 1.0,
            is_building: false,
            simulated: None,
            saved,
            shot: None,
        };
        let (shared, changed) = (Mutex::new(shared), watch::Sender::new(()));
        let (reading, finding, work) = Default::default();
        let hub = Arc::new(Self { shared, reading, finding, work, changed });
        hub.change(HubState::show_model);
        hub
    }

    fn lock(&self) -> MutexGuard<'_, HubState> {
        // No change of the state can panic half-way.
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for changes until something is found.
    fn wait_for<T>(&self, find: impl Fn(&HubState) -> Option<T>) -> T {
        let mut shared = self.lock();
        loop {
            match find(&shared) {
                Some(found) => return found,
                None => shared = self.work.wait(shared).unwrap_or_else(PoisonError::into_inner),
            }
        }
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

    /// Notes that `edits` with the variants that are selected are in a file.
    pub fn note_saved(&self, edits: Options, file: &Path) {
        self.change(|shared| {
            shared.document.note_saved(edits);
            shared.saved = SavedAs::saved(file, &shared.input.read.variants);
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
        self.wait_for(|shared| (shared.snapshot.state.revision > seen).then(|| shared.unsaved()))
    }

    /// As [`Hub::next_unsaved`], at once.
    pub fn unsaved(&self) -> (u64, Vec<Kept>) {
        self.lock().unsaved()
    }

    /// Shows a level of detail, or the last one if there are fewer.
    pub fn show_level(&self, level: u32) {
        self.change(|shared| {
            shared.level = level;
            shared.refresh();
        });
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
        self.change(|shared| shared.failed_fit = None);
        self.read(|_| ());
    }

    /// Holds back all who read the garment's files, until the guard is dropped.
    pub fn reading(&self) -> MutexGuard<'_, ()> {
        self.reading.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Shows other presets, as a message. After a fault the last ones stay.
    pub fn show_presets(&self, message: Result<String, Error>) {
        self.change(|shared| {
            let fault = message.map(|message| shared.snapshot.messages.insert("presets".into(), message.into())).err();
            shared.set_faults(Origin::Presets, fault.map_or(Vec::new(), |error| error.faults));
        });
    }

    fn read(&self, change: impl FnOnce(&mut ReadOptions)) {
        let Snapshot { stage, state, .. } = self.snapshot();
        let fit = stage.recipe(&state.edits).map_or_else(|_| stage.fit.clone(), |recipe| recipe.fit);
        if let Err(error) = self.read_fitted(&fit, change) {
            let is_of_fit = error.faults.iter().all(|fault| fault.place.starts_with("fit."));
            self.change(|shared| match is_of_fit {
                true => shared.fail_fit(fit, error),
                false => shared.set_faults(Origin::File, error.faults),
            });
        }
    }

    /// Reads the files and fits the garment. After a fault, the last one stays.
    fn read_fitted(&self, fit: &BodyOptions, change: impl FnOnce(&mut ReadOptions)) -> Result<(), Error> {
        let _reading = self.reading();
        let mut input = self.lock().input.clone();
        change(&mut input.read);
        let stage = Stage::open(&input, Some(fit))?;
        self.change(|shared| {
            shared.input = input;
            shared.snapshot.stage = Arc::new(stage);
            shared.set_faults(Origin::File, Vec::new());
            shared.show_model();
        });
        Ok(())
    }

    /// The prim, time and variants that are read.
    pub fn read_options(&self) -> ReadOptions {
        self.lock().input.read.clone()
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
        let saved_as = self.saved_as().map(|saved| saved.file.display().to_string());
        let stage = Arc::clone(&self.snapshot.stage);
        let recipe = stage.recipe(self.document.shown());
        let checked = recipe.and_then(|recipe| stage.checks.resolve(&recipe).map(|_| recipe));
        let last = checked.as_ref().map_or(self.level, |recipe| recipe.lod.levels.saturating_sub(1));
        let level = self.level.min(last);
        let layers = stage.layers(self.document.edits());
        let state = StateMessage {
            revision,
            serial: 0,
            upstream: stage.upstream.clone(),
            edits: self.document.edits().clone(),
            stack: layers.operators(),
            merged: layers.into_map(),
            can_undo: self.document.can_undo(),
            can_redo: self.document.can_redo(),
            unsaved: self.document.is_unsaved(),
            comparing: self.document.comparing,
            level,
            saved_as,
            kept: self.kept.last().map(|kept| kept.offered(&stage.upstream)),
        };
        self.wanted_fit = None;
        let faults = match checked {
            Ok(recipe) if !stage.is_fitted_by(&recipe.fit) => self.want_fit(recipe.fit),
            Ok(recipe) => {
                self.job = Some(Job { revision, stage, recipe: Arc::new(recipe), level });
                Vec::new()
            }
            Err(error) => error.faults,
        };
        self.snapshot.state = Arc::new(state);
        self.set_faults(Origin::Recipe, faults);
    }

    /// The file that has what is on screen.
    fn saved_as(&self) -> Option<&SavedAs> {
        let is_saved = !self.document.is_unsaved() && self.saved.variants == self.input.read.variants;
        is_saved.then_some(&self.saved)
    }

    /// Shows the garment's cage and builds its products.
    fn show_model(&mut self) {
        self.refresh();
        let stage = Arc::clone(&self.snapshot.stage);
        self.show_as_read(Role::Model, &stage.shown);
        match &stage.body {
            Some(body) => self.show_as_read(Role::Body, body),
            None => drop(self.snapshot.shown.remove(&Role::Body)),
        }
        self.snapshot.messages.remove("fit");
        self.show_on_way(&stage, stage.on_way(1.0));
    }

    /// Shows a mesh of a file.
    fn show_as_read(&mut self, role: Role, mesh: &Arc<Mesh>) {
        let revision = self.snapshot.state.revision;
        self.snapshot.shown.insert(role, Arc::new(Shown { mesh: Arc::clone(mesh), revision, ..Shown::default() }));
    }

    /// Sends pages a message, unless it is the last one of its kind.
    fn tell(&mut self, kind: &str, message: &ServerMessage<'_>) {
        self.snapshot.messages.insert(kind.to_owned(), message.to_text().into());
    }

    /// Shows the step of the build of a mesh; none at its end.
    fn show_step(&mut self, role: Role, step: Option<&str>) {
        self.tell(&format!("progress {role:?}"), &ServerMessage::Progress(ProgressMessage { role, step }));
    }

    fn set_faults(&mut self, origin: Origin, faults: Vec<Fault>) {
        if self.snapshot.faults.get(&origin) != Some(&faults) {
            Arc::make_mut(&mut self.snapshot.faults).insert(origin, faults);
        }
    }
}
