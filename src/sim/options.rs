//! Options of the simulation mesh.

use crate::garment::units::deserialize_length;
use serde::{Deserialize, Serialize};

/// Options of the simulation mesh: the attributes of `TailorSimAPI`, with the same names and defaults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default, deny_unknown_fields)]
pub struct SimOptions {
    /// Target edge length where the density is 1. \[mesh units\] 0: half of `maxEdgeLength`, or all of it where no
    /// density is named.
    #[serde(deserialize_with = "deserialize_length")]
    pub min_edge_length: f32,
    /// Target edge length where the density is 0. \[mesh units\] 0: half the mean edge length of the input.
    #[serde(deserialize_with = "deserialize_length")]
    pub max_edge_length: f32,
    /// Name of the painted vertex primvar, 1 = `minEdgeLength`, 0 = `maxEdgeLength`; empty: `maxEdgeLength` everywhere.
    pub density: String,
    /// Largest ratio of target lengths between neighbouring edges. \[factor\] 0: targets follow the density ungraded.
    pub grading: f32,
    /// Refinements of the input that give the surface which the mesh lies on. \[levels\] A garment of 50,000 faces or more
    /// gets fewer, but one at least, where its edges are at most half the target lengths before.
    pub baseline_level: u32,
    /// Rounds of split, collapse, flip and relax. \[rounds\]
    pub iterations: u32,
    /// The UV set whose shell borders are seams; empty: none.
    pub uv_set: String,
    /// Whether the borders of UV shells are edges of the mesh.
    pub constrain_uv_seams: bool,
    /// UV shells smaller than so many equilateral triangles of target length constrain nothing: their borders are no edges of
    /// the mesh unless they are borders of the mesh, creases or in `constraints`, and UVs beside them are approximate.
    /// \[target triangles\] 0: all shells do.
    pub smallest_shell: f32,
    /// Edge subsets that become edges of the mesh.
    pub constraints: Vec<String>,
    /// A seam, border or constraint that turns by more than this within one edge length has a corner there, which stays.
    /// \[degrees\] 180: none has.
    pub corner_angle: f32,
    /// A fold that turns by more than this within one target length becomes a chain of edges. \[degrees\] 180: none does.
    pub ridge_angle: f32,
    /// Samples for each expected face when sets and colours are transferred. \[samples\]
    pub transfer_samples: u32,
    /// Seed of the samples.
    pub seed: u32,
    /// Whether single faces of a face set that touch no other face of it join the sets of their neighbours.
    pub clean_islands: bool,
    /// Whether the mesh stores for each vertex the garment's face that it lies on, and the location there.
    pub provenance: bool,
}

impl SimOptions {
    /// The options that remeshing reads; those that transfer alone reads have one value.
    pub(crate) fn without_transfer(&self) -> Self {
        Self { transfer_samples: 0, seed: 0, clean_islands: false, provenance: false, ..self.clone() }
    }

    /// The turn above which a fold is a ridge. \[radians\]
    pub(crate) fn ridge(&self) -> f32 {
        if self.ridge_angle < 180.0 { self.ridge_angle.to_radians() } else { f32::INFINITY }
    }

    /// The turn above which a curve has a corner. \[radians\]
    pub(crate) fn corner(&self) -> f32 {
        if self.corner_angle < 180.0 { self.corner_angle.to_radians() } else { f32::INFINITY }
    }
}

impl Default for SimOptions {
    fn default() -> Self {
        Self {
            min_edge_length: 0.0,
            max_edge_length: 0.0,
            density: String::new(),
            grading: 0.0,
            baseline_level: 2,
            iterations: 5,
            uv_set: "st".into(),
            constrain_uv_seams: true,
            smallest_shell: 4.0,
            constraints: Vec::new(),
            corner_angle: 50.0,
            ridge_angle: 90.0,
            transfer_samples: 32,
            seed: 0,
            clean_islands: false,
            provenance: false,
        }
    }
}
