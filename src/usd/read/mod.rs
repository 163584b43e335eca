//! Reading: a stage is opened and everything that the geometry code and the writer need is copied out of it.
//!
//! [`Source`] is the result. Only [`StageOrigin`](origin::StageOrigin) opens stages; `query` asks them and names the prim in errors.

mod choose;
mod facts;
mod mesh;
mod model;
mod origin;
mod primvars;
mod query;
mod recipe;
mod shapes;
mod source;
mod variants;

pub use facts::{Binding, Facts, InheritedPrimvar, TransformOp};
pub use model::{COMPOSITION, Model, Sibling, SubsetRecord};
pub use query::{OrUnreadable, prim_at};
pub use shapes::BlendShape;
pub use source::{ReadOptions, Source};
#[cfg(feature = "preview")]
pub use variants::select;
pub use variants::{Selection, VariantSet};
