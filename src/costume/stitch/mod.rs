//! Stitches: threads along edge sets and seams of the render mesh, on its limit surface.
//!
//! A line at a distance from edges ([`LimitSurface::lines`]) is a path by its length (`path`). It has holes at equal lengths from
//! corner to corner, and between them the points of its kind (`pattern`). Points beside the line are put down on the surface
//! (`ground`), so that wide kinds follow it. Threads are curves that are bound to the simulation mesh as trims are.

mod ground;
mod options;
mod path;
mod pattern;
mod threads;

pub use options::{StitchKind, StitchOptions};
pub use threads::Threads;

use crate::binding::{BindSurface, Binding};
use crate::codes;
use crate::trim::{TrimMode, TrimShape};
use ground::Ground;
use path::SurfacePath;
use std::collections::BTreeMap;
use tailor::SeamOptions;
use tailor::render::LimitSurface;
use tailor_mesh::connectivity::VertexId;
use tailor_mesh::error::Error;
use tailor_mesh::garment::{Elements, Mesh};
use threads::StitchSizes;

/// A stitch that is sewn.
#[derive(Clone, Debug, PartialEq)]
pub struct Stitch {
    /// Its threads.
    pub threads: Threads,
    /// Diameter of the thread. \[mesh units\]
    pub thread: f32,
    /// Path of its material, or empty.
    pub material: String,
    /// The places of its points on the simulation mesh.
    pub binding: Binding,
}

/// The stitches on a render mesh, by name, bound to a simulation mesh of the same garment. The options are resolved for it.
pub fn sew(render: &Mesh, sim: &Mesh, options: &BTreeMap<String, StitchOptions>) -> BTreeMap<String, Stitch> {
    let surface = LimitSurface::new(render);
    let (ground, cloth) = (Ground::new(render, &surface), BindSurface::new(sim));
    let stitch = |options: &StitchOptions| {
        let threads = options.threads(render, &surface, &ground);
        let counts = threads.counts.iter().map(|&count| count as usize);
        let shape = TrimShape::of_parts(threads.points.clone(), counts);
        let binding = shape.bound(TrimMode::Soft, &cloth, sim.size()).0;
        Stitch { threads, thread: options.thread, material: options.material.clone(), binding }
    };
    let enabled = options.iter().filter(|(_, options)| options.enabled);
    enabled.map(|(name, options)| (name.clone(), stitch(options))).collect()
}

/// Gives stitches that go along a seam its edges.
///
/// # Errors
/// A seam that is not there; a stitch along nothing, or along two things.
pub fn follow_seams(
    stitches: &mut BTreeMap<String, StitchOptions>,
    seams: &BTreeMap<String, SeamOptions>,
) -> Result<(), Error> {
    for (name, stitch) in stitches.iter_mut().filter(|(_, stitch)| stitch.enabled) {
        let fault =
            |key: &str, text: String| Error::recipe(format!("stitch.{name}.{key}"), text).code(codes::STITCH_LINE);
        if stitch.along.is_empty() == stitch.edges.is_empty() {
            let text = if stitch.along.is_empty() { "it has no line" } else { "it has edges and a seam" };
            return Err(fault("edges", text.to_owned()).remedy("name edge subsets, or a seam by `along`"));
        }
        if !stitch.along.is_empty() {
            let seam = stitch.along.strip_prefix("seam.").and_then(|seam| seams.get(seam));
            let seam = seam.ok_or_else(|| {
                let known: Vec<String> = seams.keys().map(|seam| format!("seam.{seam}")).collect();
                let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
                fault("along", format!("`{}` is not a seam of the recipe", stitch.along))
                    .remedy(format!("its seams are: {known}"))
            })?;
            stitch.edges.clone_from(&seam.edges);
        }
    }
    Ok(())
}

impl StitchOptions {
    fn threads(&self, render: &Mesh, surface: &LimitSurface, ground: &Ground) -> Threads {
        let pattern = self.kind.pattern();
        let meters = render.units.meters() as f32;
        let per_centimetre = if self.per_centimetre > 0.0 { self.per_centimetre } else { pattern.per_centimetre };
        let width = if self.width > 0.0 { self.width } else { pattern.width / meters };
        let tacks = matches!(self.kind, StitchKind::Lockstitch | StitchKind::Zigzag);
        let sizes = StitchSizes {
            stitch: 0.01 / meters / per_centimetre,
            width,
            thread: self.thread,
            tension: self.tension,
            back_tack: if tacks { self.back_tack } else { 0 },
        };
        let lines = surface.lines(self.edges_of(render), self.side, &self.distances());
        let mut threads = Threads::default();
        for line in lines.iter().filter(|line| line.points.len() > 1) {
            threads.sew(&SurfacePath::new(line, surface), &pattern, sizes, ground);
        }
        threads
    }

    /// The edges that it follows on a render mesh.
    fn edges_of(&self, render: &Mesh) -> Vec<[VertexId; 2]> {
        let sets = self.edges.iter().filter_map(|name| render.subset(name));
        let edges = sets.filter_map(|set| if let Elements::Edges(edges) = &set.elements { Some(edges) } else { None });
        edges.flatten().copied().collect()
    }
}
