//! Options of a trim.

use serde::{Deserialize, Serialize};
use tailor_mesh::options::{Domain, OptionValue, options};

/// How a trim rides on cloth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum TrimMode {
    /// Each piece by its size and thickness.
    #[default]
    Auto,
    /// Each piece moves as a whole.
    Rigid,
    /// Each point moves with the cloth below it.
    Soft,
    /// It stays where it is.
    None,
}

impl OptionValue for TrimMode {}

options! {
    /// Prims that ride on the cloth and are not cloth, such as buttons, buckles, zips and patches.
    "trim" => TrimOptions {
        /// Meshes, curves, points and PointInstancers, or prims above them, by path or by name beside this mesh
        "prims" prims: Vec<String> = Vec::new(), Domain::Prims, "paths of prims";

        /// How they move: rigid is each connected piece or instance as a whole, soft is each point with the cloth below it,
        /// none leaves them where they are, auto is rigid for small or thick pieces and soft for others
        "mode" mode: TrimMode = TrimMode::Auto, Domain::Choice { words: &["auto", "rigid", "soft", "none"] },
            "auto, rigid, soft or none";

        /// Mesh of the garment that they ride on; empty is the nearest
        "on" on: String = String::new(), Domain::PrimPath, "path of a prim";
    }
}
