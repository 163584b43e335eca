//! Checks of a recipe's values.

use super::Recipe;
use tailor_mesh::error::Error;

/// Highest number of operators, and of fabrics. Each operator is a pass over the mesh, and garments have dozens.
const MAX_NAMES: usize = 1000;

impl Recipe {
    /// Checks every value, without a garment.
    ///
    /// # Errors
    /// A value that its option does not take.
    pub fn check(&self) -> Result<(), Error> {
        self.used().into_iter().try_for_each(|(prefix, options)| options.check(&prefix))?;
        self.check_targets()?;
        self.check_counts()
    }

    fn check_targets(&self) -> Result<(), Error> {
        let (min, max) = (self.sim.min_edge_length, self.sim.max_edge_length);
        if min > max && max > 0.0 {
            let more = format!("{min} is more than sim.maxEdgeLength, {max}");
            return Err(Error::recipe("sim.minEdgeLength", more).remedy("swap the two values"));
        }
        Ok(())
    }

    fn check_counts(&self) -> Result<(), Error> {
        for (key, count) in self.counts().into_iter().chain([("render.operators", self.render.operators.len())]) {
            if count > MAX_NAMES {
                let fault = format!("there are {count}, and at most {MAX_NAMES} are built");
                return Err(Error::recipe(key, fault).remedy("let one seam follow several edge subsets"));
            }
        }
        Ok(())
    }
}
