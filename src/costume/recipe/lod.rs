//! Levels of detail: the recipe of each coarser level.

use super::Recipe;
use tailor_mesh::options::{Domain, options};

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
    pub fn coarser(&self) -> std::ops::Range<u32> {
        1..self.levels.max(1)
    }

    /// How much longer the edges of a level are than those of the first one. \[factor\]
    pub fn scale(&self, level: u32) -> f32 {
        self.ratio.powi(level as i32)
    }
}

impl Recipe {
    /// The recipe of a level of detail, without levels of its own; of a resolved recipe, and a garment with this mean edge
    /// length \[mesh units\]. Target lengths of the simulation mesh grow with the level, and the render mesh has fewer
    /// refinements; it is not cloth. Seams that are narrower than its faces are creases, and rows beside seams are left out.
    #[must_use]
    pub fn at_level(&self, level: u32, mean_edge: f32) -> Self {
        let mut recipe = self.clone();
        recipe.lod = LodOptions::default();
        if level == 0 {
            return recipe;
        }
        recipe.cloth.physics.clear();
        recipe.stitch.clear();
        let scale = self.lod.scale(level);
        recipe.sim.max_edge_length *= scale;
        recipe.sim.min_edge_length *= scale;
        recipe.render.level = self.render.level.saturating_sub(scale.log2().round() as u32);
        let face = mean_edge * (-(recipe.render.level as f32)).exp2();
        for seam in recipe.seam.values_mut().filter(|seam| seam.width < face && !seam.crease) {
            seam.enabled &= seam.offset == 0.0;
            seam.crease = true;
        }
        recipe
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tailor::SeamOptions;

    fn recipe(levels: u32, ratio: f32) -> Recipe {
        let mut recipe = Recipe { lod: LodOptions { levels, ratio }, ..Recipe::default() };
        (recipe.sim.max_edge_length, recipe.sim.min_edge_length, recipe.render.level) = (2.0, 0.5, 2);
        let seam = |width: f32, offset: f32| SeamOptions { width, offset, ..SeamOptions::default() };
        recipe.seam.insert("thin".into(), seam(0.3, 0.0));
        recipe.seam.insert("row".into(), seam(0.3, 1.0));
        recipe.seam.insert("wide".into(), seam(3.0, 0.0));
        recipe
    }

    #[test]
    fn the_first_level_is_the_recipe_itself() {
        let all = recipe(3, 2.0);
        assert_eq!(all.at_level(0, 2.0), Recipe { lod: LodOptions::default(), ..all.clone() });
        assert!(!all.at_level(0, 2.0).cloth.physics.is_empty());
    }

    #[test]
    fn lengths_grow_and_refinements_go_by_the_ratio() {
        for (ratio, levels) in [(2.0, [2, 1, 0, 0]), (4.0, [2, 0, 0, 0]), (1.5, [2, 1, 1, 0])] {
            let all = recipe(4, ratio);
            for (level, refined) in (0..).zip(levels) {
                let one = all.at_level(level, 2.0);
                assert_eq!(one.render.level, refined, "{ratio} {level}");
                let scale = ratio.powi(level as i32);
                assert_eq!([one.sim.max_edge_length, one.sim.min_edge_length], [2.0 * scale, 0.5 * scale]);
                assert!(level == 0 || one.cloth.physics.is_empty());
                assert_eq!(one.sim.seed, all.sim.seed);
            }
        }
    }

    #[test]
    fn seams_narrower_than_a_face_are_creases() {
        // Faces of the second level are half of an edge of the cage, those of the third all of it.
        let all = recipe(3, 2.0);
        for (level, creases) in [(1, ["row", "thin"].as_slice()), (2, &["row", "thin"])] {
            let one = all.at_level(level, 2.0);
            let found: Vec<&str> =
                one.seam.iter().filter(|(_, seam)| seam.crease).map(|(name, _)| name.as_str()).collect();
            assert_eq!(found, creases);
            assert!(!one.seam["row"].enabled && one.seam["thin"].enabled && one.seam["wide"].enabled);
        }
        assert!(all.at_level(2, 4.0).seam["wide"].crease);
    }
}
