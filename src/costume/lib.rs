//! What a garment needs beyond its two meshes.

pub mod binding;
pub mod cloth;
pub mod codes;
pub mod drive;
pub mod fit;
pub mod pipeline;
pub mod recipe;
pub mod trim;

pub use binding::Binding;
pub use cloth::{Cloth, ClothFigures, ClothOptions, Fabric, FabricOptions, Rest, RestFigures, RestShape};
pub use pipeline::{
    Builder, ClothUpdate, DEFAULT_MAX_FACES, MemoryEstimate, Plan, Products, Progress, RenderPanel, RenderUpdate,
    SimUpdate, Timing, build,
};
pub use recipe::{LodOptions, Recipe};
pub use trim::{TrimMode, TrimOptions};
