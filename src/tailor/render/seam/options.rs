//! The options of seams.

use serde::{Deserialize, Serialize};
use tailor_mesh::connectivity::VertexId;
use tailor_mesh::garment::{Elements, Mesh};
use tailor_mesh::options::{Domain, LARGEST, OptionValue, options};

/// Smallest share of the width on one side. At full asymmetry it separates the lines and keeps the steep flank from
/// flipping.
const MIN_SIDE_SHARE: f32 = 0.05;

/// The most rows on a side of a seam.
const MOST_ROWS: u32 = 16;

/// A height of either sign.
const HEIGHT: Domain = Domain::length([-0.2, 0.2], 0.0);

/// The sides of its edges on which a seam has rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum RowSide {
    /// Both sides; the cloth's side at a border.
    #[default]
    Both,
    /// The left side.
    Left,
    /// The right side.
    Right,
}

impl OptionValue for RowSide {}

impl RowSide {
    /// Whether it has the left and the right side.
    pub fn sides(self) -> [bool; 2] {
        [self != Self::Right, self != Self::Left]
    }
}

/// The shape of a seam's end inside the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum SeamEnd {
    /// Its height falls to nothing over its width.
    #[default]
    Taper,
    /// Its profile leads around the end.
    Round,
    /// It keeps its height up to the end.
    Square,
}

impl OptionValue for SeamEnd {}

options! {
    /// A seam of the render mesh along edge sets, as a groove or a ridge. Left and right refer to the direction in which
    /// most of the edges were authored, with the normals up.
    "seam" => SeamOptions {
        /// False to leave the seam out and keep its options
        "enabled" enabled: bool = true, Domain::Flag, "true or false";

        /// Edge subsets of this mesh that the seam follows; they may be closed, end inside the mesh, and meet at junctions
        "edges" edges: Vec<String> = Vec::new(), Domain::Sets { of: &["edge"], required: true }, "names of subsets";

        /// Crease the surface along the edges, without new faces and rows, as levels of detail do from afar
        "crease" crease: bool = false, Domain::Flag, "true or false";

        /// Width of the seam, reduced where the faces beside it are too small; 0 is 5 mm, or a quarter of the mesh's mean
        /// edge length if that is less
        "width" width: f32 = 0.0,
            Domain::Length { usual: [0.0, 1.0], automatic: 0.25, automatic_most: Some(0.005), largest: LARGEST },
            "mesh units" via "tailor_mesh::garment::units::deserialize_length";

        /// Bulge of the flanks along the normal, a third of the way from the centre to the edge of the seam; above 0 puffs
        /// the cloth up, below 0 hollows it out, 0 is a straight slope
        "depth" depth: f32 = 0.0, HEIGHT, "mesh units" via "tailor_mesh::garment::units::deserialize_length";

        /// Offset of the centre along the normal, reduced where another layer of cloth is near; below 0 is a groove, above
        /// 0 a ridge
        "normalOffset" normal_offset: f32 = 0.0, HEIGHT,
            "mesh units" via "tailor_mesh::garment::units::deserialize_length";

        /// Share of the width on each side: -1 puts it on the left, 1 on the right, 0 half on each; the narrow side keeps a
        /// twentieth at least
        "asymmetry" asymmetry: f32 = 0.0,
            Domain::Number { least: -1.0, most: Some(1.0), or_zero: true, usual: [-1.0, 1.0], step: 0.05 }, "-1 to 1";

        /// Distance along the surface from the edges to the middle of the first row; 0 puts the first row on the edges
        "offset" offset: f32 = 0.0, Domain::length([0.0, 3.0], 0.0),
            "mesh units" via "tailor_mesh::garment::units::deserialize_length";

        /// Sides of the edges that have rows: both, left or right; a border has rows on the side with cloth
        "side" side: RowSide = RowSide::Both, Domain::Choice { words: &["both", "left", "right"] },
            "both, left or right";

        /// End inside the surface: taper lets the height fall to nothing over the width, round leads the profile around the
        /// end, square keeps the height up to the end
        "end" end: SeamEnd = SeamEnd::Taper, Domain::Choice { words: &["taper", "round", "square"] },
            "taper, round or square";

        /// Go through hems and inner layers of folds too, rather than being flat on them
        "through" through: bool = false, Domain::Flag, "true or false";

        /// Number of rows on each side; a row on the edges counts once, for both sides; 0 is 1
        "rows" rows: u32 = 1, Domain::Whole { most: MOST_ROWS, usual: 3 }, "rows";

        /// Distance between the middles of rows; rows that do not fit become narrower; 0 is one and a half widths
        "rowGap" row_gap: f32 = 0.0, Domain::length([0.0, 1.0], 0.0),
            "mesh units" via "tailor_mesh::garment::units::deserialize_length";
    }
}

impl SeamOptions {
    /// Widths of the left and right side. \[mesh units\]
    pub(super) fn side_widths(&self) -> [f32; 2] {
        let left = (0.5 * (1.0 - self.asymmetry)).clamp(MIN_SIDE_SHARE, 1.0 - MIN_SIDE_SHARE);
        [self.width * left, self.width * (1.0 - left)]
    }

    /// The length over which its height falls at an end. \[mesh units\]
    pub(super) fn taper(&self) -> f32 {
        if self.end == SeamEnd::Taper { self.width } else { 0.0 }
    }

    /// The edges of a seam on the cage, in their authored direction.
    pub(super) fn edges_of(&self, garment: &Mesh) -> Vec<[VertexId; 2]> {
        let sets = self.edges.iter().filter_map(|name| garment.subset(name));
        let edges = sets.filter_map(|set| if let Elements::Edges(edges) = &set.elements { Some(edges) } else { None });
        edges.flatten().copied().collect()
    }

    /// Distances of its rows from the edges, without a row on the edges. \[mesh units\]
    pub(super) fn row_distances(&self) -> Vec<f32> {
        let gap = if self.row_gap > 0.0 { self.row_gap } else { 1.5 * self.width };
        let rows = (0..self.rows.max(1)).map(|row| self.offset + row as f32 * gap);
        rows.filter(|&distance| distance > 0.0 && self.width > 0.0 && !self.crease).collect()
    }
}

/// A seam without heights, which move points alone.
pub(super) fn flat((name, options): &(String, SeamOptions)) -> (String, SeamOptions) {
    (name.clone(), SeamOptions { depth: 0.0, normal_offset: 0.0, ..options.clone() })
}
