//! The passes of remeshing, and their loop.

mod collapse;
pub mod drift;
mod even;
mod flip;
mod follow;
mod polish;
mod queue;
mod relax;
pub mod remesh;
mod split;
mod valence;
