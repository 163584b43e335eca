//! The space of a mesh: its transform and its units.

mod units;
mod xform;

pub use units::{space, units, uv_scales};
pub use xform::{Transforms, is_moving, transforms, world_of};
