//! Which step each part of a mesh is best left at.
//!
//! A step back may mend one place and spoil another, as beside the free border of a layer. So where steps differ, each
//! connected part has the one with the fewest faults there.

use crate::mesh::{FaceId, Groups, IdVec, Topology, VertexId};
use std::collections::BTreeMap;

/// A state of a mesh while it is mended.
pub struct Tried {
    /// How far each vertex had stepped back.
    pub steps: IdVec<VertexId, u8>,
    /// Pairs of faces that crossed, and faces with themselves that were turned over.
    pub pairs: Vec<[FaceId; 2]>,
}

impl Tried {
    /// How many pairs cross and how many faces are turned over; one is better than another where fewer cross.
    pub fn faults(&self) -> [usize; 2] {
        self.pairs.iter().fold([0; 2], |count, pair| sum(count, fault(pair)))
    }
}

/// What a pair counts for.
fn fault([f, g]: &[FaceId; 2]) -> [usize; 2] {
    if f == g { [0, 1] } else { [1, 0] }
}

fn sum(a: [usize; 2], b: [usize; 2]) -> [usize; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

/// The steps of the best of each part; `together` are vertices that keep together. None where one state is as good.
pub fn best_of_each(t: &Topology, tried: &[Tried], together: &[[VertexId; 2]]) -> Option<IdVec<VertexId, u8>> {
    let ([first, ..], Some(last)) = (tried, tried.last()) else { return None };
    let differs = |v: VertexId| first.steps[v] != last.steps[v];
    let of_pair = |[a, b]: &[FaceId; 2]| [*a, *b].map(|f| t.faces.vertices_of(f)).into_iter().flatten().copied();
    let mut parts: Groups<VertexId> = Groups::new(first.steps.len());
    let mut join = |vertices: &mut dyn Iterator<Item = VertexId>| {
        let mut vertices = vertices.filter(|&v| differs(v));
        let Some(one) = vertices.next() else { return };
        vertices.for_each(|v| _ = parts.join(one, v));
    };
    let near = first.steps.ids().filter(|&v| differs(v)).flat_map(|v| t.faces_at(v));
    near.for_each(|face| join(&mut t.faces.vertices_of(face).iter().copied()));
    together.iter().for_each(|pair| join(&mut pair.iter().copied()));
    tried.iter().flat_map(|state| &state.pairs).for_each(|pair| join(&mut of_pair(pair)));
    // For each part, by its first vertex, the faults of each state.
    let mut faults: BTreeMap<VertexId, Vec<[usize; 2]>> = BTreeMap::new();
    for (state, of_state) in tried.iter().enumerate() {
        for pair in &of_state.pairs {
            if let Some(v) = of_pair(pair).find(|&v| differs(v)) {
                let of_part = faults.entry(parts.first(v)).or_insert_with(|| vec![[0; 2]; tried.len()]);
                of_part[state] = sum(of_part[state], fault(pair));
            }
        }
    }
    let best = |counts: &Vec<[usize; 2]>| (0..tried.len()).min_by_key(|&state| counts[state]).unwrap_or(0);
    let choice: BTreeMap<VertexId, usize> = faults.iter().map(|(&part, counts)| (part, best(counts))).collect();
    let total = |state: usize| faults.values().map(|counts| counts[state]).fold([0; 2], sum);
    let fewest = faults.values().filter_map(|counts| counts.iter().min()).copied().fold([0; 2], sum);
    if (0..tried.len()).any(|state| total(state) == fewest) {
        return None;
    }
    let steps = |v: VertexId| choice.get(&parts.first(v)).map_or(first, |&state| &tried[state]).steps[v];
    Some(first.steps.ids().map(steps).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Faces;

    #[test]
    fn each_part_has_the_state_that_is_best_there() {
        // A row of nine quads; what is done at one end has nothing to do with the other.
        let corners = (0..9).flat_map(|i| [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1]).map(VertexId::new);
        let t = Topology::new(Faces::quads(corners.collect::<Vec<_>>()), 20);
        let [start, end] = [0, 8].map(|f| [FaceId::new(f); 2]);
        let steps = |of_start: u8, of_end: u8| (0..20).map(|v| [of_start, 0, of_end][v / 7]).collect();
        let state =
            |of_start, of_end, pairs: &[[FaceId; 2]]| Tried { steps: steps(of_start, of_end), pairs: pairs.to_vec() };
        // The second step mends the end and spoils the start.
        let tried = [state(0, 0, &[start, end]), state(1, 1, &[end]), state(2, 2, &[start])];
        assert_eq!(best_of_each(&t, &tried, &[]), Some(steps(1, 2)));
        // Not where both ends keep together, nor where one state is as good.
        assert_eq!(best_of_each(&t, &tried, &[[VertexId::new(0), VertexId::new(19)]]), None);
        assert_eq!(best_of_each(&t, &tried[..2], &[]), None);
        assert_eq!(best_of_each(&t, &[], &[]), None);
        // Two that are turned over are better than one pair that crosses.
        let crossing = [FaceId::new(0), FaceId::new(1)];
        let tried = [state(0, 0, &[start, start, end]), state(1, 1, &[crossing])];
        assert_eq!(best_of_each(&t, &tried, &[]), Some(steps(0, 1)));
        assert_eq!(best_of_each(&t, &[state(0, 0, &[start, end]), state(1, 1, &[])], &[]), None);
    }
}
