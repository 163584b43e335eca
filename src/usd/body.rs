//! Bodies in the space of a garment.

use super::read::Source;
use super::shot::StageMetrics;
use glam::DMat4;
use tailor::pipeline::check_extent;
use tailor_mesh::error::{Error, ErrorKind};
use tailor_mesh::garment::{Mesh, Orientation, check_garment};

/// A body as a mesh in the space of a garment: its transform, its unit and its up axis are taken over.
///
/// # Errors
/// Faults of the body's mesh, and a transform of the garment that flattens it.
pub fn body_of(garment: &Source, body: &Source) -> Result<Mesh, Error> {
    // Warnings of a body are about attributes and faces that no garment gets.
    let (mut mesh, _) = check_garment(body.garment()?.0)?;
    let to_garment = stage_to_garment(garment, body) * body.model.transforms.to_world;
    let turns = to_garment.determinant();
    if !to_garment.is_finite() || turns == 0.0 {
        let flat = if garment.model.transforms.to_world.determinant() == 0.0 { garment } else { body };
        let fault = Error::new(ErrorKind::Usd, flat.prim(), "it has a transform that flattens it");
        return Err(fault.code(tailor::codes::MESH_SIZE).remedy("give it scales that are not 0"));
    }
    // Two bodies often have one path.
    mesh.prim = format!("{} {}", body.file().display(), body.prim());
    let is_left_handed = (mesh.orientation == Orientation::LeftHanded) != (turns < 0.0);
    mesh.orientation = if is_left_handed { Orientation::LeftHanded } else { Orientation::RightHanded };
    for point in mesh.points.iter_mut() {
        *point = to_garment.transform_point3(point.as_dvec3()).as_vec3();
    }
    check_extent(&mesh)?;
    Ok(mesh)
}

/// From the space of a body's stage to that of a garment: their up axes and units count as far as both stages state them.
pub fn stage_to_garment(garment: &Source, body: &Source) -> DMat4 {
    let [from, to] = [body, garment].map(|source| StageMetrics::of(&source.model.stage_metadata));
    garment.model.transforms.to_world.inverse() * from.to(to)
}
