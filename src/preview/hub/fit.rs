//! Fits the garment again where the recipe names other bodies, and finds bodies beside it.

use super::{Hub, HubState};
use crate::messages::{BodiesMessage, Role, ServerMessage};
use crate::stage::{Stage, points_on_way};
use rayon::ThreadPool;
use std::collections::BTreeSet;
use std::fs;
use std::iter::once;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError};
use tailor_costume::fit::BodyOptions;
use tailor_mesh::error::{Error, Fault};
use tailor_usd::session::is_usd;
use tailor_usd::{ReadOptions, Source};

/// Bodies that are offered at most, and files among which they are looked for.
const MOST_BODIES: usize = 40;
const MOST_FILES: usize = 100;
/// A larger file is not opened to look for a body. \[bytes\]
const MOST_BYTES: u64 = 64 << 20;

/// A fit that could not be made.
pub struct FailedFit {
    fit: BodyOptions,
    faults: Vec<Fault>,
}

impl Hub {
    /// Shows all meshes after a share of the way; nothing changes without a fit.
    pub fn show_on_way(&self, share: f64) {
        self.change(|shared| shared.show_on_way(share));
    }

    /// Fits for ever, and finds bodies.
    pub fn work_on_fit(self: &Arc<Self>, pool: &ThreadPool) {
        loop {
            let Some(fit) = self.next_fit() else {
                let stage = self.snapshot().stage;
                let files = catch_unwind(AssertUnwindSafe(|| bodies_beside(&stage))).unwrap_or_default();
                let message = BodiesMessage { folder: stage.folder().display().to_string(), files };
                self.change(|shared| shared.tell("bodies", &ServerMessage::Bodies(message)));
                continue;
            };
            self.change(|shared| {
                shared.snapshot.progress.insert(Role::Model, "fitting the garment to the body".to_owned());
            });
            let read = catch_unwind(AssertUnwindSafe(|| pool.install(|| self.read_fitted(&fit, |_| ()))));
            self.change(|shared| {
                shared.snapshot.progress.remove(&Role::Model);
                if let Err(error) = read.unwrap_or_else(|_| Err(Error::internal("the fit ended unexpectedly"))) {
                    shared.fail_fit(fit, error);
                }
            });
        }
    }

    /// Waits for bodies other than those by which the garment is fitted; none if files beside it may be new.
    fn next_fit(&self) -> Option<BodyOptions> {
        let mut shared = self.lock();
        loop {
            if shared.wanted_fit.is_some() {
                return shared.wanted_fit.clone();
            } else if std::mem::take(&mut shared.may_have_bodies) {
                return None;
            }
            shared = self.work.wait(shared).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl HubState {
    /// Shows all meshes after a share of the way of the fit. At its end they are as they were built.
    pub fn show_on_way(&mut self, share: f64) {
        self.snapshot.on_way.clear();
        let Some((message, body)) = self.snapshot.stage.on_way(share) else { return };
        self.share = message.share;
        self.tell("fit", &ServerMessage::Fit(&message));
        if share < 1.0 {
            let under = self.snapshot.shown.get(&Role::Body).map(|shown| Arc::new(shown.moved(body)));
            self.snapshot.on_way.extend(under.map(|shown| (Role::Body, shown)));
            [Role::Model, Role::Sim, Role::Render].into_iter().for_each(|role| self.move_on_way(role));
        }
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
            Some(failed) if failed.fit == fit => failed.faults.clone(),
            _ => {
                self.wanted_fit = Some(fit);
                Vec::new()
            }
        }
    }

    /// Notes that a fit cannot be made. Its faults are those of its options.
    pub fn fail_fit(&mut self, fit: BodyOptions, error: Error) {
        let of_option = |fault: Fault| match fault.place.starts_with("fit.") {
            true => fault,
            false => Fault { text: format!("{}: {}", fault.place, fault.text), place: "fit.to".into(), ..fault },
        };
        let faults = error.faults.into_iter().map(of_option).collect();
        self.failed_fit = Some(FailedFit { fit, faults });
        self.refresh();
    }
}

/// USD files with one mesh in the garment's folder, in those within it and in those beside it, relative to it.
fn bodies_beside(stage: &Stage) -> Vec<String> {
    let own = stage.folder();
    let within = |folder: &Path| -> BTreeSet<PathBuf> {
        fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect()
    };
    let above = own.parent().unwrap_or(&own);
    let beside = within(above).into_iter().filter(|path| *path != own);
    let folders = within(&own).into_iter().chain(beside).filter(|path| path.is_dir());
    let files = once(own.clone()).chain(folders).flat_map(|folder| within(&folder)).filter(|file| {
        let is_small = fs::metadata(file).is_ok_and(|of| of.is_file() && of.len() <= MOST_BYTES);
        is_small && is_usd(file) && file.file_name() != stage.source.file().file_name()
    });
    let one_mesh = ReadOptions { unsewn: true, ..ReadOptions::default() };
    let bodies = files.take(MOST_FILES).filter(|file| Source::open(file, &one_mesh).is_ok()).take(MOST_BODIES);
    let relative = |file: PathBuf| match (file.strip_prefix(&own), file.strip_prefix(above)) {
        (Ok(within), _) => within.display().to_string(),
        (_, Ok(beside)) => Path::new("..").join(beside).display().to_string(),
        _ => file.display().to_string(),
    };
    bodies.map(relative).collect()
}
