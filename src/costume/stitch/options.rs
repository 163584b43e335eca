//! Options of a stitch.

use serde::{Deserialize, Serialize};
use tailor::RowSide;
use tailor_mesh::options::{Domain, LARGEST, OptionValue, options};

/// The most rows of a stitch.
const MOST_ROWS: u32 = 16;

/// The kinds of stitches. Numbers are those of ISO 4915.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum StitchKind {
    /// 301: a straight row, the same on both sides.
    #[default]
    Lockstitch,
    /// 401: a straight row above, and a chain below.
    Chainstitch,
    /// 304: from side to side.
    Zigzag,
    /// 504: threads around an edge.
    Overlock,
    /// 605: three rows with a thread across them.
    Flatlock,
    /// A dense zigzag over its whole length.
    Bartack,
    /// 103: a prick now and then.
    Blind,
    /// A running stitch by hand, with its thread above and below in turn.
    HandSewn,
}

impl OptionValue for StitchKind {}

options! {
    /// Thread on the render mesh, along edge sets or along a seam: curves on the finished surface, which move with the cloth.
    "stitch" => StitchOptions {
        /// False to leave the stitch out and keep its options
        "enabled" enabled: bool = true, Domain::Flag, "true or false";

        /// Edge subsets that it follows
        "edges" edges: Vec<String> = Vec::new(), Domain::Sets { of: &["edge"], required: false }, "names of subsets";

        /// Seam whose edges it follows instead
        "along" along: String = String::new(), Domain::Operators, "name of a seam, such as seam.side";

        /// Kind, as ISO 4915 has them: lockstitch is 301, chainstitch 401, zigzag 304, overlock 504, flatlock 605, blind 103
        "kind" kind: StitchKind = StitchKind::Lockstitch,
            Domain::Choice {
                words: &["lockstitch", "chainstitch", "zigzag", "overlock", "flatlock", "bartack", "blind", "handSewn"],
            },
            "word";

        /// Stitches on a centimetre; 0 is that of the kind, such as 4 for lockstitch
        "perCentimetre" per_centimetre: f32 = 0.0,
            Domain::Number { least: 0.1, most: Some(40.0), or_zero: true, usual: [1.0, 8.0], step: 0.5 }, "1/cm";

        /// Diameter of the thread; 0 is 0.4 mm
        "thread" thread: f32 = 0.0,
            Domain::Length { usual: [0.0, 0.1], automatic: 1.0, automatic_most: Some(0.0004), largest: LARGEST },
            "mesh units" via "tailor_mesh::garment::units::deserialize_length";

        /// Width across the line of kinds that have one; 0 is that of the kind, such as 5 mm for overlock
        "width" width: f32 = 0.0, Domain::length([0.0, 1.0], 0.0),
            "mesh units" via "tailor_mesh::garment::units::deserialize_length";

        /// How deep the thread sinks into the cloth: at 0 it lies on it, at 1 it is in it
        "tension" tension: f32 = 0.5,
            Domain::Number { least: 0.0, most: Some(1.0), or_zero: true, usual: [0.0, 1.0], step: 0.05 }, "0 to 1";

        /// Distance along the surface from the edges to the first row; 0 is on the edges
        "offset" offset: f32 = 0.0, Domain::length([0.0, 3.0], 0.0),
            "mesh units" via "tailor_mesh::garment::units::deserialize_length";

        /// Sides of the edges that have rows: both, left or right; a border has rows on the side with cloth
        "side" side: RowSide = RowSide::Both, Domain::Choice { words: &["both", "left", "right"] },
            "both, left or right";

        /// Number of rows on each side; a row on the edges counts once, for both sides; 0 is 1
        "rows" rows: u32 = 1, Domain::Whole { most: MOST_ROWS, usual: 3 }, "rows";

        /// Distance between rows; 0 is 6 mm
        "gap" gap: f32 = 0.0,
            Domain::Length { usual: [0.0, 1.0], automatic: 1.0, automatic_most: Some(0.006), largest: LARGEST },
            "mesh units" via "tailor_mesh::garment::units::deserialize_length";

        /// Stitches that are sewn back and forth again at ends inside the cloth
        "backTack" back_tack: u32 = 3, Domain::Whole { most: 20, usual: 5 }, "stitches";

        /// Material of the thread
        "material" material: String = String::new(), Domain::PrimPath, "path of a prim";
    }
}

impl StitchOptions {
    /// Distances of its rows from the edges, ascending. \[mesh units\]
    pub(super) fn distances(&self) -> Vec<f32> {
        (0..self.rows.max(1)).map(|row| self.offset + row as f32 * self.gap).collect()
    }
}
