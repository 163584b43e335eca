//! The body that a recipe names.

use serde::{Deserialize, Serialize};
use tailor_mesh::options::{Domain, OptionValue, options};

/// The kinds of sets that move as wholes.
const ANY: &[&str] = &["edge", "point", "face"];

/// The panels of a fitted garment at rest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum PanelRest {
    /// Graded to the body: as much larger than the pattern as the garment is.
    #[default]
    Graded,
    /// As they were made.
    Pattern,
}

impl OptionValue for PanelRest {}

options! {
    /// The body that this garment was made for, and the one that it fits. Relative paths are those beside the file that has them.
    "fit" => BodyOptions {
        /// File of the body that the garment was made for
        "from" from: String = String::new(), Domain::File, "path of a file";

        /// File of the body to fit, with the faces of the first body or a UV set of the same name; empty fits none
        "to" to: String = String::new(), Domain::File, "path of a file";

        /// Sets of this mesh whose connected parts move as wholes, such as buttons
        "rigid" rigid: Vec<String> = Vec::new(), Domain::Sets { of: ANY, required: false }, "names of subsets";

        /// Sets of this mesh whose edges keep their lengths, such as a hem
        "keepLength" keep_length: Vec<String> = Vec::new(), Domain::Sets { of: ANY, required: false },
            "names of subsets";

        /// Distance that the garment gains from the body, as if the second body were as much larger all around
        "ease" ease: f32 = 0.0, Domain::length([0.0, 0.5], 0.0),
            "mesh units" via "tailor_mesh::garment::units::deserialize_length";

        /// Flat panels at rest of a fitted garment: graded to the body, or the pattern as it was made
        "rest" rest: PanelRest = PanelRest::Graded, Domain::Choice { words: &["graded", "pattern"] },
            "graded or pattern";
    }
}
