//! Constrained edges of the garment, joined into chains, which are curves on the surface.

mod bend;
pub mod cage_edges;
pub mod chain;
pub mod feature_lines;
mod sharp_lines;
pub mod spacing;
