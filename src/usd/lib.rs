//! USD: stages in, layers out. No other folder knows a USD type.
//!
//! [`Source`] opens a stage and copies all that is needed from it: the mesh for the geometry code, the properties that
//! products have too, and the facts that `info` prints. [`write()`] turns products into a layer over the stage.
//!
//! `session` opens garments with their recipes, [`drive()`] makes shots (`shot`), and [`body_of`] reads a body. `session` and `shot` import
//! from `write`, `write` from `read`, and all from `names`, `values`, `assets` and `record`.

mod assets;
mod body;
mod build_record;
pub mod codes;
mod names;
mod read;
mod record;
pub mod session;
mod shot;
mod values;
mod write;

pub use assets::relative;
pub use body::{body_of, stage_to_garment};
pub use build_record::{BuildRecord, Stale, warning_json};
pub use read::Look;
pub use read::{
    Converter, Facts, Foreign, InheritedPrimvar, LodSchema, MaterialBinding, PanelSeam, ProductNames, ReadOptions,
    Rewritten, Selection, Source, TailorPayloads, TransformOp, VariantSet, first_used, product_names, set_converter,
    tailor_payloads, variants_of,
};
pub use shot::{CacheFile, CacheSpace, Playback};
pub use shot::{DriveOptions, Driven, drive};
pub use values::decimal;
pub use values::type_word;
pub use write::{
    BodyChoice, BoundTrim, Format, GarmentProducts, HeldOutput, OutputLock, Product, ProductRole, SetChoice,
    Surroundings, WriteOptions, Written, check_name, check_product_names, check_target, layer_bytes, remove_unfinished,
    write, write_all, write_bodies, write_fitted, write_sets, write_whole,
};
pub use write::{
    EarlierRecipe, OptionValue, PAINTED, RecipeOpinions, garment_below, recipe_text, selections, temporary_beside,
    temporary_folder, write_recipe,
};

use std::panic::resume_unwind;
use std::thread;
use tailor_mesh::error::Error;
use tailor_mesh::meter::PassedLimit;

/// Stack for composition and writing, which recurse once a level of nested prims or braces. The deepest files that are read,
/// with 256 levels of prims or 1,000 of braces, take less than 1 MiB. \[bytes\]
pub const STACK: usize = 16 << 20;

/// Runs `work` on a thread with a stack for deeply nested stages.
///
/// # Errors
/// Those of `work`, a thread that cannot start, and a panic in `work`.
fn on_large_stack<T: Send>(work: impl FnOnce() -> Result<T, Error> + Send) -> Result<T, Error> {
    thread::scope(|scope| {
        let thread = thread::Builder::new().name("usd".into()).stack_size(STACK).spawn_scoped(scope, work);
        match thread.map(thread::ScopedJoinHandle::join) {
            Ok(Ok(result)) => result,
            Ok(Err(panic)) if panic.is::<PassedLimit>() => resume_unwind(panic),
            Ok(Err(_)) => Err(Error::usd("the USD library failed on this stage")
                .remedy("export the file again from the program that wrote it, and please report the failure")),
            Err(e) => Err(Error::no_thread(e)),
        }
    })
}
