//! Levels of detail: the recipe of each coarser level.

use super::Recipe;
use crate::options::{Domain, options};

/// The most levels: by the last one a garment of any size is a few faces.
const MOST_LEVELS: u32 = 8;

options! {
    /// Levels of detail of this garment, each with a simulation mesh and a render mesh of its own.
    "lod" => LodOptions {
        /// Number of levels with the garment as the first one; 0 is 1
        "levels" levels: u32 = 1, Domain::Whole { most: MOST_LEVELS, usual: 4 }, "levels";

        /// Ratio of edge lengths between a level and the one before it
        "ratio" ratio: f32 = 2.0,
            Domain::Number { least: 1.25, most: Some(8.0), or_zero: false, usual: [1.25, 4.0], step: 0.25 }, "factor";
    }
}

impl LodOptions {
    /// The numbers of the levels after the first one.
    pub(crate) fn coarser(&self) -> std::ops::Range<u32> {
        1..self.levels.max(1)
    }

    /// How much longer the edges of a level are than those of the first one. \[factor\]
    pub(crate) fn scale(&self, level: u32) -> f32 {
        self.ratio.powi(level as i32)
    }
}

impl Recipe {
    /// The recipe of a level of detail, without levels of its own; of a resolved recipe, and a garment with this mean edge
    /// length \[mesh units\]. Target lengths of the simulation mesh grow with the level, and the render mesh has fewer
    /// refinements; it is no cloth. Seams that are narrower than its faces are creases, and rows beside seams are left out.
    #[must_use]
    pub fn at_level(&self, level: u32, mean_edge: f32) -> Self {
        let mut recipe = self.clone();
        recipe.lod = LodOptions::default();
        if level == 0 {
            return recipe;
        }
        recipe.cloth.physics.clear();
        let scale = self.lod.scale(level);
        recipe.sim.max_edge_length *= scale;
        recipe.sim.min_edge_length *= scale;
        recipe.render.level = self.render.level.saturating_sub(scale.log2().round() as u32);
        let face = mean_edge * (-(recipe.render.level as f32)).exp2();
        for seam in recipe.seam.values_mut().filter(|seam| seam.width < face) {
            seam.enabled &= seam.offset == 0.0;
            seam.crease = true;
        }
        recipe
    }
}
