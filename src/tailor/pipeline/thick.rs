//! Cloth that is modelled with a thickness: closed pieces that are thin.

use crate::codes;
use glam::Vec3;
use std::collections::BTreeMap;
use tailor_mesh::connectivity::{Elements, FaceId, Groups, Topology};
use tailor_mesh::error::Warning;
use tailor_mesh::garment::Mesh;

/// Largest mean thickness of a closed piece that is cloth. \[size of the piece\]
const THIN: f64 = 0.03;

/// The warning of closed pieces that are thin. Both of their sides become cloth.
pub fn thick_cloth(garment: &Mesh) -> Option<Warning> {
    let t = Topology::new(garment.faces.clone(), garment.points.len());
    let mut groups = Groups::<FaceId>::new(t.faces.len());
    for corners in t.edges.ids().flat_map(|edge| t.edge_corners.row(edge).windows(2)) {
        groups.join(t.faces.face_of(corners[0]), t.faces.face_of(corners[1]));
    }
    let mut pieces = BTreeMap::<FaceId, Vec<FaceId>>::new();
    t.faces.ids().for_each(|face| pieces.entry(groups.first(face)).or_default().push(face));
    let pieces = pieces.into_values().filter_map(|faces| Some((thickness(garment, &t, &faces)?, faces)));
    let (thicknesses, faces): (Vec<f64>, Vec<Vec<FaceId>>) = pieces.unzip();
    let thickness = thicknesses.into_iter().reduce(f64::max)?;
    let problem = format!(
        "closed pieces of it are at most {thickness:.3} mesh units thick: both sides become cloth, with twice its mass"
    );
    let remedy = "Export one side without thickness, as CLO does with Thin and Blender without Solidify; the fabric has a thickness";
    let faces = Elements::Faces(faces.into_iter().flatten().collect());
    Some(Warning::new(codes::THICK_CLOTH, &garment.prim, problem).at(faces).remedy(remedy))
}

/// The mean thickness of connected faces, if they are closed and thin. \[mesh units\]
fn thickness(garment: &Mesh, t: &Topology, faces: &[FaceId]) -> Option<f64> {
    let points = || faces.iter().flat_map(|&face| t.faces.vertices_of(face)).map(|&v| garment.points[v]);
    let [low, high] = [Vec3::min, Vec3::max].map(|end| points().reduce(end).unwrap_or_default());
    let (mut volume, mut area) = (0.0, 0.0);
    for &face in faces {
        let (normal, corner) = (garment.doubled_normal(face), garment.points[t.faces.vertices_of(face)[0]]);
        volume += (corner - low).as_dvec3().dot(normal) / 6.0;
        area += normal.length() / 2.0;
    }
    let is_closed = faces.iter().flat_map(|&face| t.faces.corners_of(face)).all(|c| !t.is_border(t.corner_edge[c]));
    let thickness = 2.0 * volume.abs() / area;
    (is_closed && thickness < THIN * f64::from(low.distance(high))).then_some(thickness)
}
