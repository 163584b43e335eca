//! Whether the values of a recipe make sense, before any garment is looked at.

use super::Recipe;
use crate::checks::{fault, length};
use crate::error::Error;

/// Refinement quadruples the faces, so a level above this is a mistake. \[levels\]
const MAX_LEVEL: u32 = 6;
/// Rounds above this change nothing any more. \[rounds\]
const MAX_ITERATIONS: u32 = 100;
/// Samples above this settle nothing more, and their time grows with their number. \[samples a face\]
const MAX_SAMPLES: u32 = 1024;
/// Lengths that grow more slowly than this spread a fine region over the whole garment. \[factor\]
const LEAST_GRADING: f32 = 1.05;

impl Recipe {
    pub(super) fn check(&self) -> Result<(), Error> {
        self.check_sim()?;
        self.check_levels()?;
        self.instances().into_iter().try_for_each(|(name, options)| options.check(&options.key_of(name)))
    }

    fn check_sim(&self) -> Result<(), Error> {
        let (min, max) = (self.sim.min_edge_length, self.sim.max_edge_length);
        length("sim.minEdgeLength", min)?;
        length("sim.maxEdgeLength", max)?;
        if min > max && max > 0.0 {
            let more = format!("{min} is more than sim.maxEdgeLength, {max}");
            return fault("sim.minEdgeLength", &more, "exchange the two");
        }
        let grading = self.sim.grading;
        if !(grading == 0.0 || grading.is_finite() && grading >= LEAST_GRADING) {
            let slow = format!("{grading} is no factor by which lengths can grow");
            let hint = format!("give {LEAST_GRADING} or more, or 0 to leave lengths as they are");
            return fault("sim.grading", &slow, &hint);
        }
        let angle = self.sim.corner_angle;
        if !(angle > 0.0 && angle <= 180.0) {
            let none = format!("{angle} is no angle of a corner");
            return fault("sim.cornerAngle", &none, "give more than 0, at most 180");
        }
        Ok(())
    }

    fn check_levels(&self) -> Result<(), Error> {
        for (key, value, most) in [
            ("sim.baselineLevel", self.sim.baseline_level, MAX_LEVEL),
            ("render.level", self.render.level, MAX_LEVEL),
            ("sim.iterations", self.sim.iterations, MAX_ITERATIONS),
            ("sim.transferSamples", self.sim.transfer_samples, MAX_SAMPLES),
        ] {
            if value > most {
                return fault(key, &format!("{value} is too much"), &format!("give at most {most}"));
            }
        }
        Ok(())
    }
}
