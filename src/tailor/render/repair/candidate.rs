//! States of a cage that are tried, and the best of them for each connected part.
//!
//! A change may repair one place and spoil another, as beside the free border of a layer. So each connected part of what
//! differs between candidates takes the candidate with the fewest faults there.

use glam::Vec3;
use std::collections::BTreeMap;
use tailor_mesh::connectivity::{FaceId, Groups, IdVec, Topology, VertexId};

/// Two faces that intersect, or a face twice that is flipped or intersects itself.
pub type Fault = [FaceId; 2];

/// How a vertex is displaced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum State {
    /// By its height, fitted to the limit surface.
    Full,
    /// By the least height and [`super::REDUCED`] of the rest.
    Reduced,
    /// By the least height.
    Least,
    /// By the least height, fitted along normals alone.
    Upright,
    /// By the least height, without the fit.
    Unfitted,
    /// To a point that a solver has found.
    Moved,
}

impl State {
    /// The next weaker displacement.
    pub fn weaker(self) -> Self {
        match self {
            Self::Full => Self::Reduced,
            Self::Reduced => Self::Least,
            Self::Least => Self::Upright,
            Self::Upright | Self::Unfitted | Self::Moved => Self::Unfitted,
        }
    }
}

/// A cage that is tried.
#[derive(Clone, Debug, Default)]
pub struct Candidate {
    pub states: IdVec<VertexId, State>,
    pub points: IdVec<VertexId, Vec3>,
    pub faults: Vec<Fault>,
}

/// Intersections and flipped faces. Fewer intersections are better than fewer flipped faces.
type Count = [usize; 2];

impl Candidate {
    pub fn count(&self) -> Count {
        self.faults.iter().fold([0; 2], |sum, fault| add(sum, count(fault)))
    }
}

/// The states of vertices and where they are.
type Posed<'a> = (&'a IdVec<VertexId, State>, &'a IdVec<VertexId, Vec3>);

/// Whether a vertex is displaced differently. States other than [`State::Moved`] have one point.
pub fn differs((states, points): Posed, (other_states, other_points): Posed, v: VertexId) -> bool {
    states[v] != other_states[v] || states[v] == State::Moved && points[v] != other_points[v]
}

fn count([f, g]: &Fault) -> Count {
    if f == g { [0, 1] } else { [1, 0] }
}

fn add(a: Count, b: Count) -> Count {
    [a[0] + b[0], a[1] + b[1]]
}

/// A candidate, without faults, that has in each part the best of all, the first of equals. None where one of them is as
/// good everywhere. `copies` are vertices that belong to one part.
pub fn combined(t: &Topology, candidates: &[Candidate], copies: &[[VertexId; 2]]) -> Option<Candidate> {
    let ([first, ..], Some(last)) = (candidates, candidates.last()) else { return None };
    let differs = |v| differs((&first.states, &first.points), (&last.states, &last.points), v);
    let of_fault = |fault: &Fault| fault.map(|f| t.faces.vertices_of(f)).into_iter().flatten().copied();
    let mut parts: Groups<VertexId> = Groups::new(first.states.len());
    let mut join = |vertices: &mut dyn Iterator<Item = VertexId>| {
        let mut vertices = vertices.filter(|&v| differs(v));
        let Some(one) = vertices.next() else { return };
        vertices.for_each(|v| _ = parts.join(one, v));
    };
    let faces = first.states.ids().filter(|&v| differs(v)).flat_map(|v| t.faces_at(v));
    faces.for_each(|face| join(&mut t.faces.vertices_of(face).iter().copied()));
    copies.iter().for_each(|pair| join(&mut pair.iter().copied()));
    candidates.iter().flat_map(|of| &of.faults).for_each(|fault| join(&mut of_fault(fault)));
    // For each part, by its first vertex, the faults of each candidate.
    let mut counts: BTreeMap<VertexId, Vec<Count>> = BTreeMap::new();
    for (i, candidate) in candidates.iter().enumerate() {
        for fault in &candidate.faults {
            if let Some(v) = of_fault(fault).find(|&v| differs(v)) {
                let of_part = counts.entry(parts.first(v)).or_insert_with(|| vec![[0; 2]; candidates.len()]);
                of_part[i] = add(of_part[i], count(fault));
            }
        }
    }
    let total = |i: usize| counts.values().map(|of_part| of_part[i]).fold([0; 2], add);
    let least = counts.values().filter_map(|of_part| of_part.iter().min()).copied().fold([0; 2], add);
    if (0..candidates.len()).any(|i| total(i) == least) {
        return None;
    }
    let best = |of_part: &Vec<Count>| (0..candidates.len()).min_by_key(|&i| of_part[i]).map(|i| &candidates[i]);
    let choice: BTreeMap<VertexId, &Candidate> =
        counts.iter().filter_map(|(&part, of_part)| Some((part, best(of_part)?))).collect();
    let mut combined = Candidate { faults: Vec::new(), ..first.clone() };
    for v in first.states.ids() {
        if let Some(best) = choice.get(&parts.first(v)) {
            (combined.states[v], combined.points[v]) = (best.states[v], best.points[v]);
        }
    }
    Some(combined)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tailor_mesh::connectivity::Faces;

    #[test]
    fn each_part_has_the_candidate_that_is_best_there() {
        // A row of nine quads; a change at one end does not affect the other.
        let corners = (0..9).flat_map(|i| [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1]).map(VertexId::new);
        let t = Topology::new(Faces::quads(corners.collect::<Vec<_>>()), 20);
        let [start, end] = [0, 8].map(|f| [FaceId::new(f); 2]);
        let [full, reduced, least] = [State::Full, State::Reduced, State::Least];
        let states = |of_start, of_end| (0..20).map(|v| [of_start, full, of_end][v / 7]).collect::<IdVec<_, _>>();
        let candidate = |of_start, of_end, faults: &[Fault]| Candidate {
            states: states(of_start, of_end),
            points: IdVec::filled(Vec3::ZERO, 20),
            faults: faults.to_vec(),
        };
        let best = |all: &[Candidate], copies: &[[VertexId; 2]]| combined(&t, all, copies).map(|best| best.states);
        // The second candidate repairs the end, the third spoils it and repairs the start.
        let all = [
            candidate(full, full, &[start, end]),
            candidate(reduced, reduced, &[end]),
            candidate(least, least, &[start]),
        ];
        assert_eq!(best(&all, &[]), Some(states(reduced, least)));
        // Not where both ends belong together, nor where one candidate is as good.
        assert_eq!(best(&all, &[[VertexId::new(0), VertexId::new(19)]]), None);
        assert_eq!(best(&all[..2], &[]), None);
        assert_eq!(best(&[], &[]), None);
        // Two flipped faces are better than one intersection.
        let intersecting = [FaceId::new(0), FaceId::new(1)];
        let all = [candidate(full, full, &[start, start, end]), candidate(reduced, reduced, &[intersecting])];
        assert_eq!(best(&all, &[]), Some(states(full, reduced)));
        assert_eq!(best(&[candidate(full, full, &[start, end]), candidate(reduced, reduced, &[])], &[]), None);
    }
}
