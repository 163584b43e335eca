//! Garments, meshes and measurements that the tests of the engine share.

pub mod attributes;
pub mod built;
pub mod cases;
pub mod garments;
pub mod golden;
pub mod nearest;
pub mod operators;
pub mod prepared;
pub mod product;
pub mod quality;
pub mod refinement;
pub mod sheets;
pub mod zoo;
