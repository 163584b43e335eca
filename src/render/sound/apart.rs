//! What parts children of a skin that cross: a plane that parted them where they did not.

use super::close::ChildOf;
use super::skin::{Skin, place};
use super::untangle::{Apart, Row, add_row};
use crate::mesh::{FaceId, IdVec, VertexId};
use glam::Vec3;

/// How far what crossed is to be apart, as a part of the size of the faces there.
const APART: f32 = 5e-3;

/// What parts faces of a skin that cross: the planes that part their children where the points of the cage are `parted`.
pub fn apart_now(skin: &Skin, parted: &IdVec<VertexId, Vec3>, pairs: &[[FaceId; 2]]) -> Vec<Apart> {
    let quad = |child: ChildOf| {
        let vertices = skin.child_vertices(child);
        Quad { points: vertices.map(|v| place(&skin.rows, v, parted)), vertices }
    };
    let row = |vertex: VertexId| {
        let mut row = Row::new();
        add_row(&mut row, &skin.rows, vertex, 1.0);
        row
    };
    let crossing = pairs.iter().flat_map(|&[f, g]| skin.crossing_children(f, g));
    let apart = |[a, b]: [ChildOf; 2]| on_two_sides(skin, [a, b], separating_axis(&quad(a), &quad(b)), row);
    crossing.flat_map(apart).collect()
}

/// That two children of a skin are on two sides along an axis, but for what they have in common. `row` is what a vertex of
/// theirs is made of.
pub fn on_two_sides(skin: &Skin, pair: [ChildOf; 2], axis: Vec3, row: impl Fn(VertexId) -> Row) -> Vec<Apart> {
    let [over, under] = pair.map(|child| skin.child_vertices(child));
    let quad = skin.child_quad(pair[0]);
    let gap = APART * quad[0].distance(quad[2]);
    let rows = |vertices: &mut dyn Iterator<Item = VertexId>| vertices.map(&row).collect();
    let common: Vec<VertexId> = over.into_iter().filter(|v| under.contains(v)).collect();
    let own = |all: [VertexId; 4]| rows(&mut all.into_iter().filter(|v| !common.contains(v)));
    let apart = |over: Vec<Row>, under: Vec<Row>| Apart { over, under, axis, gap };
    if common.is_empty() {
        return vec![apart(own(over), own(under))];
    }
    let common = || rows(&mut common.iter().copied());
    vec![apart(own(over), common()), apart(common(), own(under))]
}

/// A face of the first refinement.
pub struct Quad {
    pub points: [Vec3; 4],
    pub vertices: [VertexId; 4],
}

impl Quad {
    fn edges(&self) -> [Vec3; 4] {
        [0, 1, 2, 3].map(|i| self.points[(i + 1) % 4] - self.points[i])
    }

    fn normal(&self) -> Vec3 {
        let [a, b, c, d] = self.points;
        (c - a).cross(d - b)
    }

    /// The least height along an axis of what it has not in common with another.
    fn low(&self, axis: Vec3, other: &Self) -> f32 {
        let own = (0..4).filter(|&i| !other.vertices.contains(&self.vertices[i]));
        own.map(|i| self.points[i].dot(axis)).fold(f32::INFINITY, f32::min)
    }
}

/// The axis along which the first of two quads is furthest over the other, of those that can part convex ones (Gottschalk,
/// Lin and Manocha 1996, section 5): the normals, and what is across an edge of each.
pub fn separating_axis(a: &Quad, b: &Quad) -> Vec3 {
    let across = a.edges().into_iter().flat_map(|e| b.edges().map(|f| e.cross(f)));
    let axes = [a.normal(), b.normal()].into_iter().chain(across).filter_map(Vec3::try_normalize);
    let distance = |axis: Vec3| a.low(axis, b) + b.low(-axis, a);
    let both = axes.flat_map(|axis| [axis, -axis]).map(|axis| (axis, distance(axis)));
    both.max_by(|(_, d), (_, e)| d.total_cmp(e)).map_or(Vec3::ZERO, |(axis, _)| axis)
}

#[cfg(test)]
mod tests {
    use super::super::untangle::{Wanted, untangled};
    use super::*;
    use crate::garment::{Garment, Scheme, SubdivisionRules};
    use crate::mesh::Faces;
    use crate::subdivide::Cage;

    /// A quad on the ground and one above it with a corner at a height.
    fn sheets(corner: f32) -> Cage {
        let ground = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
        let mut over = ground.map(|p| p + Vec3::new(0.1, 0.1, 0.2));
        over[0].z = corner;
        Cage::new(Garment {
            points: ground.into_iter().chain(over).collect(),
            faces: Faces::quads((0..8).map(VertexId::new).collect::<Vec<_>>()),
            rules: SubdivisionRules { scheme: Scheme::Bilinear, ..SubdivisionRules::default() },
            ..Garment::default()
        })
    }

    fn skin<'a>(cage: &'a Cage, points: &IdVec<VertexId, Vec3>) -> Skin<'a> {
        Skin::new(cage.level(), points, &[0, 1].map(FaceId::new), None)
    }

    #[test]
    fn what_crosses_goes_to_where_it_did_not() {
        let [crossing, sound] = [sheets(-0.1), sheets(0.2)];
        let points = &crossing.garment().points;
        let both = [0, 1].map(FaceId::new);
        assert_eq!(skin(&crossing, points).crossings(&both), [both]);
        let apart = apart_now(&skin(&crossing, points), &sound.garment().points, &[both]);
        let wanted = Wanted { apart, ..Wanted::default() };
        let after = untangled(&skin(&crossing, points), points, &wanted, &[]).points;
        assert!(skin(&crossing, &after).crossings(&both).is_empty());
        assert!(points.ids().all(|v| points[v].distance(after[v]) < 0.1));
        assert!(apart_now(&skin(&crossing, &after), &sound.garment().points, &[both]).is_empty());
    }

    #[test]
    fn quads_are_parted_along_an_axis() {
        let quad = |points: [[f32; 3]; 4], first: usize| Quad {
            points: points.map(Vec3::from),
            vertices: std::array::from_fn(|i| VertexId::new(first + i)),
        };
        let ground = quad([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], 0);
        let over = quad([[0.0, 0.0, 0.2], [1.0, 0.0, 0.1], [1.0, 1.0, 0.2], [0.0, 1.0, 0.1]], 4);
        let axis = separating_axis(&over, &ground);
        assert!(axis.abs_diff_eq(Vec3::Z, 1e-6) && separating_axis(&ground, &over).abs_diff_eq(-Vec3::Z, 1e-6));
        // Turned about an edge that both have.
        let mut beside = quad([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.5, 1.0], [0.0, 0.5, 1.0]], 8);
        beside.vertices[0] = ground.vertices[0];
        beside.vertices[1] = ground.vertices[1];
        let axis = separating_axis(&beside, &ground);
        assert!(beside.low(axis, &ground) > 0.5 && ground.low(-axis, &beside) > -1e-6, "{axis}");
    }
}
