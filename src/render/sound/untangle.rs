//! Small moves of a cage that turn back what is turned over.
//!
//! That a child has an area to the right side is a constraint on the points of the cage. Those that fail are met one after
//! the other, each by the least move that does (Müller et al. 2007, *Position based dynamics*, section 3.3).

use super::marks::Marks;
use super::skin::Skin;
use crate::mesh::{CornerId, FaceId, IdVec, VertexId};
use crate::subdivide::{Stencils, VertexRows};
use glam::Vec3;

/// Rounds over all children, at most.
const ROUNDS: usize = 40;
/// The area that a child is to have, as a part of the mean one of its face. More moves more than it need.
const LEAST_AREA: f32 = 0.1;
/// How much further than to first order points go: areas are no linear functions of them.
const FURTHER: f32 = 1.1;
/// The furthest that a point goes at once, in lengths of a square of the face's area.
const FURTHEST: f32 = 0.1;

/// A point, as weights on the points of a cage.
pub type Row = Vec<(VertexId, f32)>;

/// Points of which some have moved.
pub struct Untangled {
    /// All points.
    pub points: IdVec<VertexId, Vec3>,
    /// The vertices that have moved.
    pub moved: Vec<VertexId>,
}

/// What is asked of the children of some faces.
#[derive(Default)]
pub struct Wanted {
    /// Faces whose children are to look to the side of these areas (twice the area, as a vector).
    pub turned: Vec<(FaceId, Vec3)>,
    /// Faces of which no child is to be worse than it is.
    pub beside: Vec<(FaceId, Vec3)>,
    /// Faces of a second layer that are to be behind those that they are copies of.
    pub layers: Vec<Layer>,
    /// Points that are to be on two sides of a plane.
    pub apart: Vec<Apart>,
    /// Whether copies move with what they are copies of.
    pub moves_both: bool,
}

/// A face of a second layer.
pub struct Layer {
    /// The face that it is a copy of.
    pub over: FaceId,
    /// The face.
    pub copy: FaceId,
    /// How far it is to be from the other one at least, and to which side.
    pub gap: Vec3,
}

/// Moves points of a skin's cage until its children are as wanted. `pairs` are vertices with their copies.
pub fn untangled(skin: &Skin, points: &IdVec<VertexId, Vec3>, wanted: &Wanted, pairs: &[[VertexId; 2]]) -> Untangled {
    let children = |faces: &[(FaceId, Vec3)]| -> Vec<Child> {
        faces.iter().flat_map(|&(face, area)| of_face(skin, face, area)).collect()
    };
    let mut of_layers: Vec<Behind> = Vec::new();
    wanted.layers.iter().for_each(|layer| of_layers.extend(behind(skin, layer, pairs)));
    let mut all: Vec<&dyn Constraint> = of_layers.iter().map(|point| point as _).collect();
    let turned = children(&wanted.turned);
    let beside: Vec<Child> = children(&wanted.beside).into_iter().filter_map(|child| child.no_worse(points)).collect();
    all.extend(wanted.apart.iter().map(|pair| pair as &dyn Constraint));
    all.extend(turned.iter().chain(&beside).map(|child| child as &dyn Constraint));
    let mut partner: IdVec<VertexId, VertexId> = points.ids().collect();
    for &[vertex, copy] in pairs.iter().filter(|_| wanted.moves_both) {
        (partner[vertex], partner[copy]) = (copy, vertex);
    }
    let (mut points, mut moved) = (points.clone(), Marks::new(points.len()));
    for _ in 0..ROUNDS {
        let mut is_done = true;
        for constraint in &all {
            for (vertex, by) in constraint.moves(&points, &partner) {
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

/// What is to hold of the points of a cage.
trait Constraint {
    /// The least moves by which it holds, to first order, for one of each two partners; none where it does.
    fn moves(&self, points: &IdVec<VertexId, Vec3>, partner: &IdVec<VertexId, VertexId>) -> Vec<(VertexId, Vec3)>;
}

/// The least moves that make up for a lack, by how much a move of each vertex does.
fn least_moves(mut moves: Vec<(VertexId, Vec3)>, lack: f32, furthest: f32) -> Vec<(VertexId, Vec3)> {
    let squared: f32 = moves.iter().map(|(_, slope)| slope.length_squared()).sum();
    let longest = moves.iter().map(|(_, slope)| slope.length()).fold(0.0, f32::max);
    let scale = (FURTHER * lack / squared).min(furthest / longest);
    moves.iter_mut().for_each(|(_, slope)| *slope *= scale);
    moves.retain(|(_, by)| by.is_finite());
    moves
}

/// Whether there is a lack, and it is a number.
fn is_lacking(lack: f32) -> bool {
    lack.partial_cmp(&0.0) == Some(std::cmp::Ordering::Greater)
}

/// A child of a face that is to have an area.
struct Child {
    /// Its diagonals as weights on the points of the cage: from its corner to the centre, and to the middle of the edge
    /// before from that of the edge after.
    diagonals: [Row; 2],
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
fn diagonals(skin: &Skin, corner: CornerId) -> [Row; 2] {
    let t = &skin.level.topology;
    let face = t.faces.face_of(corner);
    let range = t.faces.range(face);
    let before = CornerId::new(if corner.index() == range.start { range.end } else { corner.index() } - 1);
    let middle = |corner: CornerId| skin.numbering.of_edge(t.corner_edge[corner]);
    let own = skin.numbering.of_vertex(t.faces.vertex(corner));
    [[own, skin.numbering.of_face(face)], [middle(corner), middle(before)]].map(|step| difference(skin, step))
}

/// The step from one point of the first refinement to another, as weights on the points of the cage.
fn difference(skin: &Skin, [from, to]: [VertexId; 2]) -> Row {
    let mut row = Vec::new();
    add_row(&mut row, &skin.rows, from, -1.0);
    add_row(&mut row, &skin.rows, to, 1.0);
    row
}

/// Adds so many times what a vertex of a refinement is made of.
pub fn add_row(row: &mut Row, rows: &VertexRows, vertex: VertexId, times: f32) {
    rows.row(vertex.index(), &mut |v, weight| add(row, v, times * weight));
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
}

impl Constraint for Child {
    fn moves(&self, points: &IdVec<VertexId, Vec3>, partner: &IdVec<VertexId, VertexId>) -> Vec<(VertexId, Vec3)> {
        let ([u, v], area) = self.measured(points);
        let lack = self.least - area;
        let mut slopes = Vec::new();
        if !is_lacking(lack) {
            return slopes;
        }
        for (row, slope) in self.diagonals.iter().zip([v.cross(self.direction), self.direction.cross(u)]) {
            row.iter().for_each(|&(vertex, w)| add(&mut slopes, vertex.min(partner[vertex]), w * slope));
        }
        least_moves(slopes, lack, self.furthest)
    }
}

/// A point of a second layer's children that is to stay behind that of the first.
struct Behind {
    /// The step from the one to the other, as weights on the points of the cage.
    step: Row,
    /// Where behind is.
    direction: Vec3,
    /// How far it is to be.
    least: f32,
}

/// The points of the children of a face of a second layer. None where it is no copy of the other.
fn behind(skin: &Skin, layer: &Layer, pairs: &[[VertexId; 2]]) -> Vec<Behind> {
    let (faces, corner_edge) = (&skin.level.topology.faces, &skin.level.topology.corner_edge);
    let vertex = |corner| [faces.vertex(corner), faces.vertex(faces.next(corner))];
    let mut steps = vec![[skin.numbering.of_face(layer.over), skin.numbering.of_face(layer.copy)]];
    for corner in faces.corners_of(layer.copy) {
        // The copy runs the other way around.
        let [to, from] = vertex(corner).map(|copy| pairs.iter().find(|pair| pair[1] == copy).map(|pair| pair[0]));
        let is_over = |&over: &CornerId| vertex(over).map(Some) == [from, to];
        let Some(over) = faces.corners_of(layer.over).find(is_over) else { return Vec::new() };
        steps.push([faces.vertex(faces.next(over)), faces.vertex(corner)].map(|v| skin.numbering.of_vertex(v)));
        steps.push([over, corner].map(|c| skin.numbering.of_edge(corner_edge[c])));
    }
    let (direction, least) = (layer.gap.normalize_or_zero(), layer.gap.length());
    steps.into_iter().map(|step| Behind { step: difference(skin, step), direction, least }).collect()
}

impl Constraint for Behind {
    fn moves(&self, points: &IdVec<VertexId, Vec3>, partner: &IdVec<VertexId, VertexId>) -> Vec<(VertexId, Vec3)> {
        let step: Vec3 = self.step.iter().map(|&(vertex, w)| w * points[vertex]).sum();
        let lack = self.least - step.dot(self.direction);
        let mut slopes = Vec::new();
        if is_lacking(lack) {
            self.step.iter().for_each(|&(vertex, w)| {
                add(&mut slopes, vertex.min(partner[vertex]), w * self.direction);
            });
        }
        least_moves(slopes, lack, self.least)
    }
}

/// Points that are to be on two sides of a plane.
pub struct Apart {
    /// Points on the one side.
    pub over: Vec<Row>,
    /// Points on the other.
    pub under: Vec<Row>,
    /// The normal of the plane, on the first side.
    pub axis: Vec3,
    /// How far they are to be apart.
    pub gap: f32,
}

impl Constraint for Apart {
    fn moves(&self, points: &IdVec<VertexId, Vec3>, partner: &IdVec<VertexId, VertexId>) -> Vec<(VertexId, Vec3)> {
        let height = |row: &Row| row.iter().map(|&(v, w)| w * points[v].dot(self.axis)).sum::<f32>();
        let lowest = |sign: f32, rows: &[Row]| {
            let heights = rows.iter().map(|row| sign * height(row)).enumerate();
            heights.min_by(|a, b| a.1.total_cmp(&b.1))
        };
        let mut slopes = Vec::new();
        let (Some((over, low)), Some((under, high))) = (lowest(1.0, &self.over), lowest(-1.0, &self.under)) else {
            return slopes;
        };
        let lack = self.gap - low - high;
        if is_lacking(lack) {
            let (over, under) = (self.over[over].iter(), self.under[under].iter());
            let weights = over.copied().chain(under.map(|&(v, w)| (v, -w)));
            weights.for_each(|(v, w)| add(&mut slopes, v.min(partner[v]), w * self.axis));
        }
        least_moves(slopes, lack, self.gap)
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
        Skin::new(cage.level(), points, &all, Some(IdVec::filled(Vec3::Z, all.len())))
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
        let [turned, beside] = [turned, beside].map(|faces| faces.into_iter().map(|f| (f, 2.0 * Vec3::Z)).collect());
        let wanted = Wanted { turned, beside, moves_both: true, ..Wanted::default() };
        let after = untangled(&before, points, &wanted, &pairs);
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
        let points = &cage.garment().points;
        let turned = cage.garment().faces.ids().map(|face| (face, 2.0 * Vec3::Z)).collect();
        let after = untangled(&skin(&cage, points), points, &Wanted { turned, ..Wanted::default() }, &[]);
        assert_eq!((after.moved, &after.points), (vec![], points));
    }

    /// A quad, and its copy below it but for one corner, which is at a height.
    fn layers(corner: f32) -> Cage {
        let plane = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let points = [0.0, -0.1].into_iter().flat_map(|z| plane.map(|[x, y]| Vec3::new(x, y, z)));
        let mut points: IdVec<VertexId, Vec3> = points.collect();
        points[VertexId::new(6)].z = corner;
        Cage::new(Garment {
            points,
            faces: Faces::quads([0, 1, 2, 3, 7, 6, 5, 4].map(VertexId::new).to_vec()),
            rules: SubdivisionRules { scheme: Scheme::Bilinear, ..SubdivisionRules::default() },
            ..Garment::default()
        })
    }

    #[test]
    fn second_layers_are_moved_behind_the_first() {
        let [over, copy] = [0, 1].map(FaceId::new);
        let pairs: Vec<[VertexId; 2]> = (0..4).map(|v| [v, v + 4].map(VertexId::new)).collect();
        let moved = |corner: f32, pairs: &[[VertexId; 2]]| {
            let cage = layers(corner);
            let layers = vec![Layer { over, copy, gap: Vec3::new(0.0, 0.0, -0.05) }];
            let wanted = Wanted { layers, ..Wanted::default() };
            untangled(&skin(&cage, &cage.garment().points), &cage.garment().points, &wanted, pairs)
        };
        let after = moved(0.08, &pairs);
        let gaps = pairs.iter().map(|&[v, copy]| after.points[v].z - after.points[copy].z);
        assert!(gaps.clone().all(|gap| gap > 0.0499), "{:?}", gaps.collect::<Vec<_>>());
        assert!(after.points.iter().zip(layers(0.08).garment().points.iter()).all(|(a, b)| a.x == b.x && a.y == b.y));
        assert!(moved(-0.1, &pairs).moved.is_empty(), "what is behind stays");
        assert!(moved(0.08, &[]).moved.is_empty(), "no copies");
    }
}
