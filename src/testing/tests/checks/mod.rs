//! The invariants of every product.

pub mod attributes;
pub mod product;
pub mod refinement;
