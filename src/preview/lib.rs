//! The live preview: a page in the browser that shows a garment while its recipe is edited.
//!
//! ```text
//! page ── edits ──▶ socket ──▶ hub ── jobs ──▶ two threads, each with a Builder
//! page ◀── frames ── frame ◀── snapshots ──┘
//! ```
//!
//! `hub` holds the state that all pages share: the garment (`stage`), the edits with undo (`document`), and the last
//! meshes. It keeps unsaved edits (`hub::keep`), plays a cache (`hub::shot`), fits the garment
//! (`hub::fit`) and runs builds (`hub::builds`). A page has one
//! `socket`, which sends what changed since the last message. `select` finds what a page selects. `save` writes the edits as a
//! USD layer or a `.tailor` file, and presets beside the garment. `watch` reads the stage again when a file changes. `server`
//! serves the embedded `page` on 127.0.0.1, below a secret path.

pub mod codes;
mod document;
mod frame;
mod hub;
mod messages;
mod page;
mod presets;
mod save;
mod select;
mod server;
mod socket;
mod stage;
#[cfg(test)]
mod tests;
mod watch;

use hub::Hub;
use hub::keep::{self, Keeper};
use stage::Stage;
use std::sync::Arc;
use tailor_mesh::error::Error;
use tailor_usd::session::{Input, is_usd};
use tailor_usd::{CacheFile, garment_below, selections};

/// Serves the preview of a garment until the process is interrupted, with a cache of its simulation mesh to play. `ready` gets its
/// address.
///
/// # Errors
/// A garment that cannot be opened, a port that is in use, a program that was built without the page.
pub fn serve(
    input: Input,
    cache: Option<CacheFile>,
    port: u16,
    threads: Option<usize>,
    ready: impl FnOnce(&str),
) -> Result<(), Error> {
    page::check()?;
    let input = continued(input);
    let stage = Stage::open(&input, None)?;
    let keeper = keep::state_folder().map(|folder| Keeper::new(&folder, &input, &stage));
    let hub = Hub::new(input, stage);
    save::presets::read(&hub);
    if let Some(cache) = cache {
        hub.start_shot(cache, threads)?;
    }
    hub.start(threads)?;
    let _watcher = watch::follow(&hub)?;
    let Some((keeper, kept)) = keeper else { return server::run(&hub, port, ready) };
    let keeper = Arc::new(keeper);
    hub.offer(kept);
    keep::start(&hub, &keeper)?;
    let served = server::run(&hub, port, ready);
    let (revision, unsaved) = hub.unsaved();
    // The thread has warned of a folder that cannot be written to.
    let _ = keeper.write(revision, unsaved);
    served
}

/// A layer that was saved here is a recipe for the garment below it, so that it can be saved again. Variants that a recipe
/// layer selects are selected.
fn continued(input: Input) -> Input {
    let mut input = match garment_below(&input.file) {
        Some(file) if input.recipe.is_none() => Input { recipe: Some(input.file), file, ..input },
        _ => input,
    };
    if let Some(recipe) = input.recipe.as_deref().filter(|recipe| is_usd(recipe)) {
        input.read.variants = selections(recipe);
    }
    input
}
