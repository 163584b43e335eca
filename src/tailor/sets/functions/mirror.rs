//! The other side of a symmetric garment.

use crate::sets::SetFault;
use crate::sets::elements::ElementSet;
use crate::sets::evaluate::{Arguments, Evaluation};

pub fn mirror(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Result<ElementSet, SetFault> {
    let set = arguments.set(of, 0)?;
    match of.sets.symmetry() {
        Some(symmetry) => Ok(symmetry.mirrored(&of.sets.topology, &set)),
        None => {
            let text = format!("{} has no plane of symmetry", of.sets.garment.prim);
            Err(SetFault::new(text, "name the set of the other side"))
        }
    }
}
