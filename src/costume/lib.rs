//! Cloth, bindings, trims, fits and levels of detail of a garment, with the whole recipe and the whole build.
//!
//! | module | has |
//! |---|---|
//! | [`cloth`] | fabrics, pins, attachments, the shape at rest |
//! | [`mod@drive`] | points that follow a simulated mesh |
//! | [`binding`] | the places of the render mesh's points on the simulation mesh |
//! | [`stitch`] | threads along seams |
//! | [`trim`] | pieces of buttons and zips, rigid or soft |
//! | [`fit`] | a garment on another body |
//! | [`recipe`] | all options: their table, files and layers |
//! | [`pipeline`] | the whole build, with levels of detail |
//!
//! [`Builder`] is what programs run.

pub mod binding;
pub mod cloth;
pub mod codes;
pub mod drive;
pub mod fit;
pub mod pipeline;
pub mod recipe;
pub mod stitch;
pub mod trim;

pub use binding::Binding;
pub use cloth::{Cloth, ClothFigures, ClothOptions, Fabric, FabricOptions, Rest, RestFigures, RestShape};
pub use pipeline::{
    Builder, ClothUpdate, DEFAULT_MAX_FACES, MemoryEstimate, Plan, Products, Progress, RenderPanel, RenderUpdate,
    SimUpdate, Timing, build,
};
pub use recipe::{LodOptions, Recipe};
pub use stitch::{Stitch, StitchKind, StitchOptions};
pub use trim::{TrimMode, TrimOptions};
