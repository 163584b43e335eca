//! Which faces a second layer can cover.

use crate::mesh::{FaceId, IdVec, Topology, VertexId};
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
}

/// Faces that have no second layer.
pub struct Left {
    /// The faces.
    pub faces: Vec<FaceId>,
    /// Their vertices at which it cannot be.
    pub at: BTreeSet<VertexId>,
}

impl Cover {
    /// What of the chosen faces can be covered, where `room` is how far a layer may go at a vertex, as a share of how far
    /// it is to go.
    pub fn new(t: &Topology, mut chosen: IdVec<FaceId, bool>, room: impl Fn(VertexId) -> f32) -> Self {
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
        Self { chosen, turned, tight }
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
