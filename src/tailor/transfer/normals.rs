//! Normals of the garment's own faces, recomputed on the simulation mesh. Edited or baked normals are carried as
//! directions.

use super::correspondence::Correspondence;
use glam::Vec3;
use tailor_mesh::connectivity::{CornerId, FaceId, Faces, IdVec, VertexId};
use tailor_mesh::garment::{Interpolation, Mesh, Orientation, Primvar, Values};

/// Cosine of the largest angle between authored and computed normals: programs weigh the faces around a point
/// differently.
const SAME_NORMAL: f32 = 0.996;

/// Unit normals of a mesh; those of vertices weigh faces by their angles.
struct ComputedNormals {
    faces: IdVec<FaceId, Vec3>,
    vertices: IdVec<VertexId, Vec3>,
}

impl ComputedNormals {
    fn new(faces: &Faces, points: &IdVec<VertexId, Vec3>, orientation: Orientation) -> Self {
        let sign = if orientation == Orientation::LeftHanded { -1.0 } else { 1.0 };
        let mut normals = Self { faces: IdVec::new(), vertices: IdVec::filled(Vec3::ZERO, points.len()) };
        for face in faces.ids() {
            let corner = |c: CornerId| points[faces.vertex(c)];
            let origin = corner(CornerId::new(faces.range(face).start));
            let doubled = |c| (corner(c) - origin).cross(corner(faces.next(c)) - origin);
            let normal = sign * faces.corners_of(face).map(doubled).sum::<Vec3>().normalize_or_zero();
            for c in faces.corners_of(face) {
                let (a, b) = (corner(faces.next(c)) - corner(c), corner(faces.prev(c)) - corner(c));
                normals.vertices[faces.vertex(c)] += normal * a.angle_between(b).max(0.0);
            }
            normals.faces.push(normal);
        }
        normals.vertices.iter_mut().for_each(|n| *n = n.normalize_or_zero());
        normals
    }

    /// The normal of each element. Those of corners are the vertices' if `smooth`, else the faces'.
    fn at(&self, faces: &Faces, interpolation: Interpolation, smooth: bool) -> Vec<Vec3> {
        let at_corner = |c: CornerId| match smooth {
            true => self.vertices[faces.vertex(c)],
            false => self.faces[faces.face_of(c)],
        };
        match interpolation {
            Interpolation::Uniform => self.faces.to_vec(),
            Interpolation::Vertex | Interpolation::Varying => self.vertices.to_vec(),
            _ => faces.corners().ids().map(at_corner).collect(),
        }
    }
}

/// The normals of the simulation mesh from its own faces; none if the garment's differ from those of its own faces.
pub(super) fn recomputed(garment: &Mesh, primvar: &Primvar, map: &Correspondence<'_>) -> Option<Primvar> {
    let Values::F32(values) = &primvar.values else { return None };
    if !primvar.is_normals() || primvar.width() != 3 || primvar.interpolation == Interpolation::Constant {
        return None;
    }
    let source = ComputedNormals::new(&garment.faces, &garment.points, garment.orientation);
    let authored = |i: usize| Vec3::from_slice(&values[3 * primvar.row(i)..]).normalize_or_zero();
    let is_computed = |smooth: &bool| {
        let computed = source.at(&garment.faces, primvar.interpolation, *smooth);
        // The normals of points without a face are arbitrary.
        computed.iter().enumerate().all(|(i, n)| *n == Vec3::ZERO || n.dot(authored(i)) >= SAME_NORMAL)
    };
    let smooth = [true, false].into_iter().find(is_computed)?;
    let faces = &map.mesh.topology.faces;
    let own = ComputedNormals::new(faces, &map.product.points, garment.orientation);
    let own = own.at(faces, primvar.interpolation, smooth);
    let values = Values::F32(own.iter().flat_map(|n| n.to_array()).collect());
    Some(Primvar { values, indices: None, ..primvar.clone() })
}
