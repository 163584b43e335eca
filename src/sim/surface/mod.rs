//! The refined, triangulated surface of a garment, and target edge lengths on it.

pub mod lengths;
pub mod manifold;
pub mod triangulation;
