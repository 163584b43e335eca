//! A mesh with its level of subdivision.

use tailor_mesh::garment::Mesh;
use tailor_mesh::subdivide::Level;

/// A garment with its level.
pub struct Cage {
    garment: Mesh,
    level: Level,
}

impl Cage {
    pub fn new(garment: Mesh) -> Self {
        Self { level: Level::base(&garment), garment }
    }

    pub fn garment(&self) -> &Mesh {
        &self.garment
    }

    pub fn level(&self) -> &Level {
        &self.level
    }
}
