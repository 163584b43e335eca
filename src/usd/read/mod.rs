//! Reading: a stage is opened and everything that the geometry code and the writer need is copied out of it.
//!
//! [`Source`] is the result. Only [`StageOrigin`](origin::StageOrigin) opens stages; `query` asks them and names the prim in errors.

mod bindings;
mod choose;
mod diagnostics;
mod facts;
mod looks;
mod mesh;
mod meshes;
mod model;
mod origin;
mod primvars;
mod query;
mod recipe;
mod shapes;
mod skin;
mod source;
mod space;
mod surroundings;
mod trims;
mod variants;

pub use choose::{all_meshes, all_prims};
pub use diagnostics::{TailorPayloads, tailor_payloads};
pub use facts::{Facts, InheritedPrimvar, MaterialBinding, TransformOp};
pub use looks::Look;
pub use meshes::{LodSchema, ProductNames, is_other, level_name, product_names};
pub use model::{COMPOSITION, Model, Sewing, SubsetRecord, layer_files, stage_metadata};
pub use origin::{Converter, Files, Foreign, Rewritten, StageOrigin, first_used, set_converter};
pub use query::{OrUnreadable, is_a, prim_at, property_names, value, vectors, with_ancestors};
pub use shapes::BlendShape;
pub use source::{FittedPoints, PanelSeam, ReadOptions, Source, composition, variants_of};
pub use space::{is_moving, transforms, world_of};
pub use surroundings::Sibling;
pub use trims::{
    FittedTrim, PlacedMesh, TrimPrim, dependent_attributes, has_points, is_on, points_name, trim_path, trims,
};
pub use variants::{Selection, VariantSet, choices_of, flattened_variants, frozen_trim, joined, select};
