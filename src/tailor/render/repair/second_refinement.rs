//! Intersections on the second refinement of a cage.
//!
//! Each refinement moves the points of the one before. Where two sheets almost touch, or a fold is tight, faces that do not
//! intersect on the first may do on the second. Only the part of the cage that is close to itself is refined twice.

use super::candidate::Fault;
use super::solver::{Constraint, Row, add_row, separation};
use super::{GAP, SecondRefinementInput};
use crate::contact::{
    ChildId, NextContacts, Proximity, Quad, RefinedFaces, RefinedPart, TEST, WorkLimit, each_once, evaluate,
    separating_axis,
};
use rayon::prelude::*;
use tailor_mesh::connectivity::{FaceId, VertexId};
use tailor_mesh::subdivide::Stencils;

/// Pairs of children that one task refines again. Fewer refine more of the cage twice.
const PAIRS_PER_TASK: usize = 1024;

/// The second refinement of a cage under repair.
pub struct SecondRefinement<'a> {
    input: &'a SecondRefinementInput<'a>,
    proximity: Proximity,
}

impl<'a> SecondRefinement<'a> {
    pub fn new(input: &'a SecondRefinementInput<'a>, faces: &RefinedFaces) -> Self {
        Self { input, proximity: Proximity::new(faces) }
    }

    /// Follows faces that have moved.
    pub fn update(&mut self, faces: &RefinedFaces, moved: &[FaceId]) {
        self.proximity.update(faces, moved);
    }

    /// Pairs of faces that intersect on the second refinement, at least one of them among `of`. Pairs that intersect in the
    /// input are left out. A face among `of` in a crowd that is too close to be tested counts as one that intersects itself.
    /// Incomplete beyond the bound of `work`.
    pub fn faults(&self, faces: &RefinedFaces, of: &[FaceId], work: &WorkLimit) -> Vec<Fault> {
        let near = self.near(faces, of, work);
        let found = self.intersecting(faces, &near.pairs, work);
        each_once(found.iter().map(faces_of).chain(near.crowded.iter().map(|&face| [face; 2])).collect())
    }

    /// Constraints that separate children that intersect on the second refinement, along the axis that separates them on
    /// the first. Incomplete beyond the bound of `work`.
    pub fn separations(&self, faces: &RefinedFaces, of: &[FaceId], work: &WorkLimit) -> Vec<Box<dyn Constraint>> {
        let pairs = self.intersecting(faces, &self.near(faces, of, work).pairs, work);
        let part = RefinedPart::new(faces.level(), &pairs, |v| faces.points()[v]);
        let refined = part.refined();
        let row = |vertex: VertexId| {
            let mut row = Row::new();
            refined.rows().row(vertex.index(), &mut |v, weight| add_row(&mut row, faces.rows(), part.whole[v], weight));
            row
        };
        let of_pair = |pair: &[ChildId; 2]| -> Vec<Box<dyn Constraint>> {
            let [a, b] = pair.map(|child| part.face(child));
            let [over, under] =
                pair.map(|child| Quad { points: faces.child(child), vertices: faces.child_vertices(child) });
            let axis = separating_axis(&over, &under);
            let children = refined.intersecting_children(a, b).into_iter();
            children.flat_map(|pair| separation(&refined, pair, axis, GAP, row)).collect()
        };
        pairs.iter().flat_map(of_pair).collect()
    }

    /// The contacts of some faces that are possible on the second refinement.
    fn near(&self, faces: &RefinedFaces, of: &[FaceId], work: &WorkLimit) -> NextContacts {
        let is_doubtful = |face: &FaceId| self.input.close[*face] || !faces.is_smooth(*face);
        let doubtful: Vec<FaceId> = of.iter().copied().filter(is_doubtful).collect();
        self.proximity.contacts(faces, &doubtful, work)
    }

    /// The pairs among `near` whose own children intersect.
    fn intersecting(&self, faces: &RefinedFaces, near: &[[ChildId; 2]], work: &WorkLimit) -> Vec<[ChildId; 2]> {
        let of_task = |near: &[[ChildId; 2]]| {
            if work.is_over() {
                return Vec::new();
            }
            let part = RefinedPart::new(faces.level(), near, |v| faces.points()[v]);
            let mut found = part.intersecting(&part.refined(), near);
            let parents = |pair: &[ChildId; 2]| sorted(pair.map(|(face, _)| self.input.input_faces[face]));
            let known = self.intersecting_in_input(&each_once(found.iter().map(parents).collect()), work);
            found.retain(|pair| known.binary_search(&parents(pair)).is_err());
            found
        };
        near.par_chunks(PAIRS_PER_TASK).flat_map_iter(of_task).collect()
    }

    /// The pairs of faces of the input that intersect on its second refinement.
    fn intersecting_in_input(&self, pairs: &[Fault], work: &WorkLimit) -> Vec<Fault> {
        let (level, faces) = (self.input.input, &self.input.input.topology.faces);
        let children = |&[f, g]: &Fault| faces.valence(f) * faces.valence(g);
        if pairs.is_empty() || !work.take(TEST * pairs.iter().map(children).sum::<usize>()) {
            return Vec::new();
        }
        let children = |face: FaceId| (0..faces.valence(face)).map(move |number| (face, number));
        let of_pair = |&[f, g]: &Fault| children(f).flat_map(move |a| children(g).map(move |b| [a, b]));
        let all: Vec<[ChildId; 2]> = pairs.iter().flat_map(of_pair).collect();
        let rows = level.vertex_stencils();
        let part = RefinedPart::new(level, &all, |v| evaluate(&rows, v, self.input.input_points));
        each_once(part.intersecting(&part.refined(), &all).iter().map(faces_of).collect())
    }
}

/// The faces of two children, ascending.
fn faces_of(pair: &[ChildId; 2]) -> Fault {
    sorted(pair.map(|(face, _)| face))
}

fn sorted([a, b]: Fault) -> Fault {
    [a.min(b), a.max(b)]
}

#[cfg(test)]
mod tests {
    use super::super::solver::solve;
    use super::*;
    use glam::Vec3;
    use tailor_mesh::connectivity::{Faces, IdVec};
    use tailor_mesh::garment::Mesh;
    use tailor_testing::cage::Cage;

    /// The first vertex of the small quad.
    const QUAD: usize = 25;
    /// How high it may be so that nothing intersects on any refinement.
    const LOW: f32 = 0.05;
    /// How high it is below the first refinement and through the second one.
    const HIGH: f32 = 0.098;

    /// Sixteen quads with a ridge across their middle, and a small quad that stands below one of them as high as `top`.
    fn ridge(top: f32) -> Cage {
        let sheet = (0..25).map(|i| Vec3::new((i % 5) as f32, (i / 5) as f32, if i % 5 == 2 { 0.2 } else { 0.0 }));
        let small = [(2.49, 0.02), (2.51, 0.02), (2.51, top), (2.49, top)].map(|(x, z)| Vec3::new(x, 2.3, z));
        let first = (0..20).filter(|i| i % 5 < 4);
        let quads = first.flat_map(|i| [i, i + 1, i + 6, i + 5]).chain(QUAD..QUAD + 4).map(VertexId::new);
        Cage::new(Mesh {
            points: sheet.chain(small).collect(),
            faces: Faces::quads(quads.collect::<Vec<_>>()),
            ..Mesh::default()
        })
    }

    fn all(cage: &Cage) -> Vec<FaceId> {
        cage.garment().faces.ids().collect()
    }

    fn refined<'a>(cage: &'a Cage, points: &IdVec<VertexId, Vec3>) -> RefinedFaces<'a> {
        RefinedFaces::new(cage.level(), cage.level().vertex_rows(), points, &all(cage), None)
    }

    /// The faults ahead of a cage with these points that it has not with the small quad as high as `before`, and what
    /// separates them.
    fn ahead(cage: &Cage, points: &IdVec<VertexId, Vec3>, before: f32) -> (Vec<Fault>, Vec<Box<dyn Constraint>>) {
        let (faces, input, all) = (refined(cage, points), ridge(before), all(cage));
        let close = IdVec::filled(true, all.len());
        let (input_points, input_faces) = (&input.garment().points, &all.iter().copied().collect());
        let input = SecondRefinementInput { input: input.level(), input_points, input_faces, close };
        let ahead = SecondRefinement::new(&input, &faces);
        {
            let work = WorkLimit::default();
            (ahead.faults(&faces, &all, &work), ahead.separations(&faces, &all, &work))
        }
    }

    #[test]
    fn intersections_on_the_second_refinement_are_found() {
        let cage = ridge(HIGH);
        let points = &cage.garment().points;
        assert!(
            refined(&cage, points).intersecting_pairs(&all(&cage), &WorkLimit::default()).is_empty(),
            "on the first"
        );
        let both = [10, 16].map(FaceId::new);
        assert_eq!(ahead(&cage, points, LOW).0, [both]);
        assert_eq!(ahead(&cage, points, HIGH).0, [[both[0]; 2]; 0], "they are in the input");
        let low = ridge(LOW);
        assert_eq!(ahead(&low, &low.garment().points, LOW).0, [[both[0]; 2]; 0]);
        let faces = refined(&low, &low.garment().points);
        assert!(Proximity::new(&faces).contacts(&faces, &all(&low), &WorkLimit::default()).pairs.is_empty());
    }

    #[test]
    fn they_are_separated_by_small_moves() {
        let cage = ridge(HIGH);
        let points = &cage.garment().points;
        let after = solve(points, &ahead(&cage, points, LOW).1, &[], &WorkLimit::default());
        assert!(ahead(&cage, &after, LOW).0.is_empty());
        assert!(points.ids().all(|v| points[v].distance(after[v]) < 0.05));
        assert!(points.ids().any(|v| points[v] != after[v]));
    }
}
