//! Trims: buttons, buckles, zips, patches, and whatever else lies on cloth and is not simulated.
//!
//! A trim consists of pieces: the connected parts of a mesh, the curves of a set, or instances. All points of a rigid piece have one
//! place on the simulation mesh, so that its frame there moves them together. Each point of a soft piece has its own.

mod options;
mod shape;

pub use options::{TrimMode, TrimOptions};
pub use shape::{Ride, Stiffness, TrimShape, faces};
