//! The door to USD: stages in, layers out. No other folder knows a USD type.
//!
//! [`Source`] opens a stage and takes a copy of all that is needed from it: what geometry code works on, what the
//! writer gives back as it was, and what `info` prints. [`write()`] turns products into a layer beside it.

mod assets;
mod choose;
mod crates;
mod facts;
mod flatten;
mod geometry;
mod long_arrays;
mod model;
mod names;
mod origin;
mod primvars;
mod product;
mod read;
mod recipe;
mod record;
mod save;
mod shapes;
mod values;
mod write;

pub use facts::{Binding, Facts, InheritedPrimvar, TransformOp};
pub use read::{ReadOptions, Source};
pub use write::{Format, Product, ProductRole, Surroundings, WriteOptions, check_target, layer_bytes, write};

use std::fmt;
use std::thread;

/// A fault while reading or writing USD.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UsdError {
    /// What is wrong, naming file, prim and attribute.
    pub message: String,
    /// What the user can do, where there is something.
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

/// Stack reserved for composition and writing, which recurse once a level of nested prims. Larger admits deeper stages;
/// only what is touched takes memory. \[bytes\]
const STACK: usize = 256 << 20;

/// Runs `work` on a thread whose stack holds deeply nested stages.
///
/// # Errors
/// What `work` reports; or that there is no such thread; or that `work` panicked, which is a fault of the reader.
fn on_large_stack<T: Send>(work: impl FnOnce() -> Result<T, UsdError> + Send) -> Result<T, UsdError> {
    thread::scope(|scope| {
        let thread = thread::Builder::new().name("usd".into()).stack_size(STACK).spawn_scoped(scope, work);
        match thread.map(thread::ScopedJoinHandle::join) {
            Ok(Ok(result)) => result,
            Ok(Err(_)) => Err(UsdError::new("the USD library failed on this stage")
                .hint("open and export the file again with the program that wrote it, and please report it")),
            Err(e) => Err(UsdError::new(format!("cannot start a thread: {e}"))),
        }
    })
}
