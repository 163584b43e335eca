//! The stretch of a mesh against its UVs, as symmetric matrices in the axes of the UVs.

use glam::{DMat2, DVec2, DVec3, Vec3};
use tailor::sim::made_points;
use tailor_mesh::connectivity::{CornerId, FaceId, Faces, IdVec, VertexId};
use tailor_mesh::garment::{Interpolation, Mesh, Primvar, Values};

/// Least stretch that is undone; a face whose UVs are flat the other way rests as modelled.
const LEAST_STRETCH: f64 = 0.2;
/// Largest stretch that is undone.
const MOST_STRETCH: f64 = 5.0;

/// The stretch of a cage.
pub struct CageStretch {
    /// Length of one UV unit. \[mesh units\]
    pub scale: f64,
    /// The stretch of each face as it was made; the identity where it has none.
    pub made: IdVec<FaceId, DMat2>,
    /// The stretch of each face that panels have not at rest: that as it was made, or all that it has.
    pub undone: IdVec<FaceId, DMat2>,
}

/// The UV set whose shells are panels.
#[derive(Clone, Copy, Debug)]
pub struct Pattern<'a> {
    /// Its name.
    pub uv_set: &'a str,
    /// Whether the panels of a fitted garment are those that it was made with, and not graded to its body.
    pub is_kept: bool,
}

impl CageStretch {
    /// The stretch of a garment against its UV set; `None` without one. That of a fitted garment is from before the fit, so that its
    /// panels are graded to the other body, unless they are kept.
    pub fn new(garment: &Mesh, Pattern { uv_set, is_kept }: Pattern) -> Option<Self> {
        let primvar = garment.primvar(uv_set)?;
        let Values::F32(values) = &primvar.values else { return None };
        if primvar.interpolation != Interpolation::FaceVarying || primvar.width() != 2 {
            return None;
        }
        let uv = |corner: CornerId| uv_at(primvar, values, corner);
        let points = made_points(garment);
        let scale =
            garment.uv_scales.get(uv_set).copied().map_or_else(|| by_area(&garment.faces, &points, &uv), f64::from);
        if !(scale.is_finite() && scale > 0.0) {
            return None;
        }
        let uv = |corner| uv(corner) * scale;
        let stretch = |points: &IdVec<VertexId, Vec3>| -> IdVec<FaceId, DMat2> {
            garment.faces.ids().map(|face| face_stretch(&garment.faces, points, face, &uv)).collect()
        };
        let made = stretch(&points);
        let undone = if is_kept { stretch(&garment.points) } else { made.clone() };
        Some(Self { scale, made, undone })
    }
}

fn uv_at(primvar: &Primvar, values: &[f32], corner: CornerId) -> DVec2 {
    let row = primvar.row(corner.index());
    DVec2::new(f64::from(values[2 * row]), f64::from(values[2 * row + 1]))
}

/// The length of one UV unit by the areas of all faces.
fn by_area(faces: &Faces, points: &IdVec<VertexId, Vec3>, uv: &impl Fn(CornerId) -> DVec2) -> f64 {
    let (mut area, mut of_uvs) = (0.0, 0.0);
    for face in faces.ids() {
        let corners: Vec<CornerId> = faces.corners_of(face).collect();
        let at = |k: usize| points[faces.vertex(corners[k])].as_dvec3();
        let flat = |k: usize| uv(corners[k]);
        let fan = 1..corners.len() - 1;
        area += fan.clone().map(|k| (at(k) - at(0)).cross(at(k + 1) - at(0))).sum::<DVec3>().length();
        of_uvs += fan.map(|k| (flat(k) - flat(0)).perp_dot(flat(k + 1) - flat(0))).sum::<f64>().abs();
    }
    (area / of_uvs).sqrt()
}

/// The stretch of a face: that of the linear map from UVs to space with the least squares.
fn face_stretch(faces: &Faces, points: &IdVec<VertexId, Vec3>, face: FaceId, uv: &impl Fn(CornerId) -> DVec2) -> DMat2 {
    let corners = faces.corners_of(face);
    let count = corners.len() as f64;
    let point = |c: CornerId| points[faces.vertex(c)].as_dvec3();
    let (centre, flat) =
        (corners.clone().map(point).sum::<DVec3>() / count, corners.clone().map(uv).sum::<DVec2>() / count);
    let (mut squares, mut along) = (DMat2::ZERO, [DVec3::ZERO; 2]);
    for corner in corners {
        let (p, q) = (point(corner) - centre, uv(corner) - flat);
        squares += DMat2::from_cols(q * q.x, q * q.y);
        along[0] += p * q.x;
        along[1] += p * q.y;
    }
    let inverse = squares.inverse();
    let columns = [0, 1].map(|k| along[0] * inverse.col(k).x + along[1] * inverse.col(k).y);
    stretch_of(columns)
}

/// The symmetric part of a linear map from the plane to space, given by its columns. The identity where it is degenerate.
fn stretch_of([u, v]: [DVec3; 2]) -> DMat2 {
    let metric = DMat2::from_cols_array(&[u.dot(u), u.dot(v), u.dot(v), v.dot(v)]);
    let stretch = root(metric);
    let [least, most] = eigenvalues(stretch);
    if least >= LEAST_STRETCH && most <= MOST_STRETCH { stretch } else { DMat2::IDENTITY }
}

/// The root of a symmetric positive matrix.
pub fn root(m: DMat2) -> DMat2 {
    let s = m.determinant().max(0.0).sqrt();
    let t = (m.x_axis.x + m.y_axis.y + 2.0 * s).sqrt();
    (m + DMat2::from_diagonal(DVec2::splat(s))) * (1.0 / t)
}

/// The eigenvalues of a symmetric matrix, the smaller first.
pub fn eigenvalues(m: DMat2) -> [f64; 2] {
    let mean = 0.5 * (m.x_axis.x + m.y_axis.y);
    let apart = (mean * mean - m.determinant()).max(0.0).sqrt();
    [mean - apart, mean + apart]
}

/// Root mean square of the principal stretches less 1, over some stretches with weights.
pub fn root_mean_square(parts: &[(DMat2, f64)]) -> f64 {
    let (mut sum, mut weight) = (0.0, 0.0);
    for &(stretch, w) in parts {
        let [a, b] = eigenvalues(stretch);
        sum += w * 0.5 * ((a - 1.0) * (a - 1.0) + (b - 1.0) * (b - 1.0));
        weight += w;
    }
    if weight > 0.0 { (sum / weight).sqrt() } else { 0.0 }
}

/// The edges of a triangle at rest, in the axes of its UVs: as long as in space, less the cage's stretch. `side` is the sign
/// of the shell's UV area.
pub fn target_edges(triangle: [Vec3; 3], uvs: [DVec2; 3], cage: DMat2, side: f64) -> [DVec2; 3] {
    let [a, b, c] = triangle.map(|p| p.as_dvec3());
    let unstretched = cage.inverse();
    let flat = DMat2::from_cols(uvs[1] - uvs[0], uvs[2] - uvs[0]);
    let sizes = (b - a).length() * (c - a).length();
    let edges = if flat.determinant() * side > 1e-6 * sizes {
        let inverse = flat.inverse();
        let column = |k: usize| (b - a) * inverse.col(k).x + (c - a) * inverse.col(k).y;
        let [u, v] = [column(0), column(1)];
        let own = root(DMat2::from_cols_array(&[u.dot(u), u.dot(v), u.dot(v), v.dot(v)]));
        [0, 1, 2].map(|k| own * (uvs[(k + 1) % 3] - uvs[k]))
    } else {
        laid_flat([a, b, c], side)
    };
    edges.map(|edge| unstretched * edge)
}

/// The edges of a triangle in the plane, the first along x; without orientation by UVs.
fn laid_flat([a, b, c]: [DVec3; 3], side: f64) -> [DVec2; 3] {
    let x = (b - a).normalize_or_zero();
    let along = (c - a).dot(x);
    let [first, third] = [DVec2::new((b - a).length(), 0.0), DVec2::new(along, side * (c - a - x * along).length())];
    [first, third - first, -third]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_of_a_metric_is_its_stretch() {
        let stretch = stretch_of([DVec3::new(2.0, 0.0, 0.0), DVec3::new(0.0, 0.0, 0.5)]);
        assert!((stretch.x_axis.x - 2.0).abs() < 1e-12 && (stretch.y_axis.y - 0.5).abs() < 1e-12);
        assert!((root_mean_square(&[(stretch, 3.0)]) - (0.625f64).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_triangle_rests_as_long_as_it_is_less_the_stretch_of_the_cage() {
        let triangle = [Vec3::ZERO, Vec3::new(0.0, 2.2, 0.0), Vec3::new(0.0, 0.0, 1.0)];
        let uvs = [DVec2::ZERO, DVec2::new(2.0, 0.0), DVec2::new(0.0, 1.0)];
        let [first, _, third] = target_edges(triangle, uvs, DMat2::from_diagonal(DVec2::new(1.1, 1.0)), 1.0);
        assert!(first.distance(DVec2::new(2.0, 0.0)) < 1e-6 && third.distance(DVec2::new(0.0, -1.0)) < 1e-6);
        // Without area in UVs the triangle is laid flat.
        let [first, second, third] = target_edges(triangle, [DVec2::ZERO; 3], DMat2::IDENTITY, 1.0);
        assert!((first + second + third).length() < 1e-9 && (first.length() - 2.2).abs() < 1e-6);
        assert!(first.perp_dot(second) > 0.0);
    }
}
