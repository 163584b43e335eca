//! Fits the garment again where the recipe names other bodies, finds bodies beside it, and shows it on the way to its body.

use super::workers::guarded;
use super::{Hub, HubState};
use crate::messages::{BodiesMessage, Role, ServerMessage};
use crate::stage::{Stage, points_on_way};
use rayon::ThreadPool;
use std::collections::BTreeSet;
use std::fs;
use std::iter::once;
use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError};
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
        self.change(|shared| shared.show_on_way(share));
    }

    /// Fits for ever, and finds bodies.
    pub fn work_on_fit(self: &Arc<Self>, pool: &ThreadPool) {
        loop {
            let Some(fit) = self.next_fit() else {
                let stage = self.snapshot().stage;
                let files = guarded(pool, || Ok(bodies_beside(&stage))).unwrap_or_default();
                let message = BodiesMessage { folder: stage.folder(), files };
                self.change(|shared| shared.tell("bodies", &ServerMessage::Bodies(message)));
                continue;
            };
            self.change(|shared| shared.show_step(Role::Model, Some("fitting the garment to the body")));
            let read = guarded(pool, || self.read_fitted(&fit, |_| ()));
            self.change(|shared| {
                shared.show_step(Role::Model, None);
                read.unwrap_or_else(|error| shared.fail_fit(fit, error));
            });
        }
    }

    /// Waits for bodies other than those by which the garment is fitted; none if files beside it may be new.
    fn next_fit(&self) -> Option<BodyOptions> {
        let mut shared = self.lock();
        loop {
            if shared.wanted_fit.is_some() || std::mem::take(&mut shared.may_have_bodies) {
                return shared.wanted_fit.clone();
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

/// USD files with one mesh in the garment's folder, in those within it and in those beside it.
fn bodies_beside(stage: &Stage) -> Vec<PathBuf> {
    let within = |folder: &Path| -> BTreeSet<PathBuf> {
        fs::read_dir(folder).into_iter().flatten().flatten().take(MOST_ENTRIES).map(|entry| entry.path()).collect()
    };
    let (own, one_mesh) = (stage.folder(), ReadOptions { unsewn: true, ..ReadOptions::default() });
    let near = within(&own).into_iter().chain(own.parent().map(within).unwrap_or_default());
    let folders = once(own.clone()).chain(near.filter(|path| path.is_dir() && *path != own));
    let files = folders.take(MOST_FILES).flat_map(|folder| within(&folder)).filter(|file| {
        let is_small = fs::metadata(file).is_ok_and(|of| of.is_file() && of.len() <= MOST_BYTES);
        is_small && is_usd(file) && file.file_name() != stage.source.file().file_name()
    });
    files.take(MOST_FILES).filter(|file| Source::open(file, &one_mesh).is_ok()).take(MOST_BODIES).collect()
}
