//! usd-tailor: one coarse garment mesh in, a simulation mesh and a render mesh out, in OpenUSD.
//!
//! ```text
//! usd::read → garment::check → subdivide → sim     ┐
//!                                        → render  ┴→ transfer → usd::write
//! ```
//!
//! Folders in data-flow order; each imports only those before it: [`error`], [`mesh`], `spatial`, [`garment`],
//! [`usd`], `subdivide`, `sim`, `render`, `transfer`, `pipeline`. `mesh` knows no positions, geometry code knows no
//! USD types, and `usd` is the only door.

pub mod error;
pub mod garment;
pub mod mesh;
pub mod pipeline;
pub mod recipe;
pub mod render;
pub mod report;
pub mod sim;
pub mod spatial;
pub mod subdivide;
pub mod transfer;
pub mod usd;
