//! Which faces a second layer can cover.

use crate::mesh::{FaceId, Groups, IdVec, Topology, VertexId};
use std::collections::BTreeSet;

/// Room as a share of the layer's distance below which there is none: another part of the garment lies on the surface.
const NONE: f32 = 0.02;
/// The same below which faces next to such a place have none either. Smaller makes layers that end so near to the surface
/// that they cross it; larger leaves out more of them.
const NARROW: f32 = 0.6;

/// The faces of a second layer, and those that cannot have one.
pub struct Cover {
    /// Whether each face has one.
    pub chosen: IdVec<FaceId, bool>,
    /// Faces beside some that look the other way, where the layer would have to pass through the surface.
    pub turned: Left,
    /// Faces that another part of the garment lies on, with those around as far as there is little room.
    pub tight: Left,
    /// Faces that the others cut off from the border, so that there is nothing to fold over.
    pub cut_off: Left,
}

/// Faces that have no second layer.
#[derive(Default)]
pub struct Left {
    /// The faces.
    pub faces: Vec<FaceId>,
    /// Their vertices at which it cannot be.
    pub at: BTreeSet<VertexId>,
}

impl Cover {
    /// What of the chosen faces can be covered, where `room` is how far a layer may go at a vertex, as a share of how far
    /// it is to go. Where it `is_closed`, a layer may be without a fold at a border.
    pub fn new(t: &Topology, asked: &IdVec<FaceId, bool>, is_closed: bool, room: impl Fn(VertexId) -> f32) -> Self {
        let mut chosen = asked.clone();
        let turns = turning_over(t);
        let turned = Left::taken(t, &mut chosen, |v| turns[v]);
        let mut tight = Left::taken(t, &mut chosen, |v| room(v) < NONE);
        let mut next = 0;
        while next < tight.faces.len() {
            for &v in t.faces.vertices_of(tight.faces[next]) {
                if room(v) < NARROW && tight.at.insert(v) {
                    tight.faces.extend(t.faces_at(v).filter(|&f| std::mem::replace(&mut chosen[f], false)));
                }
            }
            next += 1;
        }
        let mut cut_off = Left::default();
        if !is_closed && chosen != *asked {
            let (before, after) = (at_border(t, asked), at_border(t, &chosen));
            cut_off.faces = chosen.ids().filter(|&f| chosen[f] && before[f] && !after[f]).collect();
            cut_off.at = cut_off.faces.iter().flat_map(|&f| t.faces.vertices_of(f)).copied().collect();
            cut_off.faces.iter().for_each(|&f| chosen[f] = false);
        }
        Self { chosen, turned, tight, cut_off }
    }
}

impl Left {
    /// Takes the faces at some vertices out of the chosen ones.
    fn taken(t: &Topology, chosen: &mut IdVec<FaceId, bool>, is_at: impl Fn(VertexId) -> bool) -> Self {
        let bad = |f: FaceId| t.faces.vertices_of(f).iter().copied().filter(|&v| is_at(v));
        let faces: Vec<FaceId> = chosen.ids().filter(|&f| chosen[f] && bad(f).next().is_some()).collect();
        faces.iter().for_each(|&f| chosen[f] = false);
        Self { at: faces.iter().flat_map(|&f| bad(f)).collect(), faces }
    }
}

/// The chosen faces that are joined to the border of the mesh, by others if not themselves.
fn at_border(t: &Topology, chosen: &IdVec<FaceId, bool>) -> IdVec<FaceId, bool> {
    let mut groups: Groups<FaceId> = Groups::new(chosen.len());
    let mut is_at_border = IdVec::filled(false, chosen.len());
    for edge in t.edges.ids() {
        let mut faces = t.edge_corners.row(edge).iter().map(|&c| t.faces.face_of(c)).filter(|&f| chosen[f]);
        let Some(face) = faces.next() else { continue };
        is_at_border[face] |= t.is_border(edge);
        faces.for_each(|other| _ = groups.join(face, other));
    }
    let mut joined = IdVec::filled(false, chosen.len());
    chosen.ids().filter(|&f| is_at_border[f]).for_each(|f| joined[groups.first(f)] = true);
    chosen.ids().map(|f| joined[groups.first(f)]).collect()
}

/// Vertices at which the second layer ends and the first goes on.
pub fn layer_ends(t: &Topology, chosen: &IdVec<FaceId, bool>) -> IdVec<VertexId, bool> {
    let mut sides = IdVec::filled([false; 2], t.vertex_count());
    for (face, chosen) in chosen.enumerated() {
        t.faces.vertices_of(face).iter().for_each(|&v| sides[v][usize::from(*chosen)] = true);
    }
    sides.iter().map(|&s| s == [true; 2]).collect()
}

/// Vertices of edges whose two faces run along them in the same direction: the front of one goes on as the back of the
/// other.
fn turning_over(t: &Topology) -> IdVec<VertexId, bool> {
    let mut turns = IdVec::filled(false, t.vertex_count());
    for edge in t.edges.ids() {
        if let &[a, b] = t.edge_corners.row(edge)
            && t.faces.vertex(a) == t.faces.vertex(b)
        {
            t.edges[edge].iter().for_each(|&v| turns[v] = true);
        }
    }
    turns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Faces;

    /// A row of quads; vertices `2 i` and `2 i + 1` are at its places from one end to the other.
    fn row(count: usize) -> Topology {
        let quads = (0..count).flat_map(|i| [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1]).map(VertexId::new);
        let corners: Vec<VertexId> = quads.collect();
        Topology::new(Faces::mixed(vec![4; count], corners), 2 * count + 2)
    }

    fn numbers(faces: &[FaceId]) -> Vec<usize> {
        faces.iter().map(|f| f.index()).collect()
    }

    #[test]
    fn a_layer_ends_where_there_is_room_for_its_end() {
        let (t, all) = (row(8), IdVec::filled(true, 8));
        // None at one end, ever more to the other; little in the middle alone is no reason.
        let rooms = [0.0, 0.3, 0.5, 0.9, 2.0, 0.3, 2.0, 2.0, 2.0];
        let cover = Cover::new(&t, &all, false, |v| rooms[v.index() / 2]);
        assert_eq!(numbers(&cover.tight.faces), [0, 1, 2]);
        assert_eq!(cover.tight.at.iter().map(|v| v.index()).collect::<Vec<_>>(), [0, 1, 2, 3, 4, 5]);
        assert!(cover.turned.faces.is_empty());
        assert_eq!(cover.chosen.iter().filter(|&&chosen| chosen).count(), 5);
        let none = Cover::new(&t, &all, false, |_| f32::INFINITY);
        assert!(none.tight.faces.is_empty() && none.chosen.iter().all(|&chosen| chosen));
    }

    #[test]
    fn faces_that_were_not_chosen_are_not_counted() {
        let t = row(4);
        let chosen = [false, false, true, true].into_iter().collect();
        let cover = Cover::new(&t, &chosen, false, |_| 0.0);
        assert_eq!(numbers(&cover.tight.faces), [2, 3]);
        assert!(cover.chosen.iter().all(|&chosen| !chosen));
    }

    #[test]
    fn what_is_cut_off_from_the_border_is_left_out_unless_it_may_be_closed() {
        let n = 6;
        let at = |x: usize, y: usize| (n + 1) * y + x;
        let quad = |i: usize| {
            let (x, y) = (i % n, i / n);
            [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]
        };
        let corners: Vec<VertexId> = (0..n * n).flat_map(quad).map(VertexId::new).collect();
        let t = Topology::new(Faces::quads(corners), (n + 1) * (n + 1));
        let is_border = |v: VertexId| [v.index() % (n + 1), v.index() / (n + 1)].iter().any(|&i| i == 0 || i == n);
        let room = |v: VertexId| if is_border(v) { 0.0 } else { 2.0 };
        let all = IdVec::filled(true, n * n);
        let left = |is_closed| {
            let cover = Cover::new(&t, &all, is_closed, room);
            [&cover.tight, &cover.cut_off].map(|left| (left.faces.len(), left.at.len()))
        };
        let (rim, middle) = ((4 * (n - 1), 4 * n), ((n - 2) * (n - 2), (n - 1) * (n - 1)));
        assert_eq!((left(false), left(true)), ([rim, middle], [rim, (0, 0)]));
        // Nothing was taken from what has no border from the start.
        let middle: IdVec<FaceId, bool> = (0..n * n).map(|i| i == n + 1).collect();
        let room = |v: VertexId| if v.index() == 0 { 0.0 } else { 2.0 };
        let both: IdVec<FaceId, bool> = (0..n * n).map(|i| i == 0 || i == n + 1).collect();
        assert!(Cover::new(&t, &middle, false, |_| 2.0).cut_off.faces.is_empty());
        assert_eq!(Cover::new(&t, &both, false, room).chosen.iter().filter(|&&chosen| chosen).count(), 1);
    }
}
