//! Options of the simulation mesh.

use serde::{Deserialize, Serialize};
use tailor_mesh::error::Error;
use tailor_mesh::options::{Domain, OptionValue, options};

/// Largest length of an edge: longer ones make no coarser mesh. \[sizes of the garment\]
const LARGEST: f32 = 1000.0;
/// A target edge length. 0 stands for half of another length.
const TARGET: Domain = Domain::Length { usual: [0.0, 2.0], automatic: 0.5, automatic_most: None, largest: LARGEST };
/// The turn above which a corner or a feature line stays, usually above `usual`.
const fn angle(usual: f32) -> Domain {
    Domain::Number { least: 1.0, most: Some(180.0), or_zero: false, usual: [usual, 180.0], step: 5.0 }
}

/// The space in which relaxation averages vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Relaxation {
    /// The tangent planes of the surface.
    #[default]
    Surface,
    /// The UV panels.
    Uv,
}

impl OptionValue for Relaxation {}

options! {
    /// Options of the simulation mesh of this garment, with triangles of adaptive size that keep the chosen edges.
    /// Lengths are measured in the mesh's own space.
    "sim" => SimOptions {
        /// Target edge length at density 0, at least minEdgeLength; 0 is half of the mesh's mean edge length
        "maxEdgeLength" max_edge_length: f32 = 0.0, TARGET, "mesh units" via "tailor_mesh::garment::units::deserialize_length";

        /// Target edge length at density 1; half the length gives four times the triangles; 0 is half of maxEdgeLength, or
        /// the same length if no density is painted
        "minEdgeLength" min_edge_length: f32 = 0.0, TARGET, "mesh units" via "tailor_mesh::garment::units::deserialize_length";

        /// Painted vertex primvar, named without `primvars:`, from 0 for maxEdgeLength to 1 for minEdgeLength; a set is 1,
        /// and less on two rings of edges around it; empty is 0 everywhere
        "density" density: String = String::new(), Domain::Weights, "name of a primvar, or a set";

        /// Largest ratio of neighbouring target lengths, 1.05 or more, which shortens the longer one; 0 sets no limit
        "grading" grading: f32 = 0.0,
            Domain::Number { least: 1.05, most: None, or_zero: true, usual: [0.0, 4.0], step: 0.05 }, "factor";

        /// Subdivision level of the surface that the simulation mesh approximates; 0 is the input itself
        "baselineLevel" baseline_level: u32 = 2, Domain::Whole { most: 6, usual: 4 }, "levels";

        /// Face subsets whose details the simulation mesh leaves out: a fair surface through their surroundings replaces them
        "smooth" smooth: Vec<String> = Vec::new(), Domain::Sets { of: &["face"], required: false }, "names of subsets";

        /// Painted vertex primvar, named without `primvars:`, or a set as in density: from 0 for the surface as modelled to 1 for the
        /// fair one of smooth; empty is 0 everywhere
        "smoothWeights" smooth_weights: String = String::new(), Domain::Weights, "name of a primvar, or a set";

        /// Number of rounds of split, collapse, flip and relax; more than 5 improve the triangles little
        "iterations" iterations: u32 = 5, Domain::Whole { most: 100, usual: 10 }, "rounds";

        /// Space in which vertices move to the centroids of their triangles: surface, or uv for the panels of uvSet; uv
        /// gives the triangles the distortion of the panels
        "relax" relax: Relaxation = Relaxation::Surface, Domain::Choice { words: &["surface", "uv"] }, "surface or uv";

        /// Texture coordinates, named without `primvars:`, whose shells are the panels of cloth; empty or absent is one
        /// piece
        "uvSet" uv_set: String = "st".into(), Domain::UvSet, "name of a primvar";

        /// Keep the borders of the shells of uvSet as edges of the simulation mesh, as mesh borders always are
        "constrainUvSeams" constrain_uv_seams: bool = true, Domain::Flag, "true or false";

        /// Size below which the seams of a UV shell are not kept as edges; UVs there are approximate; 0 keeps the seams of
        /// all shells
        "smallestShell" smallest_shell: f32 = 4.0,
            Domain::Number { least: 0.0, most: None, or_zero: true, usual: [0.0, 16.0], step: 0.5 },
            "equilateral triangles of target length";

        /// Give both sides of a mesh with a plane of symmetry the same triangles, one the mirror image of the other, with edges on
        /// the plane; faces without a twin on the other side are remeshed for themselves
        "symmetry" symmetry: bool = false, Domain::Flag, "true or false";

        /// Edge subsets of this mesh to keep as edges of the simulation mesh
        "constraints" constraints: Vec<String> = Vec::new(), Domain::Sets { of: &["edge"], required: false },
            "names of subsets";

        /// Keep a vertex where a seam, border or constraint turns by more than this within one edge length; smaller angles
        /// keep more corners, with shorter edges beside them; 180 keeps none
        "cornerAngle" corner_angle: f32 = 50.0,
            angle(5.0), "degrees";

        /// Keep a line of edges along each turn of the surface by more than this within one target length; smaller angles
        /// keep more lines, with thinner triangles beside them; 180 keeps none
        "featureAngle" feature_angle: f32 = 90.0,
            angle(30.0), "degrees";

        /// Samples of each input face for the transfer of face sets, colours and uniform primvars; more samples resolve
        /// narrower sets, in proportional time
        "transferSamples" transfer_samples: u32 = 32, Domain::Whole { most: 1024, usual: 128 }, "samples per face";

        /// Seed of the transfer samples; the same seed gives the same mesh on any machine and with any number of threads
        "seed" seed: u32 = 0, Domain::Whole { most: u32::MAX, usual: 100 }, "any integer";

        /// Merge single faces of a face set that touch no other face of it into the set around them
        "cleanIslands" clean_islands: bool = false, Domain::Flag, "true or false";

        /// Store the input face of each vertex and its coordinates there, in primvars:tailor:sourceFace and
        /// primvars:tailor:sourceCoords
        "provenance" provenance: bool = false, Domain::Flag, "true or false";

        /// Give the simulation mesh of a fitted garment the triangles that it has on the first body, so that the garment has the
        /// same ones on all bodies
        "asMade" as_made: bool = false, Domain::Flag, "true or false";
    }
}

impl SimOptions {
    /// The options that remeshing reads; those that transfer alone reads have one value.
    pub fn without_transfer(&self) -> Self {
        Self { transfer_samples: 0, seed: 0, clean_islands: false, provenance: false, ..self.clone() }
    }

    /// The turn above which edges of the surface are a feature line. \[radians\]
    pub fn feature_turn(&self) -> f32 {
        if self.feature_angle < 180.0 { self.feature_angle.to_radians() } else { f32::INFINITY }
    }

    /// The turn above which a curve has a corner. \[radians\]
    pub fn corner(&self) -> f32 {
        if self.corner_angle < 180.0 { self.corner_angle.to_radians() } else { f32::INFINITY }
    }

    /// Replaces lengths of 0 by multiples of the garment's mean edge length. \[mesh units\]
    pub fn resolve_targets(&mut self, mean_edge: f32) {
        if self.max_edge_length <= 0.0 {
            self.max_edge_length = (0.5 * mean_edge).max(self.min_edge_length);
        }
        if self.min_edge_length <= 0.0 {
            self.min_edge_length = self.max_edge_length * if self.density.is_empty() { 1.0 } else { 0.5 };
        }
    }

    /// Checks that the shortest target length is not the longer one.
    ///
    /// # Errors
    /// Two values in the other order.
    pub fn check_targets(&self) -> Result<(), Error> {
        let (min, max) = (self.min_edge_length, self.max_edge_length);
        if min > max && max > 0.0 {
            let more = format!("{min} is more than sim.maxEdgeLength, {max}");
            return Err(Error::recipe("sim.minEdgeLength", more).remedy("swap the two values"));
        }
        Ok(())
    }
}
