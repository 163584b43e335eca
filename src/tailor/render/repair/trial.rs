//! The cage under repair: its points, its refined faces, and which of its faces have a fault.

use super::candidate::{Candidate, Fault, State, combined, differs};
use super::second_refinement::SecondRefinement;
use super::{FLIPPED_BEFORE, RepairInput};
use crate::contact::{RefinedFaces, TEST, WorkLimit, each_once, twice_area, with_neighbours};
use glam::Vec3;
use tailor_mesh::connectivity::{FaceId, IdVec, Topology, VertexId};
use tailor_mesh::subdivide::Derivation;

/// A cage under repair.
pub struct Trial<'a> {
    pub input: &'a RepairInput<'a>,
    pub faces: RefinedFaces<'a>,
    /// The faces of the parent, as far as they were asked about.
    parent_faces: RefinedFaces<'a>,
    /// The direction that each face should have; zero where both are accepted.
    pub directions: IdVec<FaceId, Vec3>,
    /// Whether these are the reference normals, where there is one.
    uses_reference: bool,
    pub states: IdVec<VertexId, State>,
    pub points: IdVec<VertexId, Vec3>,
    /// The second refinement, once it is looked at.
    pub ahead: Option<SecondRefinement<'a>>,
    /// The work of all searches for faults, and of the solver.
    pub work: WorkLimit,
}

impl<'a> Trial<'a> {
    /// The cage with all heights. `normals` are those of the faces by the operator's weights alone.
    pub fn new(input: &'a RepairInput<'a>, normals: &'a IdVec<FaceId, Vec3>) -> Self {
        let (level, rows) = (input.child.level(), input.child.vertex_rows());
        let points = input.full.clone();
        Self {
            input,
            faces: RefinedFaces::new(level, rows, &points, input.face_order, Some(normals)),
            parent_faces: RefinedFaces::empty(input.parent),
            directions: normals.clone(),
            uses_reference: false,
            states: IdVec::filled(State::Full, points.len()),
            points,
            ahead: None,
            work: WorkLimit::new(input.most_work()),
        }
    }

    pub fn topology(&self) -> &'a Topology {
        &self.input.child.level().topology
    }

    /// Tests faces against their reference normals from now on, where there is one.
    pub fn use_reference(&mut self) {
        self.uses_reference = true;
        let known = self.input.reference_normals.enumerated().filter(|(_, normal)| **normal != Vec3::ZERO);
        known.for_each(|(face, &normal)| self.directions[face] = normal);
    }

    /// States in which the vertices of faults, and of what touches flipped faces, are displaced less. Vertices keep
    /// together with their copies, and those on seams change for faults of their own faces only.
    pub fn weakened(&self, faults: &[Fault], weaker: impl Fn(State) -> State) -> IdVec<VertexId, State> {
        let t = self.topology();
        let vertices_of = |face: FaceId| t.faces.vertices_of(face).iter().copied();
        let around = with_neighbours(t, &flipped(faults)).into_iter().flat_map(vertices_of);
        let around = around.filter(|&v| !self.input.on_seam[v]);
        let mut states = self.states.clone();
        for v in around.chain(faults.iter().flatten().copied().flat_map(vertices_of)) {
            states[v] = weaker(self.states[v]);
        }
        for &[vertex, copy] in self.input.copy_pairs {
            let weakest = states[vertex].max(states[copy]);
            (states[vertex], states[copy]) = (weakest, weakest);
        }
        states
    }

    /// Displaces the vertices by new states; the faces with a moved child, ascending. None if no state is new.
    pub fn displace(&mut self, states: IdVec<VertexId, State>) -> Option<Vec<FaceId>> {
        if states == self.states {
            return None;
        }
        let mut points = self.points.clone();
        for v in states.ids().filter(|&v| states[v] != self.states[v]) {
            points[v] = self.input.point(v, states[v]).unwrap_or(points[v]);
        }
        Some(self.move_to(states, points))
    }

    /// Moves the cage; the faces with a moved child, ascending.
    pub fn move_to(&mut self, states: IdVec<VertexId, State>, points: IdVec<VertexId, Vec3>) -> Vec<FaceId> {
        let (old, new) = ((&self.states, &self.points), (&states, &points));
        let vertices: Vec<VertexId> =
            points.ids().filter(|&v| differs(old, new, v) && points[v] != self.points[v]).collect();
        (self.states, self.points) = (states, points);
        let moved = self.faces.update(&self.points, &vertices);
        if self.uses_reference {
            // Faces that the solver has moved may be folded within their plane.
            self.faces.mark_overlapping(&moved);
        }
        if let Some(ahead) = &mut self.ahead {
            ahead.update(&self.faces, &moved);
        }
        moved
    }

    /// The cage as it is, with its faults.
    pub fn candidate(&self, faults: Vec<Fault>) -> Candidate {
        Candidate { states: self.states.clone(), points: self.points.clone(), faults }
    }

    /// Moves the cage to the best candidate for each part. The last candidate is the cage as it is, unless no work is left to
    /// know its faults.
    pub fn take_best(&mut self, mut candidates: Vec<Candidate>) -> Candidate {
        if !self.work.is_over()
            && let Some(last) = candidates.last()
            && let Some(best) = combined(self.topology(), &candidates, self.input.copy_pairs)
        {
            let known = last.faults.clone();
            let moved = self.move_to(best.states, best.points);
            candidates.extend(self.faults_after(&known, &moved).map(|faults| self.candidate(faults)));
        }
        let best = candidates.into_iter().min_by_key(Candidate::count).expect("one candidate at least");
        self.move_to(best.states.clone(), best.points.clone());
        best
    }

    /// All faults after some faces have moved, where some were known before; none beyond the bound of work.
    pub fn faults_after(&mut self, known: &[Fault], moved: &[FaceId]) -> Option<Vec<Fault>> {
        let is_moved = |face: &FaceId| moved.binary_search(face).is_ok();
        let known_moved = known.iter().flatten().copied().filter(is_moved);
        let active = each_once(self.doubtful(moved).into_iter().chain(known_moved).collect());
        let is_inactive = |fault: &&Fault| fault.iter().all(|face| active.binary_search(face).is_err());
        let mut faults: Vec<Fault> = known.iter().filter(is_inactive).copied().collect();
        faults.extend(self.intersecting(&active));
        faults.extend(self.flipped(&active).into_iter().map(|face| [face; 2]));
        if let Some(ahead) = &self.ahead {
            faults.extend(ahead.faults(&self.faces, moved, &self.work));
        }
        (!self.work.is_over()).then_some(faults)
    }

    /// The faces among `faces` that may have a fault: another layer is near them, or they are not smooth.
    pub fn doubtful(&self, faces: &[FaceId]) -> Vec<FaceId> {
        faces.iter().copied().filter(|&face| self.input.near[face] || !self.faces.is_smooth(face)).collect()
    }

    /// Pairs of intersecting faces with an active one, except for those whose parents intersect.
    fn intersecting(&mut self, active: &[FaceId]) -> Vec<Fault> {
        let mut pairs = self.faces.intersecting_pairs(active, &self.work);
        if !self.work.take(TEST * pairs.len()) {
            return pairs;
        }
        self.add_parents(pairs.iter().flatten());
        let parent = |face| self.input.derivation.parent_face(face);
        pairs.retain(|&[f, g]| !self.parent_faces.intersect(parent(f), parent(g)));
        pairs
    }

    /// Flipped faces, except for those without a reference normal whose parents are flipped too.
    fn flipped(&mut self, active: &[FaceId]) -> Vec<FaceId> {
        let mut flipped = self.faces.flipped(active, &self.directions);
        self.add_parents(flipped.iter());
        flipped.retain(|&face| {
            let parent = self.input.derivation.parent_face(face);
            let has_reference = self.uses_reference && self.input.reference_normals[face] != Vec3::ZERO;
            has_reference || !self.parent_faces.is_flipped(parent, self.parent_faces.normal(parent), FLIPPED_BEFORE)
        });
        flipped
    }

    fn add_parents<'f>(&mut self, faces: impl Iterator<Item = &'f FaceId>) {
        let parents = faces.map(|&face| self.input.derivation.parent_face(face));
        self.parent_faces.add(self.input.parent_points, parents);
    }

    /// Twice the area of a face by the operator's weights alone, along its direction.
    pub fn wanted_area(&self, face: FaceId) -> Vec3 {
        twice_area(self.topology().faces.vertices_of(face), self.input.unfitted).length() * self.directions[face]
    }
}

/// The flipped faces among faults.
pub fn flipped(faults: &[Fault]) -> Vec<FaceId> {
    faults.iter().filter(|[f, g]| f == g).map(|fault| fault[0]).collect()
}

/// The faces of faults, each once, ascending.
pub fn faces_of(faults: &[Fault]) -> Vec<FaceId> {
    each_once(faults.iter().flatten().copied().collect())
}
