//! Warnings of seams on edges and of rows.

use crate::codes;
use crate::render::operator::OperatorOutput;
use tailor_mesh::connectivity::VertexId;
use tailor_mesh::error::{Warning, counted};

/// The warning of vertices where the height of a seam is reduced, each with the share that is left.
pub fn shallow_seam(
    name: &str,
    output: &OperatorOutput,
    here: impl Iterator<Item = (VertexId, f32)> + Clone,
) -> Option<Warning> {
    let (count, least) = (here.clone().count(), here.clone().map(|s| s.1).fold(1.0, f32::min));
    let problem = format!(
        "its normalOffset is reduced at {}, down to {:.0} %, to clear another layer or an intersection",
        counted(count, "vertex", "vertices"),
        100.0 * least
    );
    let warning = Warning::new(codes::SHALLOW_SEAM, format!("seam.{name}"), problem);
    let warning = warning.at(output.input_points(here.map(|s| s.0))).amount(least);
    let remedy = format!("Move `seam.{name}.normalOffset` towards 0, or run folds after the seam");
    (count > 0).then(|| warning.remedy(remedy))
}
