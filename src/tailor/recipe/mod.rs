//! The options of the two meshes, and what they are for one garment.
//!
//! Each group of options is declared where it is used, by [`options!`](tailor_mesh::options::options). A recipe lists groups
//! ([`recipe!`]): [`MeshRecipe`] those of the two meshes, and a program that makes more of a garment lists more.

mod groups;
mod resolved;
mod sets;
mod uv_set;

pub use crate::__recipe as recipe;
pub use groups::{MeshRecipe, check_counts, full_name};
pub use resolved::{ResolvedMeshes, ResolvedSim, bind_uv_set};
pub use sets::{RecipeSets, named_sets};
pub use uv_set::resolve_uv_set;

use tailor_mesh::options::OptionGroup;

/// The options of a group that a recipe uses, with the start of their keys, such as `sim` or `seam.placket`.
pub type UsedGroup<'a> = (String, &'a dyn OptionGroup);
