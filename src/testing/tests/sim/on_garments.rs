//! The simulation mesh of every garment with its own recipe: how near it is to its surface and its curves, and its angles.

use super::{MAX_FACES, baseline};
use crate::prepared::of_file;
use crate::quality::{Quality, Reference, of_product};
use rayon::prelude::*;
use tailor::sim::simulate;
use tailor_testing::garments::garments;

#[test]
fn lie_on_their_surfaces_and_curves() {
    garments().into_par_iter().for_each(|file| {
        let prepared = of_file(&file, []);
        let product = simulate(baseline(&prepared), &prepared.recipe.sim, MAX_FACES);
        let q = Reference::of(&product, |reference| of_product(&product, reference));
        let figures = format!("{}\n{}\n{q}", file.display(), Quality::HEAD);
        assert!(q.to_surface <= 0.35 && q.from_surface <= 0.6, "{figures}");
        assert!(q.curve_max <= 0.1 && q.curve_near >= 0.97, "{figures}");
        // Small details and sharp edges keep a few triangles thin, and lengths that change as they are painted cost a degree.
        assert!(q.rms <= 0.14 && q.p5 >= 39.5 && q.under30 <= 0.01, "{figures}");
    });
}
