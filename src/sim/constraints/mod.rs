//! Constrained edges of the garment, joined into chains, which are curves on the surface.

pub mod cage_edges;
pub mod chain;
pub mod ridges;
pub mod spacing;
