//! Units of length.

/// The size of a mesh's unit of length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// `metersPerUnit` of the stage.
    pub meters_per_unit: f64,
    /// Stage units in one unit of the mesh's own space: the scale of its transform, the geometric mean of the axes.
    pub scale: f64,
}

impl Units {
    /// Metres in one unit of the mesh.
    pub fn meters(&self) -> f64 {
        self.meters_per_unit * self.scale
    }
}

impl Default for Units {
    /// Centimetres, USD's fallback.
    fn default() -> Self {
        Self { meters_per_unit: 0.01, scale: 1.0 }
    }
}
