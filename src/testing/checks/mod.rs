//! What must hold for every product.

pub mod attributes;
pub mod product;
pub mod refinement;
