//! Small moves of a cage that turn back what is turned over.
//!
//! That a child has an area to the right side is a constraint on the points of the cage. Those that fail are met one after
//! the other, each by the least move that does (Müller et al. 2007, *Position based dynamics*, section 3.3).

use super::marks::Marks;
use super::skin::Skin;
use crate::mesh::{CornerId, FaceId, IdVec, VertexId};
use crate::subdivide::Stencils;
use glam::Vec3;

/// Rounds over all children, at most.
const ROUNDS: usize = 40;
/// The area that a child is to have, as a part of the mean one of its face. More moves more than it need.
const LEAST_AREA: f32 = 0.1;
/// How much further than to first order points go: areas are no linear functions of them.
const FURTHER: f32 = 1.1;
/// The furthest that a point goes at once, in lengths of a square of the face's area.
const FURTHEST: f32 = 0.1;

/// Points of which some have moved.
pub struct Untangled {
    /// All points.
    pub points: IdVec<VertexId, Vec3>,
    /// The vertices that have moved.
    pub moved: Vec<VertexId>,
}

/// Moves points of a skin's cage until the children of `turned` look to the side of their faces' `areas` (twice the area,
/// as a vector), and none of `beside` turns over. Both vertices of a pair move together.
pub fn untangled(
    skin: &Skin,
    points: &IdVec<VertexId, Vec3>,
    [turned, beside]: [&[FaceId]; 2],
    area: impl Fn(FaceId) -> Vec3,
    pairs: &[[VertexId; 2]],
) -> Untangled {
    let children = |faces: &[FaceId]| -> Vec<Child> { faces.iter().flat_map(|&f| of_face(skin, f, area(f))).collect() };
    let mut all = children(turned);
    all.extend(children(beside).into_iter().filter_map(|child| child.no_worse(points)));
    let mut partner: IdVec<VertexId, VertexId> = points.ids().collect();
    for &[vertex, copy] in pairs {
        (partner[vertex], partner[copy]) = (copy, vertex);
    }
    let (mut points, mut moved) = (points.clone(), Marks::new(points.len()));
    for _ in 0..ROUNDS {
        let mut is_done = true;
        for child in &all {
            for (vertex, by) in child.moves(&points, &partner) {
                is_done = false;
                points[vertex] += by;
                moved.add(vertex);
                if partner[vertex] != vertex {
                    points[partner[vertex]] += by;
                    moved.add(partner[vertex]);
                }
            }
        }
        if is_done {
            break;
        }
    }
    Untangled { points, moved: moved.list }
}

/// A child of a face that is to have an area.
struct Child {
    /// Its diagonals as weights on the points of the cage: from its corner to the centre, and to the middle of the edge
    /// before from that of the edge after.
    diagonals: [Vec<(VertexId, f32)>; 2],
    /// Where it is to look.
    direction: Vec3,
    /// Twice the area that it is to have at least.
    least: f32,
    /// The furthest that a point goes at once.
    furthest: f32,
}

/// The children of a face that is to have this area.
fn of_face<'a>(skin: &'a Skin, face: FaceId, area: Vec3) -> impl Iterator<Item = Child> + 'a {
    let corners = skin.level.topology.faces.corners_of(face);
    let least = LEAST_AREA * area.length() / corners.len() as f32;
    let (direction, furthest) = (area.normalize_or_zero(), FURTHEST * area.length().sqrt());
    corners.map(move |corner| Child { diagonals: diagonals(skin, corner), direction, least, furthest })
}

/// The diagonals of the child at a corner.
fn diagonals(skin: &Skin, corner: CornerId) -> [Vec<(VertexId, f32)>; 2] {
    let t = &skin.level.topology;
    let face = t.faces.face_of(corner);
    let range = t.faces.range(face);
    let before = CornerId::new(if corner.index() == range.start { range.end } else { corner.index() } - 1);
    let middle = |corner: CornerId| skin.numbering.of_edge(t.corner_edge[corner]);
    let own = skin.numbering.of_vertex(t.faces.vertex(corner));
    [[own, skin.numbering.of_face(face)], [middle(corner), middle(before)]].map(|[from, to]| {
        let mut row = Vec::new();
        skin.rows.row(from.index(), &mut |vertex, weight| add(&mut row, vertex, -weight));
        skin.rows.row(to.index(), &mut |vertex, weight| add(&mut row, vertex, weight));
        row
    })
}

/// Adds to what a vertex has.
fn add<T: std::ops::AddAssign>(all: &mut Vec<(VertexId, T)>, vertex: VertexId, value: T) {
    match all.iter_mut().find(|(v, _)| *v == vertex) {
        Some((_, sum)) => *sum += value,
        None => all.push((vertex, value)),
    }
}

impl Child {
    /// The diagonals, and twice the area to the right side.
    fn measured(&self, points: &IdVec<VertexId, Vec3>) -> ([Vec3; 2], f32) {
        let [u, v] = [0, 1].map(|i| self.diagonals[i].iter().map(|&(vertex, w)| w * points[vertex]).sum::<Vec3>());
        ([u, v], u.cross(v).dot(self.direction))
    }

    /// That it is to be no worse than it is; nothing where it looks to the other side.
    fn no_worse(mut self, points: &IdVec<VertexId, Vec3>) -> Option<Self> {
        self.least = self.least.min(self.measured(points).1);
        (self.least > 0.0).then_some(self)
    }

    /// The least moves that give it the area, to first order, for one of each two partners.
    fn moves(&self, points: &IdVec<VertexId, Vec3>, partner: &IdVec<VertexId, VertexId>) -> Vec<(VertexId, Vec3)> {
        let ([u, v], area) = self.measured(points);
        let lack = self.least - area;
        let mut moves = Vec::new();
        // Not where it is not a number.
        if lack.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
            return moves;
        }
        for (row, slope) in self.diagonals.iter().zip([v.cross(self.direction), self.direction.cross(u)]) {
            row.iter().for_each(|&(vertex, w)| add(&mut moves, vertex.min(partner[vertex]), w * slope));
        }
        let squared: f32 = moves.iter().map(|(_, slope)| slope.length_squared()).sum();
        let longest = moves.iter().map(|(_, slope)| slope.length()).fold(0.0, f32::max);
        let scale = (FURTHER * lack / squared).min(self.furthest / longest);
        moves.iter_mut().for_each(|(_, slope)| *slope *= scale);
        moves.retain(|(_, by)| by.is_finite());
        moves
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::garment::{Garment, Scheme, SubdivisionRules};
    use crate::mesh::Faces;
    use crate::subdivide::Cage;

    /// Two sheets of four quads each, with their middle vertices at a place beyond the corner of the last quad.
    fn sheets(place: [f32; 2]) -> Cage {
        let at = |i: usize| if i == 4 { place } else { [(i % 3) as f32, (i / 3) as f32] };
        let points = [0.0, 0.1].into_iter().flat_map(|z| (0..9).map(move |i| Vec3::new(at(i)[0], at(i)[1], z)));
        let quads = [0, 1, 3, 4].into_iter().flat_map(|i| [i, i + 1, i + 4, i + 3]);
        let corners = [0, 9].into_iter().flat_map(|first| quads.clone().map(move |v| VertexId::new(first + v)));
        Cage::new(Garment {
            points: points.collect(),
            faces: Faces::quads(corners.collect::<Vec<_>>()),
            rules: SubdivisionRules { scheme: Scheme::Bilinear, ..SubdivisionRules::default() },
            ..Garment::default()
        })
    }

    fn skin<'a>(cage: &'a Cage, points: &IdVec<VertexId, Vec3>) -> Skin<'a> {
        let all: Vec<FaceId> = cage.garment().faces.ids().collect();
        Skin::new(cage, points, &all, Some(IdVec::filled(Vec3::Z, all.len())))
    }

    #[test]
    fn faces_are_turned_back_by_small_moves() {
        let cage = sheets([2.2, 2.2]);
        let points = &cage.garment().points;
        let all: Vec<FaceId> = cage.garment().faces.ids().collect();
        let (lower, upper) = all.split_at(4);
        let before = skin(&cage, points);
        let turned = before.turned(lower);
        assert!(!turned.is_empty());
        let beside: Vec<FaceId> = lower.iter().copied().filter(|f| !turned.contains(f)).collect();
        let pairs: Vec<[VertexId; 2]> = (0..9).map(|v| [v, v + 9].map(VertexId::new)).collect();
        let area = |_| 2.0 * Vec3::Z;
        let after = untangled(&before, points, [&turned, &beside], area, &pairs);
        let skin_after = skin(&cage, &after.points);
        assert_eq!((skin_after.turned(lower), skin_after.turned(upper)), (vec![], vec![]), "both sheets");
        let step = |v: VertexId| after.points[v] - points[v];
        assert!(pairs.iter().all(|&[a, b]| step(a).abs_diff_eq(step(b), 1e-6)), "pairs keep together");
        assert!(points.ids().all(|v| step(v).length() < 1.0 && step(v).z == 0.0), "in the plane, and not far");
        assert!(points.ids().all(|v| after.moved.contains(&v) || step(v) == Vec3::ZERO));
    }

    #[test]
    fn what_is_right_stays() {
        let cage = sheets([1.2, 0.9]);
        let (points, all) = (&cage.garment().points, cage.garment().faces.ids().collect::<Vec<_>>());
        let after = untangled(&skin(&cage, points), points, [&all, &[]], |_| 2.0 * Vec3::Z, &[]);
        assert_eq!((after.moved, &after.points), (vec![], points));
    }
}
