//! Range checks of a recipe's values.

use super::Recipe;
use crate::checks::length;
use crate::error::Error;

/// Highest subdivision level. Each level quadruples the faces, so a higher one is a mistake. \[levels\]
const MAX_LEVEL: u32 = 6;
/// Highest number of remeshing rounds; more rounds change nothing. \[rounds\]
const MAX_ITERATIONS: u32 = 100;
/// Highest number of transfer samples; more samples cost time and resolve nothing more. \[samples per face\]
const MAX_SAMPLES: u32 = 1024;
/// Smallest grading. A smaller factor spreads a fine region over the whole garment. \[factor\]
const LEAST_GRADING: f32 = 1.05;
/// Highest number of operators, and of fabrics. Each operator is a pass over the mesh, and garments have dozens.
const MAX_NAMES: usize = 1000;

impl Recipe {
    /// Checks the range of every value, without a garment.
    ///
    /// # Errors
    /// A value out of its range.
    pub fn check(&self) -> Result<(), Error> {
        self.check_sim()?;
        self.check_levels()?;
        self.check_counts()?;
        self.cloth.check()?;
        self.fabrics.iter().try_for_each(|(name, options)| options.check(name))?;
        self.enabled().try_for_each(|(name, options)| options.check(&options.key_of(name)))
    }

    fn check_sim(&self) -> Result<(), Error> {
        let (min, max) = (self.sim.min_edge_length, self.sim.max_edge_length);
        length("sim.minEdgeLength", min)?;
        length("sim.maxEdgeLength", max)?;
        if min > max && max > 0.0 {
            let more = format!("{min} is more than sim.maxEdgeLength, {max}");
            return Err(Error::recipe("sim.minEdgeLength", more).remedy("swap the two values"));
        }
        let grading = self.sim.grading;
        if !(grading == 0.0 || grading.is_finite() && grading >= LEAST_GRADING) {
            let fault = format!("{grading} is out of range");
            let hint = format!("give {LEAST_GRADING} or more, or 0 for no limit");
            return Err(Error::recipe("sim.grading", fault).remedy(hint));
        }
        let shell = self.sim.smallest_shell;
        if !(shell >= 0.0 && shell.is_finite()) {
            let fault = format!("{shell} is out of range");
            return Err(Error::recipe("sim.smallestShell", fault).remedy("give 0 or more target triangles"));
        }
        for (key, angle) in [("sim.cornerAngle", self.sim.corner_angle), ("sim.ridgeAngle", self.sim.ridge_angle)] {
            if !(angle > 0.0 && angle <= 180.0) {
                let fault = format!("{angle} is out of range");
                return Err(Error::recipe(key, fault).remedy("give more than 0 and at most 180 degrees"));
            }
        }
        Ok(())
    }

    fn check_counts(&self) -> Result<(), Error> {
        for (key, count) in [
            ("seam", self.seams.len()),
            ("thickness", self.thicknesses.len()),
            ("fabric", self.fabrics.len()),
            ("render.operators", self.render.operators.len()),
        ] {
            if count > MAX_NAMES {
                let fault = format!("there are {count}, and at most {MAX_NAMES} are built");
                return Err(Error::recipe(key, fault).remedy("let one seam follow several edge subsets"));
            }
        }
        Ok(())
    }

    fn check_levels(&self) -> Result<(), Error> {
        for (key, value, most) in [
            ("sim.baselineLevel", self.sim.baseline_level, MAX_LEVEL),
            ("render.level", self.render.level, MAX_LEVEL),
            ("render.seamLevel", self.render.seam_level, MAX_LEVEL),
            ("sim.iterations", self.sim.iterations, MAX_ITERATIONS),
            ("sim.transferSamples", self.sim.transfer_samples, MAX_SAMPLES),
        ] {
            if value > most {
                return Err(Error::recipe(key, format!("{value} is too large")).remedy(format!("give at most {most}")));
            }
        }
        Ok(())
    }
}
