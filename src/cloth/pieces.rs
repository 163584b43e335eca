//! Loose pieces, such as pockets, flaps and buttons, and where they are attached to the cloth that they lie on.

use super::surface::{Near, Surface, area};
use crate::mesh::{FaceId, VertexId};
use glam::Vec3;

/// Largest area of a loose piece, as a share of the piece that it lies on. Larger ones are garments of their own.
const LOOSE_AREA: f64 = 0.25;
/// Triangles near a point of a piece that are looked at. More are a crowd in one place.
const MOST_BELOW: usize = 1 << 14;
/// Share of a piece's seam that has to have cloth below it.
const COVERED: f64 = 0.6;

/// A loose piece, attached to the cloth below it.
#[derive(Clone, Debug, PartialEq)]
pub struct Attachment {
    /// The vertices that are held: those of its border, or all of a closed piece.
    pub points: Vec<VertexId>,
    /// The triangle that holds each.
    pub faces: Vec<FaceId>,
    /// Where on that triangle: weights of its first and second corner, and the height over it. \[-, -, mesh units\]
    pub coords: Vec<Vec3>,
}

/// The loose pieces of a mesh. A piece lies on the larger one that is nearest along its normals, within `reach`. \[mesh units\]
pub fn attachments(surface: &Surface<'_>, reach: f32) -> Vec<Attachment> {
    let count = surface.pieces.iter().max().map_or(0, |last| *last as usize + 1);
    let mut areas = vec![0.0; count];
    for (triangle, &piece) in surface.triangles().zip(&surface.pieces) {
        areas[piece as usize] += area(triangle);
    }
    let mut held: Vec<Vec<VertexId>> = vec![Vec::new(); count];
    let mut has_border = vec![false; count];
    let on_border = borders(surface);
    for (vertex, &border) in surface.mesh.points.ids().zip(&on_border) {
        let Some(face) = surface.topology.faces_at(vertex).next() else { continue };
        let piece = surface.pieces[face.index()] as usize;
        if border && !has_border[piece] {
            has_border[piece] = true;
            held[piece].clear();
        }
        if border || !has_border[piece] {
            held[piece].push(vertex);
        }
    }
    held.iter().enumerate().filter_map(|(piece, points)| attachment(surface, reach, &areas, piece, points)).collect()
}

/// Whether each vertex is on a border.
fn borders(surface: &Surface<'_>) -> Vec<bool> {
    let mut on_border = vec![false; surface.mesh.points.len()];
    for (edge, ends) in surface.topology.edges.enumerated() {
        if surface.topology.is_border(edge) {
            ends.iter().for_each(|v| on_border[v.index()] = true);
        }
    }
    on_border
}

fn attachment(
    surface: &Surface<'_>,
    reach: f32,
    areas: &[f64],
    piece: usize,
    points: &[VertexId],
) -> Option<Attachment> {
    let is_below = |face: FaceId| areas[piece] <= LOOSE_AREA * areas[surface.pieces[face.index()] as usize];
    let mut attachment = Attachment { points: Vec::new(), faces: Vec::new(), coords: Vec::new() };
    for &vertex in points {
        let (point, normal) = (surface.mesh.points[vertex], surface.normal(vertex));
        let near = surface.near(point, reach, MOST_BELOW, is_below);
        let Some(below) =
            near.iter().min_by(|a, b| cost(surface, point, normal, a).total_cmp(&cost(surface, point, normal, b)))
        else {
            continue;
        };
        let [a, b, c] = surface.triangle(below.face);
        let facing = (b - a).cross(c - a).normalize_or_zero();
        attachment.points.push(vertex);
        attachment.faces.push(below.face);
        attachment.coords.push(Vec3::new(below.weights.x, below.weights.y, (point - a).dot(facing)));
    }
    let covered = attachment.points.len() as f64 / points.len().max(1) as f64;
    (covered >= COVERED).then_some(attachment)
}

/// The distance of a near point, longer where it lies aside of the normal.
fn cost(surface: &Surface<'_>, point: Vec3, normal: Vec3, near: &Near) -> f32 {
    let [a, b, c] = surface.triangle(near.face);
    let to = a * near.weights.x + b * near.weights.y + c * near.weights.z - point;
    near.distance + to.reject_from_normalized(normal).length()
}
