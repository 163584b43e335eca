//! The faces that a second layer can cover.
//!
//! Three kinds of chosen faces are omitted: faces at edges between opposite windings, faces without clearance and their
//! narrow surroundings, and faces that these separate from the border.

use std::collections::BTreeSet;
use tailor_mesh::connectivity::{FaceId, Groups, IdVec, Topology, VertexId};

/// Clearance, as a share of the layers' distance, below which other cloth lies on the surface.
const MIN_CLEARANCE: f32 = 0.02;
/// Clearance below which faces connected to such vertices are omitted too. A smaller value ends layers so close to the
/// other cloth that they intersect it; a larger one omits more faces.
const LOW_CLEARANCE: f32 = 0.6;

/// The faces of a second layer, and the faces without one.
pub struct Cover {
    /// True for faces with a second layer.
    pub chosen: IdVec<FaceId, bool>,
    /// Faces next to faces of opposite winding, where the layer would have to pass through the surface.
    pub turned: OmittedFaces,
    /// Faces that other cloth lies against, and connected faces of low clearance.
    pub tight: OmittedFaces,
    /// Faces that the omitted ones separate from the border, which leaves no edge to fold over.
    pub cut_off: OmittedFaces,
}

/// Faces without a second layer.
#[derive(Default)]
pub struct OmittedFaces {
    /// The faces.
    pub faces: Vec<FaceId>,
    /// Their vertices that cannot have a copy.
    pub at: BTreeSet<VertexId>,
}

impl Cover {
    /// The cover of the faces `asked`. `clearance` is that of a vertex as a share of the layers' distance there. A
    /// layer that is `closed` needs no border.
    pub fn new(t: &Topology, asked: &IdVec<FaceId, bool>, closed: bool, clearance: impl Fn(VertexId) -> f32) -> Self {
        let mut chosen = asked.clone();
        let opposed = opposite_windings(t);
        let turned = OmittedFaces::remove(t, &mut chosen, |v| opposed[v]);
        let mut tight = OmittedFaces::remove(t, &mut chosen, |v| clearance(v) < MIN_CLEARANCE);
        let mut next = 0;
        while next < tight.faces.len() {
            for &v in t.faces.vertices_of(tight.faces[next]) {
                if clearance(v) < LOW_CLEARANCE && tight.at.insert(v) {
                    tight.faces.extend(t.faces_at(v).filter(|&f| std::mem::replace(&mut chosen[f], false)));
                }
            }
            next += 1;
        }
        let mut cut_off = OmittedFaces::default();
        if !closed && chosen != *asked {
            let (before, after) = (reach_border(t, asked), reach_border(t, &chosen));
            cut_off.faces = chosen.ids().filter(|&f| chosen[f] && before[f] && !after[f]).collect();
            cut_off.at = cut_off.faces.iter().flat_map(|&f| t.faces.vertices_of(f)).copied().collect();
            cut_off.faces.iter().for_each(|&f| chosen[f] = false);
        }
        Self { chosen, turned, tight, cut_off }
    }
}

impl OmittedFaces {
    /// Removes the chosen faces with an obstructed vertex.
    fn remove(t: &Topology, chosen: &mut IdVec<FaceId, bool>, is_obstructed: impl Fn(VertexId) -> bool) -> Self {
        let obstructed = |f: FaceId| t.faces.vertices_of(f).iter().copied().filter(|&v| is_obstructed(v));
        let faces: Vec<FaceId> = chosen.ids().filter(|&f| chosen[f] && obstructed(f).next().is_some()).collect();
        faces.iter().for_each(|&f| chosen[f] = false);
        Self { at: faces.iter().flat_map(|&f| obstructed(f)).collect(), faces }
    }
}

/// True for chosen faces that are connected to the border of the mesh through chosen faces.
fn reach_border(t: &Topology, chosen: &IdVec<FaceId, bool>) -> IdVec<FaceId, bool> {
    let mut groups: Groups<FaceId> = Groups::new(chosen.len());
    let mut is_at_border = IdVec::filled(false, chosen.len());
    for edge in t.edges.ids() {
        let mut faces = t.edge_corners.row(edge).iter().map(|&c| t.faces.face_of(c)).filter(|&f| chosen[f]);
        let Some(face) = faces.next() else { continue };
        is_at_border[face] |= t.is_border(edge);
        faces.for_each(|other| _ = groups.join(face, other));
    }
    let mut reaches = IdVec::filled(false, chosen.len());
    chosen.ids().filter(|&f| is_at_border[f]).for_each(|f| reaches[groups.first(f)] = true);
    chosen.ids().map(|f| reaches[groups.first(f)]).collect()
}

/// True for vertices where the second layer ends and the first continues.
pub fn layer_ends(t: &Topology, chosen: &IdVec<FaceId, bool>) -> IdVec<VertexId, bool> {
    let mut touched = IdVec::filled([false; 2], t.vertex_count());
    for (face, chosen) in chosen.enumerated() {
        t.faces.vertices_of(face).iter().for_each(|&v| touched[v][usize::from(*chosen)] = true);
    }
    touched.iter().map(|&both| both == [true; 2]).collect()
}

/// True for vertices of edges between two faces of opposite winding.
fn opposite_windings(t: &Topology) -> IdVec<VertexId, bool> {
    let mut opposed = IdVec::filled(false, t.vertex_count());
    for edge in t.edges.ids() {
        if let &[a, b] = t.edge_corners.row(edge)
            && t.faces.vertex(a) == t.faces.vertex(b)
        {
            t.edges[edge].iter().for_each(|&v| opposed[v] = true);
        }
    }
    opposed
}

#[cfg(test)]
mod tests {
    use super::*;
    use tailor_mesh::connectivity::Faces;

    /// A row of quads; quad `i` is between the edges of vertices `2 i, 2 i + 1` and `2 i + 2, 2 i + 3`.
    fn row(count: usize) -> Topology {
        let quads = (0..count).flat_map(|i| [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1]).map(VertexId::new);
        let corners: Vec<VertexId> = quads.collect();
        Topology::new(Faces::mixed(vec![4; count], corners), 2 * count + 2)
    }

    fn numbers(faces: &[FaceId]) -> Vec<usize> {
        faces.iter().map(|f| f.index()).collect()
    }

    #[test]
    fn a_layer_ends_where_its_clearance_is_sufficient() {
        let (t, all) = (row(8), IdVec::filled(true, 8));
        // No clearance at one end, more towards the other. A single low one in the middle is accepted.
        let clearances = [0.0, 0.3, 0.5, 0.9, 2.0, 0.3, 2.0, 2.0, 2.0];
        let cover = Cover::new(&t, &all, false, |v| clearances[v.index() / 2]);
        assert_eq!(numbers(&cover.tight.faces), [0, 1, 2]);
        assert_eq!(cover.tight.at.iter().map(|v| v.index()).collect::<Vec<_>>(), [0, 1, 2, 3, 4, 5]);
        assert!(cover.turned.faces.is_empty());
        assert_eq!(cover.chosen.iter().filter(|&&chosen| chosen).count(), 5);
        let none = Cover::new(&t, &all, false, |_| f32::INFINITY);
        assert!(none.tight.faces.is_empty() && none.chosen.iter().all(|&chosen| chosen));
    }

    #[test]
    fn only_chosen_faces_are_counted() {
        let t = row(4);
        let chosen = [false, false, true, true].into_iter().collect();
        let cover = Cover::new(&t, &chosen, false, |_| 0.0);
        assert_eq!(numbers(&cover.tight.faces), [2, 3]);
        assert!(cover.chosen.iter().all(|&chosen| !chosen));
    }

    #[test]
    fn faces_cut_off_from_the_border_are_omitted_unless_closed() {
        let n = 6;
        let at = |x: usize, y: usize| (n + 1) * y + x;
        let quad = |i: usize| {
            let (x, y) = (i % n, i / n);
            [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]
        };
        let corners: Vec<VertexId> = (0..n * n).flat_map(quad).map(VertexId::new).collect();
        let t = Topology::new(Faces::quads(corners), (n + 1) * (n + 1));
        let is_border = |v: VertexId| [v.index() % (n + 1), v.index() / (n + 1)].iter().any(|&i| i == 0 || i == n);
        let clearance = |v: VertexId| if is_border(v) { 0.0 } else { 2.0 };
        let all = IdVec::filled(true, n * n);
        let counts = |is_closed| {
            let cover = Cover::new(&t, &all, is_closed, clearance);
            [&cover.tight, &cover.cut_off].map(|omitted| (omitted.faces.len(), omitted.at.len()))
        };
        let (rim, middle) = ((4 * (n - 1), 4 * n), ((n - 2) * (n - 2), (n - 1) * (n - 1)));
        assert_eq!((counts(false), counts(true)), ([rim, middle], [rim, (0, 0)]));
        // Faces without a border from the start are kept.
        let middle: IdVec<FaceId, bool> = (0..n * n).map(|i| i == n + 1).collect();
        let clearance = |v: VertexId| if v.index() == 0 { 0.0 } else { 2.0 };
        let both: IdVec<FaceId, bool> = (0..n * n).map(|i| i == 0 || i == n + 1).collect();
        assert!(Cover::new(&t, &middle, false, |_| 2.0).cut_off.faces.is_empty());
        assert_eq!(Cover::new(&t, &both, false, clearance).chosen.iter().filter(|&&chosen| chosen).count(), 1);
    }
}
