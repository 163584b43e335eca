//! Repair of a displaced cage: removes the intersections and flipped faces of its first refinement that its parent lacks.
//! Faults that remain are returned.
//!
//! [`repair`] is the whole method, phase by phase; docs/repair.md describes it. [`contact`](crate::contact) finds the
//! faults.

mod candidate;
mod second_refinement;
mod solver;
mod trial;

use super::child::OperatorDerivation;
use crate::contact::{ChildId, Quad, RefinedFaces, TEST, evaluate, separating_axis, twice_area, with_neighbours};
use candidate::{Candidate, Fault, State};
use glam::Vec3;
use rayon::prelude::*;
use second_refinement::SecondRefinement;
use solver::{Constraint, Row, add_row, least_areas, separation, solve};
use tailor_mesh::connectivity::{FaceId, IdVec, VertexId};
use tailor_mesh::subdivide::{Connectivity, Level};
use trial::{Trial, faces_of, flipped};

/// Share of a height that is left in any case.
pub const LEAST_SHARE: f32 = 0.1;
/// Part of the rest of a height that is left in [`State::Reduced`]. Larger leaves more of it, and repairs less.
const REDUCED: f32 = 0.3;
/// Cosine between the normals of a child and its face below which a face of the parent, or of the input, counts as flipped.
pub const FLIPPED_BEFORE: f32 = 0.3;
/// Distance of faces that are separated, as a part of their size.
const GAP: f32 = 5e-3;

/// Work for each face of the cage. Garments take a tenth of it, and a crumpled sheet would take fifty times as much.
const WORK_PER_FACE: usize = 32 * TEST;
/// Work for a cage of any size: a few faces of a small one may have many faults.
const LEAST_WORK: usize = 50_000 * TEST;

/// A cage that an operator has displaced.
pub struct RepairInput<'a> {
    /// Its connectivity.
    pub child: &'a Connectivity,
    /// The parent, whose faults are not new ones.
    pub parent: &'a Level,
    /// The parent's points.
    pub parent_points: &'a IdVec<VertexId, Vec3>,
    /// The cage from the parent.
    pub derivation: &'a OperatorDerivation,
    /// Vertices with their copies, which keep together.
    pub copy_pairs: &'a [[VertexId; 2]],
    /// Vertices on seam edges.
    pub on_seam: &'a IdVec<VertexId, bool>,
    /// The faces in an order in which neighbours in space are close.
    pub face_order: &'a [FaceId],
    /// The reference normal of each face, zero where both directions are accepted.
    pub reference_normals: &'a IdVec<FaceId, Vec3>,
    /// Faces with a displaced vertex, ascending.
    pub controlled_faces: &'a [FaceId],
    /// Faces with another layer near. Others have faults only where they are not smooth.
    pub near: &'a IdVec<FaceId, bool>,
    /// Points by the operator's weights, with the least heights.
    pub unfitted: &'a IdVec<VertexId, Vec3>,
    /// Points fitted to the limit surface along its normals alone, with the least heights.
    pub upright: &'a IdVec<VertexId, Vec3>,
    /// Points fitted to the limit surface, with the least heights.
    pub least: &'a IdVec<VertexId, Vec3>,
    /// Fitted points with all heights.
    pub full: &'a IdVec<VertexId, Vec3>,
    /// The second refinement, if it counts too.
    pub ahead: Option<SecondRefinementInput<'a>>,
}

/// The input garment, for the test on the second refinement.
pub struct SecondRefinementInput<'a> {
    /// The cage before any operator, whose intersections are not new ones.
    pub input: &'a Level,
    /// Its points.
    pub input_points: &'a IdVec<VertexId, Vec3>,
    /// The face of the input that each face is part of.
    pub input_faces: &'a IdVec<FaceId, FaceId>,
    /// Faces that another layer almost touches.
    pub close: IdVec<FaceId, bool>,
}

/// A repaired cage.
pub struct RepairResult {
    /// Its points.
    pub points: IdVec<VertexId, Vec3>,
    /// The share of its height that each vertex has.
    pub shares: IdVec<VertexId, f32>,
    /// Faces that still intersect others or are flipped, each once, ascending.
    pub faults: Vec<FaceId>,
    /// Whether the bound of work ended the repair early, so that other faces may intersect too.
    pub is_cut_short: bool,
}

impl RepairInput<'_> {
    /// The most work that a repair may take.
    pub fn most_work(&self) -> usize {
        LEAST_WORK + WORK_PER_FACE * self.child.level().topology.faces.len()
    }

    /// Where a state puts a vertex; none if a solver does.
    fn point(&self, v: VertexId, state: State) -> Option<Vec3> {
        match state {
            State::Moved => None,
            State::Unfitted => Some(self.unfitted[v]),
            State::Upright => Some(self.upright[v]),
            _ => Some(self.least[v].lerp(self.full[v], self.part(state))),
        }
    }

    /// Part of the height above the least one.
    fn part(&self, state: State) -> f32 {
        match state {
            State::Full => 1.0,
            State::Reduced => REDUCED,
            State::Least | State::Upright | State::Unfitted | State::Moved => 0.0,
        }
    }
}

/// Repairs a displaced cage.
pub fn repair(input: &RepairInput) -> RepairResult {
    let normals = unfitted_normals(input);
    let mut trial = Trial::new(input, &normals);
    let Some(reduced) = reduce(&mut trial) else { return untested(trial) };
    let share = |&state: &State| LEAST_SHARE + (1.0 - LEAST_SHARE) * input.part(state);
    let mut shares: IdVec<VertexId, f32> = reduced.states.iter().map(share).collect();
    let (facing, folded) = turn_to_reference(&mut trial, reduced);
    let facing_ahead = reduce_ahead(&mut trial, facing);
    // A vertex that a solver has moved keeps its height.
    for (vertex, state) in facing_ahead.states.enumerated() {
        if matches!(state, State::Upright | State::Unfitted) {
            shares[vertex] = LEAST_SHARE;
        }
    }
    let best = separate(&mut trial, facing_ahead);
    let faults = remaining(&trial, best, folded);
    result(trial, shares, faults)
}

fn result(trial: Trial, shares: IdVec<VertexId, f32>, faults: Vec<FaceId>) -> RepairResult {
    RepairResult { points: trial.points, shares, faults, is_cut_short: trial.work.is_over() }
}

/// The cage with the least heights, where a search for its faults takes too much work. Each face that may have one counts.
fn untested(mut trial: Trial) -> RepairResult {
    let states = IdVec::filled(State::Least, trial.points.len());
    trial.displace(states);
    let faults = trial.doubtful(trial.input.controlled_faces);
    let shares = IdVec::filled(LEAST_SHARE, trial.points.len());
    result(trial, shares, faults)
}

/// Reduces heights at faults step by step; the best state of each part. None if the first search takes too much work.
fn reduce(trial: &mut Trial) -> Option<Candidate> {
    let faults = trial.faults_after(&[], trial.input.controlled_faces)?;
    let mut candidates = vec![trial.candidate(faults)];
    // More steps find nearly nothing.
    for _ in 0..4 {
        let known = candidates.last().map_or_else(Vec::new, |last| last.faults.clone());
        let Some(moved) = trial.displace(trial.weakened(&known, State::weaker)) else { break };
        let Some(faults) = trial.faults_after(&known, &moved) else { break };
        candidates.push(trial.candidate(faults));
    }
    Some(trial.take_best(candidates))
}

/// Turns faces that are flipped against their reference normals by small moves; the best state of each part, and faces that
/// agree with these but not with the operator's weights: they may be folded within their plane.
fn turn_to_reference(trial: &mut Trial, reduced: Candidate) -> (Candidate, Vec<FaceId>) {
    let reference = trial.input.reference_normals;
    trial.use_reference();
    let is_folded = |[f, g]: &Fault| f == g && reference[*f] != Vec3::ZERO;
    let (folded, mut faults): (Vec<Fault>, Vec<Fault>) = reduced.faults.iter().partition(|fault| is_folded(fault));
    let turned = trial.faces.flipped(trial.input.controlled_faces, reference);
    faults.extend(turned.iter().map(|&face| [face; 2]));
    let reduced = Candidate { faults, ..reduced };
    let areas = turned.iter().flat_map(|&face| least_areas(&trial.faces, face, trial.wanted_area(face)));
    let constraints: Vec<Box<dyn Constraint>> = areas.collect();
    (move_by(trial, reduced, &constraints, trial.input.copy_pairs), flipped(&folded))
}

/// Reduces heights, all the way at once, where faces intersect on the second refinement; the best state of each part. Each
/// step by itself leaves no fewer of them.
fn reduce_ahead(trial: &mut Trial, mut facing: Candidate) -> Candidate {
    let Some(input) = &trial.input.ahead else { return facing };
    let ahead = SecondRefinement::new(input, &trial.faces);
    let all: Vec<FaceId> = trial.topology().faces.ids().collect();
    let found = ahead.faults(&trial.faces, &all, &trial.work);
    trial.ahead = Some(ahead);
    if found.is_empty() || trial.work.is_over() {
        return facing;
    }
    facing.faults.extend(found);
    let mut candidates = vec![facing];
    for weaker in [State::Upright, State::Unfitted] {
        let known = candidates.last().map_or_else(Vec::new, |last| last.faults.clone());
        let Some(moved) = trial.displace(trial.weakened(&known, |state| state.max(weaker))) else { continue };
        let Some(faults) = trial.faults_after(&known, &moved) else { break };
        candidates.push(trial.candidate(faults));
    }
    trial.take_best(candidates)
}

/// Separates faces that still intersect by small moves; the best state of each part.
fn separate(trial: &mut Trial, reduced: Candidate) -> Candidate {
    if reduced.faults.is_empty() {
        return reduced;
    }
    let around = with_neighbours(trial.topology(), &faces_of(&reduced.faults));
    let of_ahead = trial.ahead.as_ref().map(|ahead| ahead.separations(&trial.faces, &around, &trial.work));
    if trial.work.is_over() {
        return reduced;
    }
    let mut constraints = of_ahead.unwrap_or_default();
    constraints.extend(separations(&trial.faces, trial.input.unfitted, &reduced.faults));
    move_by(trial, reduced, &constraints, &[])
}

/// Constraints that separate the children of intersecting faces, along the axis that separates them in the cage with the
/// points `separated`.
fn separations(faces: &RefinedFaces, separated: &IdVec<VertexId, Vec3>, faults: &[Fault]) -> Vec<Box<dyn Constraint>> {
    let row = |vertex: VertexId| {
        let mut row = Row::new();
        add_row(&mut row, faces.rows(), vertex, 1.0);
        row
    };
    let quad = |child: ChildId| {
        let vertices = faces.child_vertices(child);
        Quad { points: vertices.map(|v| evaluate(faces.rows(), v, separated)), vertices }
    };
    let of_pair = |pair: [ChildId; 2]| {
        let [over, under] = pair.map(quad);
        separation(faces, pair, separating_axis(&over, &under), GAP, row)
    };
    faults.iter().flat_map(|&[f, g]| faces.intersecting_children(f, g)).flat_map(of_pair).collect()
}

/// Moves the cage to meet constraints; the better of that and the state before for each part.
fn move_by(
    trial: &mut Trial,
    before: Candidate,
    constraints: &[Box<dyn Constraint>],
    copies: &[[VertexId; 2]],
) -> Candidate {
    if constraints.is_empty() || trial.work.is_over() {
        return before;
    }
    let points = solve(&trial.points, constraints, copies, &trial.work);
    let state = |v: VertexId| if points[v] == trial.points[v] { trial.states[v] } else { State::Moved };
    let states = points.ids().map(state).collect();
    let moved = trial.move_to(states, points);
    let after = trial.faults_after(&before.faults, &moved).map(|faults| trial.candidate(faults));
    trial.take_best(std::iter::once(before).chain(after).collect())
}

/// The faces with a fault at the end. Faces folded before count unless a solver has moved them.
fn remaining(trial: &Trial, best: Candidate, folded: Vec<FaceId>) -> Vec<FaceId> {
    let faces = &trial.topology().faces;
    let stays = |face: &FaceId| faces.vertices_of(*face).iter().all(|&v| best.states[v] != State::Moved);
    let mut faults = best.faults;
    faults.extend(folded.into_iter().filter(stays).map(|face| [face; 2]));
    faces_of(&faults)
}

/// Normals of the faces by the operator's weights alone, zero without area.
fn unfitted_normals(input: &RepairInput) -> IdVec<FaceId, Vec3> {
    let (faces, points) = (&input.child.level().topology.faces, input.unfitted);
    let normal = |face| {
        let vertices = faces.vertices_of(face);
        let area = twice_area(vertices, points);
        let squared = |&v: &VertexId| points[v].distance_squared(points[vertices[0]]);
        let longest = vertices.iter().map(squared).fold(0.0, f32::max);
        if area.length() > 1e-3 * longest { area.normalize() } else { Vec3::ZERO }
    };
    (0..faces.len()).into_par_iter().map(|face| normal(FaceId::new(face))).collect::<Vec<_>>().into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::WorkLimit;
    use tailor_mesh::connectivity::Faces;
    use tailor_mesh::garment::{Mesh, Scheme, SubdivisionRules};
    use tailor_testing::cage::Cage;

    /// A quad on the ground and one above it with a corner at a height.
    fn sheets(corner: f32) -> Cage {
        let ground = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
        let mut over = ground.map(|p| p + Vec3::new(0.1, 0.1, 0.2));
        over[0].z = corner;
        Cage::new(Mesh {
            points: ground.into_iter().chain(over).collect(),
            faces: Faces::quads((0..8).map(VertexId::new).collect::<Vec<_>>()),
            rules: SubdivisionRules { scheme: Scheme::Bilinear, ..SubdivisionRules::default() },
            ..Mesh::default()
        })
    }

    fn refined<'a>(cage: &'a Cage, points: &IdVec<VertexId, Vec3>) -> RefinedFaces<'a> {
        RefinedFaces::new(cage.level(), cage.level().vertex_rows(), points, &[0, 1].map(FaceId::new), None)
    }

    #[test]
    fn intersecting_faces_are_separated_as_they_were_before() {
        let (intersecting, separated) = (sheets(-0.1), sheets(0.2));
        let points = &intersecting.garment().points;
        let both = [0, 1].map(FaceId::new);
        assert_eq!(refined(&intersecting, points).intersecting_pairs(&both, &WorkLimit::default()), [both]);
        let of = |points| separations(&refined(&intersecting, points), &separated.garment().points, &[both]);
        let after = solve(points, &of(points), &[], &WorkLimit::default());
        assert!(refined(&intersecting, &after).intersecting_pairs(&both, &WorkLimit::default()).is_empty());
        assert!(points.ids().all(|v| points[v].distance(after[v]) < 0.1));
        assert!(of(&after).is_empty());
    }
}
