//! Normals that are those of the garment's own faces are made again from those of the simulation mesh; others, edited or
//! baked, are carried as directions.

use super::Sites;
use crate::garment::{Garment, Interpolation, Orientation, Primvar, Values};
use crate::mesh::{CornerId, FaceId, Faces, IdVec, VertexId};
use crate::sim::SimProduct;
use glam::Vec3;

/// Cosine of the angle by which normals may differ from those of the faces: programs weigh faces around a point in
/// different ways.
const SAME: f32 = 0.996;

/// The normals of a mesh: of each face, and of each vertex from its faces.
struct Made {
    faces: IdVec<FaceId, Vec3>,
    vertices: IdVec<VertexId, Vec3>,
}

impl Made {
    fn new(faces: &Faces, points: &IdVec<VertexId, Vec3>, orientation: Orientation) -> Self {
        let sign = if orientation == Orientation::LeftHanded { -1.0 } else { 1.0 };
        let mut made = Self { faces: IdVec::new(), vertices: IdVec::filled(Vec3::ZERO, points.len()) };
        for face in faces.ids() {
            let corner = |c: CornerId| points[faces.vertex(c)];
            let origin = corner(CornerId::new(faces.range(face).start));
            let doubled = |c| (corner(c) - origin).cross(corner(faces.next(c)) - origin);
            let normal = sign * faces.corners_of(face).map(doubled).sum::<Vec3>().normalize_or_zero();
            for c in faces.corners_of(face) {
                let (a, b) = (corner(faces.next(c)) - corner(c), corner(faces.prev(c)) - corner(c));
                made.vertices[faces.vertex(c)] += normal * a.angle_between(b).max(0.0);
            }
            made.faces.push(normal);
        }
        made.vertices.iter_mut().for_each(|n| *n = n.normalize_or_zero());
        made
    }

    /// The normal of each element; smooth, or of the faces alone.
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

/// The normals of the simulation mesh from its own faces; none where the garment's came from somewhere else.
pub(super) fn rebuilt(
    garment: &Garment,
    primvar: &Primvar,
    product: &SimProduct,
    sites: &Sites<'_>,
) -> Option<Primvar> {
    let Values::F32(values) = &primvar.values else { return None };
    if !primvar.is_normals() || primvar.width() != 3 || primvar.interpolation == Interpolation::Constant {
        return None;
    }
    let made = Made::new(&garment.faces, &garment.points, garment.orientation);
    let given = |i: usize| Vec3::from_slice(&values[3 * primvar.row(i)..]).normalize_or_zero();
    let is_made = |smooth: &bool| {
        let wanted = made.at(&garment.faces, primvar.interpolation, *smooth);
        // Points without a face have a normal from nowhere.
        wanted.iter().enumerate().all(|(i, n)| *n == Vec3::ZERO || n.dot(given(i)) >= SAME)
    };
    let smooth = [true, false].into_iter().find(is_made)?;
    let faces = &sites.net.topology.faces;
    let own = Made::new(faces, &product.points, garment.orientation).at(faces, primvar.interpolation, smooth);
    let values = Values::F32(own.iter().flat_map(|n| n.to_array()).collect());
    Some(Primvar { values, indices: None, ..primvar.clone() })
}
