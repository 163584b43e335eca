//! The directions of the stage in a mesh.

use glam::Mat3;

/// How the space of a mesh lies in the stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageSpace {
    /// From directions of the mesh to those of the stage.
    pub to_stage: Mat3,
    /// True if z is up, and not y.
    pub is_z_up: bool,
}

impl StageSpace {
    /// The number of the axis that is up.
    pub fn up_axis(&self) -> usize {
        if self.is_z_up { 2 } else { 1 }
    }
}
