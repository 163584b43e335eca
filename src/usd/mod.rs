//! USD: stages in, layers out. No other folder knows a USD type.
//!
//! [`Source`] opens a stage and copies all that is needed from it: the mesh for the geometry code, the properties that
//! products have too, and the facts that `info` prints. [`write()`] turns products into a layer over the stage.
//!
//! `write` imports from `read`, and both from `names`, `values`, `assets` and `record`.

mod assets;
mod names;
mod read;
mod record;
mod values;
mod write;

pub use read::{Binding, Facts, InheritedPrimvar, ReadOptions, Source, TransformOp};
pub use write::{Format, Product, ProductRole, Surroundings, WriteOptions, check_target, layer_bytes, write};

use std::fmt;
use std::thread;

/// A fault while reading or writing USD.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UsdError {
    /// The fault, with file, prim and attribute.
    pub message: String,
    /// The remedy, where there is one.
    pub hint: Option<String>,
}

impl UsdError {
    /// A fault without advice.
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), hint: None }
    }

    /// The same fault with advice.
    #[must_use]
    pub fn hint(self, hint: impl Into<String>) -> Self {
        Self { hint: Some(hint.into()), ..self }
    }
}

impl fmt::Display for UsdError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)?;
        match &self.hint {
            Some(hint) => write!(f, "\n  hint: {hint}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for UsdError {}

/// Stack for composition and writing, which recurse once per level of nested prims. Larger admits deeper stages; only
/// pages in use take memory. \[bytes\]
const STACK: usize = 256 << 20;

/// Runs `work` on a thread with a stack for deeply nested stages.
///
/// # Errors
/// Those of `work`, a thread that cannot start, and a panic in `work`.
fn on_large_stack<T: Send>(work: impl FnOnce() -> Result<T, UsdError> + Send) -> Result<T, UsdError> {
    thread::scope(|scope| {
        let thread = thread::Builder::new().name("usd".into()).stack_size(STACK).spawn_scoped(scope, work);
        match thread.map(thread::ScopedJoinHandle::join) {
            Ok(Ok(result)) => result,
            Ok(Err(_)) => Err(UsdError::new("the USD library failed on this stage")
                .hint("export the file again from the program that wrote it, and please report the failure")),
            Err(e) => Err(UsdError::new(format!("cannot start a thread: {e}"))),
        }
    })
}
