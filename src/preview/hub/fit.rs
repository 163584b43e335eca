//! Fits the garment again where the recipe names other bodies, finds bodies beside it, and shows it on the way to its body.

use super::workers::guarded;
use super::{Hub, HubState};
use crate::messages::{BodiesMessage, FitMessage, Role, ServerMessage};
use crate::stage::{Stage, folder, points_on_way};
use glam::Vec3;
use rayon::ThreadPool;
use std::collections::BTreeSet;
use std::fs;
use std::iter::once;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use tailor_costume::fit::BodyOptions;
use tailor_mesh::error::{Error, Fault};
use tailor_usd::session::is_usd;
use tailor_usd::{ReadOptions, Source};

/// Bodies that are offered at most, files and folders that are looked at for them, and entries of one folder.
const MOST_BODIES: usize = 40;
const MOST_FILES: usize = 100;
const MOST_ENTRIES: usize = 10_000;
/// A larger file is not opened to look for a body. \[bytes\]
const MOST_BYTES: u64 = 64 << 20;

impl Hub {
    /// Shows all meshes after a share of the way; nothing changes without a fit.
    pub fn show_on_way(&self, share: f64) {
        let stage = self.snapshot().stage;
        let place = stage.on_way(share);
        self.change(|shared| shared.show_on_way(&stage, place));
    }

    /// Looks for bodies near the garment on a thread of its own, and sends each that it finds.
    pub fn find_bodies(self: &Arc<Self>) {
        let hub = Arc::clone(self);
        let work = move || {
            let Ok(_finding) = hub.finding.try_lock() else { return };
            let (stage, mut files) = (hub.snapshot().stage, Vec::new());
            for file in bodies_near(&stage).map(Some).chain([None]) {
                let is_complete = file.is_none();
                files.extend(file);
                let message = ServerMessage::Bodies(BodiesMessage { files: &files, is_complete });
                hub.change(|shared| shared.tell("bodies", &message));
            }
        };
        let _ = thread::Builder::new().name("bodies".into()).spawn(work);
    }

    /// Fits for ever.
    pub fn work_on_fit(self: &Arc<Self>, pool: &ThreadPool) {
        loop {
            let fit = self.next_fit();
            self.change(|shared| shared.show_step(Role::Model, Some("fitting the garment to the body")));
            let read = guarded(pool, || self.read_fitted(&fit, |_| ()));
            self.change(|shared| {
                shared.show_step(Role::Model, None);
                read.unwrap_or_else(|error| shared.fail_fit(fit, error));
            });
        }
    }

    /// Waits for bodies other than those by which the garment is fitted.
    fn next_fit(&self) -> BodyOptions {
        self.wait_for(|shared| shared.wanted_fit.clone())
    }
}

impl HubState {
    /// Shows all meshes at a place on the way of the fit, with the points of the body there. At its end they are as they were built.
    pub fn show_on_way(&mut self, stage: &Arc<Stage>, place: Option<(FitMessage, Vec<Vec3>)>) {
        self.snapshot.on_way.clear();
        // Of a garment that was read meanwhile, the end is shown.
        let is_shown = Arc::ptr_eq(&self.snapshot.stage, stage);
        let Some((message, body)) = place.filter(|_| is_shown) else { return };
        self.share = message.share;
        self.tell("fit", &ServerMessage::Fit(&message));
        let body = self.snapshot.shown.get(&Role::Body).map(|shown| Arc::new(shown.moved(body)));
        self.snapshot.on_way.extend(body.map(|shown| (Role::Body, shown)));
        [Role::Model, Role::Sim, Role::Render].into_iter().for_each(|role| self.move_on_way(role));
    }

    /// Moves a mesh that was built to the place on the way that is shown.
    pub fn move_on_way(&mut self, role: Role) {
        let Some(shown) = self.snapshot.shown.get(&role).filter(|_| self.share < 1.0) else { return };
        let moved = shown.moved(points_on_way(&shown.mesh, self.share));
        self.snapshot.on_way.insert(role, Arc::new(moved));
    }

    /// Asks for a fit, unless it has failed already. Gives its faults then.
    pub fn want_fit(&mut self, fit: BodyOptions) -> Vec<Fault> {
        match &self.failed_fit {
            Some((failed, faults)) if *failed == fit => faults.clone(),
            _ => {
                self.wanted_fit = Some(fit);
                Vec::new()
            }
        }
    }

    /// Notes that a fit cannot be made. Its faults are those of its options.
    pub fn fail_fit(&mut self, fit: BodyOptions, mut error: Error) {
        for fault in error.faults.iter_mut().filter(|fault| !fault.place.starts_with("fit.")) {
            fault.text = format!("{}: {}", std::mem::replace(&mut fault.place, "fit.to".into()), fault.text);
        }
        self.failed_fit = Some((fit, error.faults));
        self.refresh();
    }
}

fn entries(folder: &Path) -> BTreeSet<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.take(MOST_ENTRIES).map(|entry| entry.path()).collect()
}

/// USD files with one mesh in the garment's folder, in those within it and in those beside it.
fn bodies_near(stage: &Stage) -> impl Iterator<Item = PathBuf> {
    let (own, garment) = (folder(&stage.source), stage.source.file().file_name());
    let near = entries(&own).into_iter().chain(own.parent().map(entries).unwrap_or_default());
    let folders = once(own.clone()).chain(near.filter(move |path| path.is_dir() && *path != own)).take(MOST_FILES);
    let is_small = |file: &Path| fs::metadata(file).is_ok_and(|of| of.is_file() && of.len() <= MOST_BYTES);
    let files = folders.flat_map(|folder| entries(&folder));
    let files = files.filter(move |file| is_usd(file) && is_small(file) && file.file_name() != garment);
    let has_one_mesh =
        |file: &PathBuf| Source::open(file, &ReadOptions { unsewn: true, ..ReadOptions::default() }).is_ok();
    files.take(MOST_FILES).filter(has_one_mesh).take(MOST_BODIES)
}
