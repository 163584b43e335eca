//! The refined, triangulated surface of a garment, and the target edge lengths on it.

pub mod fairing;
pub mod lengths;
pub mod manifold;
pub mod refine;
pub mod small_shells;
pub mod triangulation;
