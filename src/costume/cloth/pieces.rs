//! Loose pieces, such as pockets, flaps and buttons, and where they are attached to the cloth that they lie on.

use super::surface::{Surface, area, boxes};
use glam::Vec3;
use std::cell::Cell;
use tailor::contact::{NearestSearch, Range};
use tailor::sim::closest_weights;
use tailor_mesh::connectivity::{FaceId, VertexId};

/// Largest area of a loose piece, as a share of the piece that it lies on. Larger ones are garments of their own.
pub const LOOSE_AREA: f64 = 0.25;
/// Triangles near a point of a piece that are looked at. More are a crowd in one place.
const MOST_BELOW: usize = 1 << 14;
/// Largest cost of a triangle for each unit of its distance.
const COST: f32 = 2.0;
/// Share of a piece's seam that has to have cloth below it.
pub const COVERED: f64 = 0.6;

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
    let areas = areas(surface);
    let held = held(surface, areas.len());
    let cloth = Cloth::new(surface, &areas, reach);
    held.iter().enumerate().filter_map(|(piece, points)| attachment(&cloth, piece, points)).collect()
}

/// The area of each piece.
fn areas(surface: &Surface<'_>) -> Vec<f64> {
    let count = surface.pieces.iter().max().map_or(0, |last| *last as usize + 1);
    let mut areas = vec![0.0; count];
    for (triangle, &piece) in surface.triangles().zip(&surface.pieces) {
        areas[piece as usize] += area(triangle);
    }
    areas
}

/// The vertices by which each of `count` pieces would be held: those of its border, or all of a closed piece.
fn held(surface: &Surface<'_>, count: usize) -> Vec<Vec<VertexId>> {
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
    held
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

/// The triangles that loose pieces may lie on.
struct Cloth<'a> {
    surface: &'a Surface<'a>,
    /// The area of each piece.
    areas: &'a [f64],
    search: NearestSearch,
    /// The area of the largest piece in each node of the search.
    largest: Vec<Vec<f64>>,
    reach: f32,
    /// Most that a cost is off by rounding.
    error: f64,
}

/// The triangle below a vertex.
struct Below {
    face: FaceId,
    weights: Vec3,
    cost: f32,
}

impl<'a> Cloth<'a> {
    fn new(surface: &'a Surface<'a>, areas: &'a [f64], reach: f32) -> Self {
        let area = |face: usize| areas[surface.pieces[face] as usize];
        // Pieces that cannot lie on each other, as a piece on itself, are in one group, and are passed over together.
        let group = |face: usize| area(face).to_bits() >> (f64::MANTISSA_DIGITS - 1) >> 1;
        let search = NearestSearch::grouped(&boxes(surface.mesh), group);
        let largest = search.largest(area);
        let farthest = surface.mesh.points.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
        let error = 64.0 * f64::from(f32::EPSILON) * f64::from(farthest + reach);
        Self { surface, areas, search, largest, reach, error }
    }

    /// The triangle of a larger piece that is nearest to a vertex of `piece` along its normal, the lowest of equals, and how many
    /// were looked at.
    fn below(&self, piece: usize, vertex: VertexId) -> (Option<Below>, usize) {
        let (surface, area) = (self.surface, self.areas[piece]);
        let (point, normal) = (surface.mesh.points[vertex], surface.normal(vertex));
        let at = |face: usize| below(surface, point, normal, FaceId::new(face), self.reach);
        let holds = |of: f64| area <= LOOSE_AREA * of;
        let looked_at = Cell::new(0);
        let range = Range { reach: f64::from(COST * self.reach), error: self.error };
        let admits = |height: usize, node: usize| looked_at.get() < MOST_BELOW && holds(self.largest[height - 1][node]);
        let cost = |face: usize, _| {
            looked_at.set(looked_at.get() + 1);
            let is_below = holds(self.areas[surface.pieces[face] as usize]);
            let found = if is_below { at(face) } else { None };
            found.map_or(f64::INFINITY, |found| f64::from(found.cost).powi(2))
        };
        let nearest = self.search.nearest_within(point, range, admits, cost);
        (nearest.and_then(at), looked_at.get())
    }
}

fn attachment(cloth: &Cloth<'_>, piece: usize, points: &[VertexId]) -> Option<Attachment> {
    let surface = cloth.surface;
    let mut attachment = Attachment { points: Vec::new(), faces: Vec::new(), coords: Vec::new() };
    for &vertex in points {
        let Some(below) = cloth.below(piece, vertex).0 else { continue };
        let [a, b, c] = surface.triangle(below.face);
        let facing = (b - a).cross(c - a).normalize_or_zero();
        attachment.points.push(vertex);
        attachment.faces.push(below.face);
        let height = (surface.mesh.points[vertex] - a).dot(facing);
        attachment.coords.push(Vec3::new(below.weights.x, below.weights.y, height));
    }
    let covered = attachment.points.len() as f64 / points.len().max(1) as f64;
    (covered >= COVERED).then_some(attachment)
}

/// The nearest point of a triangle, if it is within `reach`. Its cost is the distance, longer where it lies aside of the normal.
fn below(surface: &Surface<'_>, point: Vec3, normal: Vec3, face: FaceId, reach: f32) -> Option<Below> {
    let [a, b, c] = surface.triangle(face);
    let weights = closest_weights(a, b, c, point);
    let place = a * weights.x + b * weights.y + c * weights.z;
    let distance = place.distance(point);
    let cost = distance + (place - point).reject_from_normalized(normal).length();
    (distance <= reach).then_some(Below { face, weights, cost })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Builder, Recipe};
    use tailor_mesh::Garment;
    use tailor_testing::sheets::{grid_faces, mesh};

    /// A closed box on a sheet, or without it.
    fn on_sheet(has_sheet: bool) -> Garment {
        let corners = (0..8).map(|i| [(i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32]);
        let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let sheet = (0..36).map(|i| [2.0 * (i % 6) as f32 - 5.0, 2.0 * (i / 6) as f32 - 5.0, 0.05]);
        let mut faces: Vec<Vec<i32>> = sides.iter().map(|side| side.to_vec()).collect();
        if has_sheet {
            faces.extend(grid_faces(5, 5, |_, _| true).iter().map(|face| face.iter().map(|v| v + 8).collect()));
        }
        let faces: Vec<&[i32]> = faces.iter().map(Vec::as_slice).collect();
        mesh(corners.chain(sheet).take(if has_sheet { 44 } else { 8 }), &faces)
    }

    /// The triangles that are looked at for all vertices that may be held, and their number.
    fn work(has_sheet: bool, length: f32) -> (usize, usize) {
        let mut recipe = Recipe::default();
        recipe.sim.max_edge_length = length;
        recipe.cloth.physics.clear();
        let mut builder = Builder::new(on_sheet(has_sheet)).expect("a good mesh");
        let products = builder.update(&recipe).expect("a good recipe");
        let remeshed = &products.simulated.remeshed;
        let surface = Surface::new(&remeshed.product, remeshed.topology(), &products.sim);
        let areas = areas(&surface);
        let held = held(&surface, areas.len());
        let cloth = Cloth::new(&surface, &areas, 1.0);
        let looked_at = |(piece, points): (usize, &Vec<VertexId>)| -> usize {
            points.iter().map(|&vertex| cloth.below(piece, vertex).1).sum()
        };
        (held.iter().enumerate().map(looked_at).sum(), held.iter().map(Vec::len).sum())
    }

    #[test]
    fn no_triangle_is_looked_at_where_no_piece_is_larger() {
        assert_eq!(work(false, 0.1).0, 0);
    }

    #[test]
    fn few_triangles_are_looked_at_for_a_vertex() {
        // Costs are up to twice the distance, so the upper vertices look at what is within twice the height of the box.
        let (looked_at, vertices) = work(true, 0.2);
        assert!(looked_at > 0 && looked_at < 300 * vertices, "{looked_at} for {vertices}");
    }
}
