//! The simulation mesh: triangles of the wanted size on the garment's surface, conforming to its seams and borders.
//!
//! Data flows one way: `surface` (the refined garment and target lengths), `constraints` (chains of edges and their
//! curves), `baseline` (the surface with its chains, and projection onto it), `sim_mesh` (the mesh under edit),
//! `passes` (split, collapse, flip, relax, and their loop), `product` with `sides` (the same triangles on the other side of a
//! plane), and `made` (the same triangles on another body).

mod baseline;
mod constraints;
mod geometry;
mod made;
mod options;
mod passes;
mod product;
mod shell_uvs;
mod sides;
mod sim_mesh;
mod surface;

pub use baseline::{Baseline, BaselinePoint, Projection, baseline_level};
pub use constraints::cage_edges::half_edge;
pub use constraints::chain::{Chain, ChainKind};
pub use constraints::feature_lines::{BluntRidge, NarrowStrip};
pub use geometry::{angle, closest_weights, distance_to_segment};
pub use made::{as_made, length_scale, made_points, mean_edge_length};
pub use options::{Relaxation, SimOptions};
pub use passes::remesh::RemeshReport;
pub use product::{CurveGap, SimProduct, simulate};
pub use surface::lengths::Lengths;
pub use surface::refine::holes;
