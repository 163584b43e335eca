//! usd-tailor: one coarse garment mesh in, a simulation mesh and a render mesh out, in OpenUSD.
//!
//! ```text
//! usd::read → garment::check → subdivide → sim     ┐
//!                                        → render  ┴→ transfer → usd::write
//! ```
//!
//! Folders in data-flow order; each imports only those before it: [`mesh`] (no positions, no names),
//! [`garment`] (the checked input), [`subdivide`], [`sim`], [`render`], [`transfer`], [`report`] (figures), then
//! [`usd`] and [`recipe`] (the two doors) and [`pipeline`], the stages that the command and every other user runs;
//! [`session`] keeps their results in a [`memo`] for those who run them again and again, such as the OpenUSD plugin.
//! [`error`] is what all may say. `mesh` knows no positions, geometry code knows no USD types, and `usd` is the only
//! place that does.

mod checks;
mod contact;
pub mod error;
pub mod garment;
pub mod memo;
pub mod mesh;
mod parallel;
pub mod pipeline;
pub mod recipe;
pub mod render;
pub mod report;
pub mod session;
pub mod sim;
pub mod subdivide;
pub mod transfer;
pub mod usd;
