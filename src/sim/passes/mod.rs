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
pub(super) use {
    collapse::{COLLAPSE_RATIO, collapse_short_edges, length_deficit},
    finish::follow_curves,
    queue::keyed_by_both,
    split::{length_excess, split_long_edges},
};
