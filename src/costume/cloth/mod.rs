//! The simulation mesh as cloth: fabrics, pins, attachments, and the shape at rest, for solvers that read USD.
//!
//! [`Cloth`] holds numbers in SI units and elements of the simulation mesh; `usd/write/physics` puts them into the names and
//! units of each dialect.

mod doubled;
mod fabric;
mod options;
mod pieces;
mod pins;
mod rest;
mod surface;

pub use fabric::{FABRICS, Fabric};
pub use options::{ClothOptions, DIALECTS, FabricOptions, RestShape};
pub use pieces::Attachment;
pub use pieces::{COVERED, LOOSE_AREA};
use rest::CageStretch;
pub use rest::{Pattern, Rest, RestFigures};

use crate::codes;
use std::collections::BTreeMap;
use surface::Surface;
use tailor::pipeline::RemeshResult;
use tailor_mesh::connectivity::{FaceId, VertexId};
use tailor_mesh::error::{Error, Warning, Warnings};
use tailor_mesh::garment::{Elements, Mesh};

/// A fabric and its name in the recipe.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedFabric {
    /// A preset, or the name of a fabric of the recipe.
    pub name: String,
    /// Its properties.
    pub fabric: Fabric,
}

/// The simulation mesh as cloth.
#[derive(Clone, Debug)]
pub struct Cloth {
    /// The dialects to write.
    pub physics: Vec<String>,
    /// The fabric of the garment, then those of face sets.
    pub fabrics: Vec<NamedFabric>,
    /// The index in `fabrics` of each triangle.
    pub fabric_of: Vec<u32>,
    /// The mean of the fabrics by area.
    pub mean: Fabric,
    /// Whether the warp follows the u axis of the panels, instead of v.
    pub warp_is_u: bool,
    /// The mass of each triangle. \[kg\]
    pub masses: Vec<f64>,
    /// Vertices that are held.
    pub pins: Vec<VertexId>,
    /// Path of the prim that holds them; empty: the world.
    pub pin_target: String,
    /// Loose pieces and where they are attached.
    pub attachments: Vec<Attachment>,
    /// Pairs of triangles that share no vertex and are nearer than the thickness.
    pub doubled: Vec<[FaceId; 2]>,
    /// The shape at rest; none: that of the mesh.
    pub rest: Option<Rest>,
    /// The length of one unit of the UVs; 1 without them. \[mesh units\]
    pub uv_length: f32,
    /// The UV shell of each triangle.
    pub shells: Vec<u32>,
    /// Whether the panels at rest are written as a mesh.
    pub panels: bool,
    /// Whether a `PhysicsScene` is written.
    pub scene: bool,
}

/// The figures of a cloth, for summaries and reports.
#[derive(Clone, Debug, serde::Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct ClothFigures {
    /// Total mass. \[kg\]
    pub mass: f64,
    /// Total area. \[m²\]
    pub area: f64,
    /// Names of the fabrics.
    pub fabrics: Vec<String>,
    /// Vertices that are held.
    pub pinned: usize,
    /// Loose pieces that are attached.
    pub attached: usize,
    /// Pairs of triangles that are nearer than the thickness.
    pub doubled: usize,
    /// The shortest edge. \[m\]
    pub shortest_edge: f64,
    /// Upper bound of the time step of an explicit solver: the smallest altitude of a triangle over the speed of waves in
    /// its fabric. \[s\]
    pub critical_time_step: f64,
    /// The shape at rest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rest: Option<RestFigures>,
}

impl Cloth {
    /// The cloth of the simulation mesh `mesh`, whose triangles are `remeshed`. The garment has the mean edge length `mean_edge`.
    ///
    /// # Errors
    /// A fabric that is not known; `cloth.rest = panels` where the UV panels are not patterns.
    pub fn new(
        options: &ClothOptions,
        fabrics: &BTreeMap<String, FabricOptions>,
        garment: &Mesh,
        remeshed: &RemeshResult,
        mesh: &Mesh,
        pattern: Pattern,
        mean_edge: f32,
    ) -> Result<(Self, Warnings), Error> {
        let mut warnings = Warnings::default();
        let (fabrics, fabric_of) = assigned(options, fabrics, mesh)?;
        let product = &remeshed.product;
        let surface = Surface::new(product, remeshed.topology(), mesh);
        let meters = garment.units.meters();
        let areas: Vec<f64> = surface.triangles().map(|t| surface::area(t) * meters * meters).collect();
        let fabric = |face: usize| fabrics[fabric_of[face] as usize].fabric;
        let mean = Fabric::mean(areas.iter().enumerate().map(|(face, &area)| (fabric(face), area)));
        let masses = areas.iter().enumerate().map(|(face, area)| area * f64::from(fabric(face).density)).collect();
        // Cloth thicker than half of a triangle, as in a stage of the wrong unit, would be near most other cloth, and the pairs
        // more than memory holds.
        let thickness = |face: FaceId| {
            let [a, b, c] = surface.triangle(face);
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            ((f64::from(fabric(face.index()).thickness) / meters) as f32).min(0.5 * longest)
        };
        let attachments = if options.attach { pieces::attachments(&surface, mean_edge) } else { Vec::new() };
        let cage = CageStretch::new(garment, pattern);
        let panels = cage.as_ref().filter(|_| product.baseline.has_uvs);
        let (rest, of_rest) = rest::rest(options.rest, garment, product, &surface, panels, pattern.uv_set)?;
        warnings.extend(of_rest);
        let cloth = Self {
            physics: options.physics.clone(),
            mean: mean.unwrap_or(fabrics[0].fabric),
            warp_is_u: options.warp == "u",
            masses,
            pins: pins::pins(options, garment, product, mesh),
            pin_target: options.pin_target.clone(),
            doubled: doubled::doubled(&surface, thickness),
            attachments,
            rest,
            uv_length: cage.map_or(1.0, |cage| cage.scale as f32),
            shells: surface.shells.clone(),
            panels: options.panels,
            scene: options.scene,
            fabrics,
            fabric_of,
        };
        warnings.extend(cloth.no_pins(options));
        warnings.extend(cloth.no_panels());
        Ok((cloth, warnings))
    }

    /// Its figures on the mesh that it was made of.
    pub fn figures(&self, mesh: &Mesh) -> ClothFigures {
        let meters = mesh.units.meters();
        let mut figures = ClothFigures {
            mass: self.masses.iter().sum(),
            area: 0.0,
            fabrics: self.fabrics.iter().map(|fabric| fabric.name.clone()).collect(),
            pinned: self.pins.len(),
            attached: self.attachments.len(),
            doubled: self.doubled.len(),
            shortest_edge: f64::INFINITY,
            critical_time_step: f64::INFINITY,
            rest: self.rest.as_ref().map(|rest| rest.figures.clone()),
        };
        for (face, &fabric) in mesh.faces.ids().zip(&self.fabric_of) {
            let [a, b, c] = [0, 1, 2].map(|k| mesh.points[mesh.faces.vertices_of(face)[k]].as_dvec3() * meters);
            let mut lengths = [a.distance(b), b.distance(c), c.distance(a)];
            lengths.sort_by(f64::total_cmp);
            let [shortest, _, longest] = lengths;
            let area = 0.5 * (b - a).cross(c - a).length();
            let fabric = self.fabrics[fabric as usize].fabric;
            let speed = f64::from(fabric.stretch_warp.max(fabric.stretch_weft) / fabric.density).sqrt();
            figures.area += area;
            figures.shortest_edge = figures.shortest_edge.min(shortest);
            figures.critical_time_step = figures.critical_time_step.min(2.0 * area / longest / speed);
        }
        figures
    }

    /// An estimate of its memory. \[bytes\]
    pub fn bytes(&self) -> usize {
        /// A triangle's fabric, mass, UV shell, and place at rest.
        const TRIANGLE: usize = 4 + 8 + 4 + 13;
        let rest = self.rest.as_ref().map_or(0, |rest| 12 * rest.points.len());
        TRIANGLE * self.masses.len() + rest + 8 * self.doubled.len()
    }

    /// The warning of panels that are to be written where none is flat.
    fn no_panels(&self) -> Option<Warning> {
        let problem = "the cloth rests as modelled, so there are no panels to write";
        (self.panels && self.rest.is_none()).then(|| {
            Warning::new(codes::NO_PANELS, "cloth.panels", problem)
                .remedy("Lay the UVs out as a sewing pattern, and set cloth.rest to auto")
        })
    }

    /// The warning of pin sets that no vertex of the simulation mesh is in.
    fn no_pins(&self, options: &ClothOptions) -> Option<Warning> {
        let is_empty = self.pins.is_empty() && !options.pins.is_empty();
        let problem = "the sets have no vertex on the simulation mesh, so nothing is held";
        is_empty.then(|| {
            Warning::new(codes::NOTHING_PINNED, "cloth.pins", problem).remedy("Name sets with edges or points of cloth")
        })
    }
}

/// The fabrics of a recipe, that of the garment first, and the index of each triangle's.
fn assigned(
    options: &ClothOptions,
    fabrics: &BTreeMap<String, FabricOptions>,
    mesh: &Mesh,
) -> Result<(Vec<NamedFabric>, Vec<u32>), Error> {
    let named = |name: &str| fabrics.get(name).map(FabricOptions::fabric).or_else(|| Fabric::preset(name));
    let Some(fabric) = named(&options.fabric) else {
        let known: Vec<&str> = FABRICS.iter().copied().chain(fabrics.keys().map(String::as_str)).collect();
        let fault = format!("\"{}\" is not a fabric", options.fabric);
        return Err(Error::recipe("cloth.fabric", fault).remedy(format!("use one of: {}", known.join(", "))));
    };
    let mut all = vec![NamedFabric { name: options.fabric.clone(), fabric }];
    let mut of = vec![0; mesh.faces.len()];
    for (name, options) in fabrics.iter().filter(|(_, options)| !options.faces.is_empty()) {
        for set in options.faces.iter().filter_map(|set| mesh.subset(set)) {
            let Elements::Faces(faces) = &set.elements else { continue };
            faces.iter().for_each(|face| of[face.index()] = all.len() as u32);
        }
        all.push(NamedFabric { name: name.clone(), fabric: options.fabric() });
    }
    Ok((all, of))
}
