//! Writing: products become prims of a layer, and the layer becomes a file or bytes in memory.

mod beside;
mod crates;
mod fit;
mod flatten;
mod layer;
mod levels;
mod package;
mod physics;
mod product;
mod recipe;
mod role;
mod save;
mod scope;
mod sets;
mod shapes;
mod stitches;
mod trims;
mod variant;

pub use crates::{add_empty_text, write_crate};
pub use fit::{BodyChoice, write_bodies, write_fitted};
pub use layer::{
    Surroundings, WriteOptions, Written, check_name, check_product_names, check_target, layer_bytes, write, write_all,
};
pub use physics::pose_points;
pub use product::extent;
pub use recipe::{EarlierRecipe, OptionValue, RecipeOpinions, garment_below, recipe_text, selections, write_recipe};
pub use role::{GarmentProducts, Product, ProductRole, SetChoice};
pub use save::{
    Format, HeldOutput, OutputFile, OutputLock, PREFIX, Unfinished, Unnamed, remove_unfinished, temporary_beside,
    temporary_folder, write_whole,
};
pub use sets::write_sets;
pub use trims::{BoundTrim, off_cloth};
