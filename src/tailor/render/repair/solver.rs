//! Small moves of a cage's points that meet constraints on its refinement.
//!
//! Constraints that fail are met one after the other, each by the least move that does (Müller et al. 2007, *Position based
//! dynamics*, section 3.3).

use crate::contact::{ChildId, RefinedFaces, TEST, WorkLimit};
use glam::Vec3;
use tailor_mesh::connectivity::{FaceId, IdVec, VertexId};
use tailor_mesh::subdivide::{Stencils, VertexRows};

/// Rounds over all constraints, at most.
const ROUNDS: usize = 40;
/// Least area of a child, as a part of the mean one of its face. More moves more than need be.
const LEAST_AREA: f32 = 0.1;
/// How much further than to first order points go, as areas are not linear functions of them.
const OVERSHOOT: f32 = 1.1;
/// The furthest that a point goes at once, in lengths of a square of the face's area.
const FURTHEST: f32 = 0.1;

/// A point, as a weighted sum of a cage's points.
pub type Row = Vec<(VertexId, f32)>;

/// A condition on the points of a cage.
pub trait Constraint {
    /// The least moves that meet it, to first order; none where it holds. A vertex and its copy are one variable, named by
    /// `variable`.
    fn moves(&self, points: &IdVec<VertexId, Vec3>, variable: &dyn Fn(VertexId) -> VertexId) -> Vec<(VertexId, Vec3)>;
}

/// Points that meet constraints, as far as the bound of `work` allows. Vertices move with their copies.
pub fn solve(
    points: &IdVec<VertexId, Vec3>,
    constraints: &[Box<dyn Constraint>],
    copies: &[[VertexId; 2]],
    work: &WorkLimit,
) -> IdVec<VertexId, Vec3> {
    let mut partner: IdVec<VertexId, VertexId> = points.ids().collect();
    for &[vertex, copy] in copies {
        (partner[vertex], partner[copy]) = (copy, vertex);
    }
    let mut points = points.clone();
    for _ in 0..ROUNDS {
        if !work.take(TEST * constraints.len()) {
            break;
        }
        let mut is_done = true;
        for constraint in constraints {
            for (vertex, by) in constraint.moves(&points, &|v| v.min(partner[v])) {
                is_done = false;
                points[vertex] += by;
                if partner[vertex] != vertex {
                    points[partner[vertex]] += by;
                }
            }
        }
        if is_done {
            break;
        }
    }
    points
}

/// The least moves that make up for a lack, by the gradient of what is lacking.
fn least_moves(mut gradient: Vec<(VertexId, Vec3)>, lack: f32, furthest: f32) -> Vec<(VertexId, Vec3)> {
    let squared: f32 = gradient.iter().map(|(_, slope)| slope.length_squared()).sum();
    let longest = gradient.iter().map(|(_, slope)| slope.length()).fold(0.0, f32::max);
    let scale = (OVERSHOOT * lack / squared).min(furthest / longest);
    gradient.iter_mut().for_each(|(_, slope)| *slope *= scale);
    gradient.retain(|(_, by)| by.is_finite());
    gradient
}

/// A child of a face has an area to the side of a direction.
struct LeastArea {
    /// The diagonals of the child: from its vertex point to the face point, and from its edge point to the previous one.
    diagonals: [Row; 2],
    direction: Vec3,
    /// Twice the area that it has at least.
    least: f32,
    /// The furthest that a point goes at once.
    furthest: f32,
}

/// Constraints that give every child of a face a minimum area. `area` is twice the area of the face, as a vector along the
/// normal that its children should have.
pub fn least_areas(faces: &RefinedFaces, face: FaceId, area: Vec3) -> Vec<Box<dyn Constraint>> {
    let valence = faces.level().topology.faces.valence(face);
    let least = LEAST_AREA * area.length() / valence as f32;
    let (direction, furthest) = (area.normalize_or_zero(), FURTHEST * area.length().sqrt());
    let of_child = |number: usize| -> Box<dyn Constraint> {
        let [vertex, edge, centre, previous] = faces.child_vertices((face, number));
        let diagonals = [[vertex, centre], [edge, previous]].map(|[from, to]| {
            let mut row = Row::new();
            add_row(&mut row, faces.rows(), from, -1.0);
            add_row(&mut row, faces.rows(), to, 1.0);
            row
        });
        Box::new(LeastArea { diagonals, direction, least, furthest })
    };
    (0..valence).map(of_child).collect()
}

impl Constraint for LeastArea {
    fn moves(&self, points: &IdVec<VertexId, Vec3>, variable: &dyn Fn(VertexId) -> VertexId) -> Vec<(VertexId, Vec3)> {
        let [u, v] = [0, 1].map(|i| self.diagonals[i].iter().map(|&(vertex, w)| w * points[vertex]).sum::<Vec3>());
        let lack = self.least - u.cross(v).dot(self.direction);
        let mut gradient = Vec::new();
        if lack > 0.0 {
            for (row, slope) in self.diagonals.iter().zip([v.cross(self.direction), self.direction.cross(u)]) {
                row.iter().for_each(|&(vertex, w)| add(&mut gradient, variable(vertex), w * slope));
            }
        }
        least_moves(gradient, lack, self.furthest)
    }
}

/// Points are on two sides of a plane.
struct Separation {
    over: Vec<Row>,
    under: Vec<Row>,
    /// The normal of the plane, towards `over`.
    axis: Vec3,
    /// The least distance along it.
    gap: f32,
}

/// Constraints that put two children on opposite sides of a plane, the first one above it. Common vertices lie in the
/// plane. `row` gives a vertex of the refinement as a weighted sum of a cage's points; `gap` is a share of a child's size.
pub fn separation(
    faces: &RefinedFaces,
    [over, under]: [ChildId; 2],
    axis: Vec3,
    gap: f32,
    row: impl Fn(VertexId) -> Row,
) -> Vec<Box<dyn Constraint>> {
    let corners = faces.child(over);
    let gap = gap * corners[0].distance(corners[2]);
    let [over, under] = [over, under].map(|child| faces.child_vertices(child));
    let (common, over): (Vec<VertexId>, Vec<VertexId>) = over.into_iter().partition(|v| under.contains(v));
    let under: Vec<VertexId> = under.into_iter().filter(|v| !common.contains(v)).collect();
    let separation = |over: &[VertexId], under: &[VertexId]| -> Box<dyn Constraint> {
        let [over, under] = [over, under].map(|vertices| vertices.iter().map(|&v| row(v)).collect());
        Box::new(Separation { over, under, axis, gap })
    };
    if common.is_empty() {
        return vec![separation(&over, &under)];
    }
    vec![separation(&over, &common), separation(&common, &under)]
}

impl Constraint for Separation {
    fn moves(&self, points: &IdVec<VertexId, Vec3>, variable: &dyn Fn(VertexId) -> VertexId) -> Vec<(VertexId, Vec3)> {
        let height = |row: &Row| row.iter().map(|&(v, w)| w * points[v].dot(self.axis)).sum::<f32>();
        let lowest = |sign: f32, rows: &[Row]| {
            let heights = rows.iter().map(|row| sign * height(row)).enumerate();
            heights.min_by(|a, b| a.1.total_cmp(&b.1))
        };
        let mut gradient = Vec::new();
        let (Some((over, low)), Some((under, high))) = (lowest(1.0, &self.over), lowest(-1.0, &self.under)) else {
            return gradient;
        };
        let lack = self.gap - low - high;
        if lack > 0.0 {
            let under = self.under[under].iter().map(|&(v, w)| (v, -w));
            let weights = self.over[over].iter().copied().chain(under);
            weights.for_each(|(v, w)| add(&mut gradient, variable(v), w * self.axis));
        }
        least_moves(gradient, lack, self.gap)
    }
}

/// Adds a multiple of a refinement's vertex, as a weighted sum, to a row.
pub fn add_row(row: &mut Row, rows: &VertexRows, vertex: VertexId, times: f32) {
    rows.row(vertex.index(), &mut |v, weight| add(row, v, times * weight));
}

fn add<T: std::ops::AddAssign>(all: &mut Vec<(VertexId, T)>, vertex: VertexId, value: T) {
    match all.iter_mut().find(|(v, _)| *v == vertex) {
        Some((_, sum)) => *sum += value,
        None => all.push((vertex, value)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tailor_mesh::connectivity::Faces;
    use tailor_mesh::garment::{Mesh, Scheme, SubdivisionRules};
    use tailor_testing::cage::Cage;

    /// Two sheets of four quads each, with their middle vertices at a place beyond the corner of the last quad.
    fn sheets(place: [f32; 2]) -> Cage {
        let at = |i: usize| if i == 4 { place } else { [(i % 3) as f32, (i / 3) as f32] };
        let points = [0.0, 0.1].into_iter().flat_map(|z| (0..9).map(move |i| Vec3::new(at(i)[0], at(i)[1], z)));
        let quads = [0, 1, 3, 4].into_iter().flat_map(|i| [i, i + 1, i + 4, i + 3]);
        let corners = [0, 9].into_iter().flat_map(|first| quads.clone().map(move |v| VertexId::new(first + v)));
        Cage::new(Mesh {
            points: points.collect(),
            faces: Faces::quads(corners.collect::<Vec<_>>()),
            rules: SubdivisionRules { scheme: Scheme::Bilinear, ..SubdivisionRules::default() },
            ..Mesh::default()
        })
    }

    fn refined<'a>(cage: &'a Cage, points: &IdVec<VertexId, Vec3>) -> RefinedFaces<'a> {
        let all: Vec<FaceId> = cage.garment().faces.ids().collect();
        RefinedFaces::new(cage.level(), cage.level().vertex_rows(), points, &all, None)
    }

    fn areas(faces: &RefinedFaces, of: impl IntoIterator<Item = FaceId>) -> Vec<Box<dyn Constraint>> {
        of.into_iter().flat_map(|face| least_areas(faces, face, 2.0 * Vec3::Z)).collect()
    }

    #[test]
    fn flipped_faces_are_turned_back_by_small_moves() {
        let cage = sheets([2.2, 2.2]);
        let points = &cage.garment().points;
        let all: Vec<FaceId> = cage.garment().faces.ids().collect();
        let (lower, upper) = all.split_at(4);
        let (before, up) = (refined(&cage, points), IdVec::filled(Vec3::Z, 8));
        let flipped = before.flipped(lower, &up);
        assert!(!flipped.is_empty());
        let copies: Vec<[VertexId; 2]> = (0..9).map(|v| [v, v + 9].map(VertexId::new)).collect();
        let after = solve(points, &areas(&before, lower.iter().copied()), &copies, &WorkLimit::default());
        let faces_after = refined(&cage, &after);
        assert_eq!((faces_after.flipped(lower, &up), faces_after.flipped(upper, &up)), (vec![], vec![]), "both sheets");
        let step = |v: VertexId| after[v] - points[v];
        assert!(copies.iter().all(|&[a, b]| step(a).abs_diff_eq(step(b), 1e-6)), "copies keep together");
        assert!(points.ids().all(|v| step(v).length() < 1.0 && step(v).z == 0.0), "in the plane, and not far");
    }

    #[test]
    fn points_that_meet_all_constraints_stay() {
        let cage = sheets([1.2, 0.9]);
        let points = &cage.garment().points;
        let areas = areas(&refined(&cage, points), cage.garment().faces.ids());
        assert_eq!(solve(points, &areas, &[], &WorkLimit::default()), *points);
    }
}
