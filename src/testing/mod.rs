//! Garments, meshes and measurements that the tests of the engine share.

pub mod built;
pub mod cases;
pub mod checks;
pub mod garments;
pub mod golden;
pub mod nearest;
pub mod operators;
mod peers;
pub mod prepared;
pub mod quality;
pub mod sheets;
pub mod zoo;
