//! The passes of remeshing, and their loop.

mod collapse;
pub mod drift;
mod even;
mod finish;
mod flip;
mod queue;
mod relax;
mod relax_uv;
pub mod remesh;
mod split;
mod valence;

#[cfg(test)]
mod tests;
