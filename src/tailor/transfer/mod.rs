//! Transfer of the garment's attributes to the simulation mesh. Every element has a location on the baseline.
//!
//! | attribute | carried by |
//! |---|---|
//! | vertex and varying primvars, joint influences | the location of each vertex (`vertices`) |
//! | face-varying primvars | the location of each corner, within one shell of the layout (`corners`) |
//! | uniform primvars, face subsets | the areas that faces have in common, by samples ([`Coverage`], `faces`) |
//! | edge subsets, creases | the constraint chains, the borders of face sets, else edge paths along their curves (`edges`) |
//! | point subsets, corners | the nearest vertex on the same chain or part of the surface (`edges`) |
//! | normals of the garment's own faces | normals of the simulation mesh (`normals`) |
//!
//! Data flows one way: `topology` and `coverage` make the `correspondence`; the folders of each kind of element read
//! that; `primvars` and `subsets` choose between them.

mod corners;
mod correspondence;
mod coverage;
mod edges;
mod faces;
mod interpolate;
mod normals;
mod primvars;
mod provenance;
mod subsets;
mod topology;
mod vertices;

pub use coverage::{Coverage, Locator, LocatorTables};
pub use provenance::{SOURCE_COORDS, SOURCE_FACE, corner_coordinates};
pub use subsets::SetCurve;

use crate::sim::SimOptions;
use correspondence::Correspondence;
use subsets::CarriedSubsets;
use tailor_mesh::error::Warnings;
use tailor_mesh::garment::{Mesh, Scheme, SubdivisionRules};

/// A simulation mesh with attributes, and figures of their transfer.
pub struct TransferResult {
    /// The mesh.
    pub mesh: Mesh,
    /// Areas that its faces and the garment's have in common.
    pub coverage: Coverage,
    /// The curves of its edge subsets.
    pub curves: Vec<SetCurve>,
    /// Number of isolated faces that were moved to a neighbour's set.
    pub islands: usize,
}

/// Carries the attributes of `garment` to the simulation mesh of `locator`.
///
/// Warns of what is lost.
pub fn transfer(garment: &Mesh, locator: &Locator<'_>, options: &SimOptions) -> (TransferResult, Warnings) {
    let Locator { product, tables } = *locator;
    let mesh = &tables.mesh;
    let coverage = Coverage::new(locator, options);
    let map = Correspondence::new(product, mesh, &coverage);
    let ((primvars, mut warnings), subsets) = rayon::join(
        || primvars::carry_all(garment, &map, options),
        || subsets::carry_all(garment, &map, locator, options),
    );
    let CarriedSubsets { mut subsets, curves, islands } = warnings.absorb(subsets);
    let uvs = primvars.iter().find(|primvar| primvar.name == options.uv_set && primvar.is_uv_set());
    let families = subsets::add_constraints(garment, &map, uvs, &mut subsets);
    let mesh = Mesh {
        prim: garment.prim.clone(),
        points: product.points.clone(),
        faces: mesh.topology.faces.clone(),
        units: garment.units,
        uv_scales: garment.uv_scales.clone(),
        space: garment.space,
        materials: garment.materials.clone(),
        orientation: garment.orientation,
        rules: SubdivisionRules { scheme: Scheme::None, ..SubdivisionRules::default() },
        holes: Vec::new(),
        creases: Vec::new(),
        corners: Vec::new(),
        primvars: primvars.into(),
        subsets: subsets.into(),
        families,
        influences: None,
        left_out: garment.left_out.clone(),
    };
    (TransferResult { mesh, coverage, curves, islands }, warnings)
}
