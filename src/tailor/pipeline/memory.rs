//! How much memory a build needs, from sizes that are known before it.

use super::sim::{expected_faces, surface_level};
use crate::codes;
use crate::recipe::{ResolvedMeshes, ResolvedSim};
use serde::Serialize;
use tailor_mesh::error::Error;
use tailor_mesh::garment::Mesh;
use tailor_mesh::subdivide::refined_faces;

/// Memory of a baseline face: levels, adjacency, stencils, and the search trees over it. All three are
/// from peaks of whole builds of tubes of 10,000 to 1,000,000 quads (`tests/bench/scale.py`), rounded up. \[bytes\]
const BASELINE_FACE: usize = 600;
/// Memory of a triangle of the simulation mesh, while it is remeshed and while its attributes are transferred. \[bytes\]
const TRIANGLE: usize = 700;
/// Memory of a face of the render mesh. \[bytes\]
const RENDER_FACE: usize = 400;
/// Copies of an attribute that a step holds at once: its input, its result and its form in the layer.
const COPIES: usize = 3;

/// An estimate of the most memory that a build holds at once, by what holds it. \[bytes\]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
#[non_exhaustive]
pub struct MemoryEstimate {
    /// The refined garment that the simulation mesh lies on.
    pub baseline: usize,
    /// The simulation mesh.
    pub sim: usize,
    /// The render mesh.
    pub render: usize,
}

impl MemoryEstimate {
    /// The estimate for a resolved recipe.
    pub fn new(garment: &Mesh, ResolvedMeshes { recipe, sim, .. }: &ResolvedMeshes) -> Self {
        let faces = garment.faces.len().max(1);
        let attributes = COPIES * garment.bytes() / faces;
        let expected = expected_faces(garment, sim);
        let render = refined_faces(garment, recipe.render.level);
        Self {
            sim: expected.saturating_mul(TRIANGLE + attributes),
            render: render.saturating_mul(RENDER_FACE + attributes),
            ..Self::surface(garment, sim)
        }
    }

    /// The estimate for that surface alone.
    pub fn surface(garment: &Mesh, sim: &ResolvedSim) -> Self {
        let faces = refined_faces(garment, surface_level(garment, sim));
        Self { baseline: faces.saturating_mul(BASELINE_FACE), sim: 0, render: 0 }
    }

    /// Of two builds whose results are held together.
    #[must_use]
    pub fn with(&self, other: &Self) -> Self {
        Self {
            baseline: self.baseline.saturating_add(other.baseline),
            sim: self.sim.saturating_add(other.sim),
            render: self.render.saturating_add(other.render),
        }
    }

    /// All of it.
    pub fn bytes(&self) -> usize {
        self.baseline.saturating_add(self.sim).saturating_add(self.render)
    }

    /// Refuses a build that needs more than `limit`. \[bytes\]
    ///
    /// # Errors
    /// A build that does, with the option that needs most.
    pub fn check(&self, limit: usize) -> Result<(), Error> {
        if self.bytes() <= limit {
            return Ok(());
        }
        let parts = [
            (self.baseline, "sim.baselineLevel", "lower it"),
            (self.sim, "sim.maxEdgeLength", "raise it, and sim.minEdgeLength"),
            (self.render, "render.level", "lower it"),
        ];
        let largest = parts.into_iter().max_by_key(|(bytes, ..)| *bytes);
        let (bytes, key, remedy) = largest.unwrap_or(parts[0]);
        let fault = format!(
            "the build needs about {} of memory, {} of it for this, and may take {}",
            gigabytes(self.bytes()),
            gigabytes(bytes),
            gigabytes(limit)
        );
        Err(Error::recipe(key, fault)
            .code(codes::TOO_LARGE)
            .remedy(format!("{remedy}, or allow more memory (--max-memory of the command)")))
    }
}

fn gigabytes(bytes: usize) -> String {
    format!("{:.2} GB", bytes as f64 / 1e9)
}
