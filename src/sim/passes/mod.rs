//! The passes of remeshing, and their loop.

pub mod collapse;
pub mod drift;
pub mod flip;
pub mod follow;
pub mod polish;
pub mod queue;
pub mod relax;
pub mod remesh;
pub mod slide;
pub mod split;
