//! Constrained edges of the garment as curves on the surface.

pub mod chain;
pub mod ridges;
pub mod spacing;
