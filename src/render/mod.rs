//! The render mesh: the cage through its operators, then refined.

use crate::garment::{BoundaryInterpolation, Garment};
use crate::subdivide::{Cage, Level};
use serde::{Deserialize, Serialize};

/// Options of the render mesh: the attributes of `TailorRenderAPI`, with the same names and defaults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default, deny_unknown_fields)]
pub struct RenderOptions {
    /// Refinements of the cage. \[levels\]
    pub level: u32,
    /// Names of the operators in the order in which they run; empty: seams, then thickness.
    pub operators: Vec<String>,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self { level: 1, operators: Vec::new() }
    }
}

/// The render mesh of a checked garment.
///
/// A polygonal mesh (`subdivisionScheme = "none"`) is refined as if bilinear and stays polygonal.
pub fn render(garment: &Garment, options: &RenderOptions) -> Garment {
    if options.level == 0 {
        return garment.clone();
    }
    let mut garment = garment.clone();
    add_border_holes(&mut garment);
    let cage = (0..options.level).fold(Cage::new(garment), |cage, _| cage.refined());
    cage.into_garment()
}

/// Notes the faces that `interpolateBoundary = "none"` removes, which are fewer with each refinement.
fn add_border_holes(cage: &mut Garment) {
    if cage.rules.boundary == BoundaryInterpolation::None {
        let holes = Level::base(cage).border_holes(cage);
        cage.holes.extend(holes);
        cage.holes.sort_unstable();
        cage.holes.dedup();
    }
}
