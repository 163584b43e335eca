//! Checks of a mesh and of sizes that need more than single attributes.

use crate::codes;
use crate::recipe::MeshRecipe;
use crate::sim::{holes, mean_edge_length};
use std::ops::RangeInclusive;
use tailor_mesh::error::{Error, ErrorKind};
use tailor_mesh::garment::{BoundaryInterpolation, Mesh};
use tailor_mesh::subdivide::{Level, MAX_REFINED_FACES, refined_faces};

/// Mean edge lengths whose squares, and ratios of squares, stay within 32 bits. \[mesh units\]
const USABLE_LENGTHS: RangeInclusive<f32> = 1e-8..=1e8;

/// The mean edge length of a mesh that is a surface to compute with: faces with an area, in numbers that can be squared.
/// \[mesh units\]
///
/// # Errors
/// Points in one place, or of another size, and faces without an area.
pub fn check_extent(garment: &Mesh) -> Result<f32, Error> {
    let fault = |fault: String, remedy: &str| {
        Err(Error::new(ErrorKind::Mesh, format!("{}.points", garment.prim), fault).remedy(remedy))
    };
    let mean_edge = mean_edge_length(garment);
    let mut points = garment.faces.corners().iter().map(|&v| garment.points[v]);
    let first = points.next();
    if points.all(|p| Some(p) == first) {
        let fault_text = "the edges have no length: all points are in one place";
        return fault(fault_text.into(), "give the points their positions");
    }
    if !USABLE_LENGTHS.contains(&mean_edge) {
        let remedy = "scale the points, and metersPerUnit with them, so that a garment measures 0.1 to 1000 units";
        let fault_text = format!("the mean edge length is {mean_edge:e}, too far from 1 to compute with");
        return fault(fault_text, remedy).map_err(|error: Error| error.code(codes::MESH_SIZE));
    }
    if garment.faces.ids().all(|f| garment.doubled_normal(f).length() == 0.0) {
        return fault("no face has an area".into(), "give the points their positions");
    }
    Ok(mean_edge)
}

/// Checks that faces of the mesh are drawn.
pub fn drawn(garment: &Mesh) -> Result<(), Error> {
    let has_holes = !garment.holes.is_empty() || garment.rules.boundary == BoundaryInterpolation::None;
    if has_holes && holes(garment, &Level::base(garment)).iter().all(|&h| h) {
        let fault_text = "no face is left: all are holes, or at a border with interpolateBoundary \"none\"";
        let remedy = "take faces out of holeIndices, or set interpolateBoundary to edgeAndCorner";
        let place = format!("{}.holeIndices", garment.prim);
        return Err(Error::new(ErrorKind::Mesh, place, fault_text).remedy(remedy));
    }
    Ok(())
}

/// Checks that the refined meshes fit in memory.
pub fn levels(garment: &Mesh, recipe: &MeshRecipe) -> Result<(), Error> {
    for (key, level) in [("sim.baselineLevel", recipe.sim.baseline_level), ("render.level", recipe.render.level)] {
        let faces = refined_faces(garment, level);
        if faces > MAX_REFINED_FACES && level > 0 {
            let fault = format!("level {level} makes {faces} faces, more than {MAX_REFINED_FACES}");
            return Err(Error::recipe(key, fault).code(codes::TOO_LARGE).remedy("lower the level"));
        }
    }
    Ok(())
}
