//! The points of lines as weighted sums of the parent's vertices.

use super::ribs::{Path, Rib};
use tailor_mesh::connectivity::{CornerId, Topology, VertexId};

/// The sources of a point with their weights.
pub type Sources = Vec<(VertexId, f32)>;

/// The sources of the point at a step of a rib.
pub fn weights(t: &Topology, rib: &Rib, step: f32) -> Sources {
    match rib.path {
        Path::Edge { to, part } => vec![(rib.vertex, 1.0 - part * step), (to, part * step)],
        Path::Across { corner, part } => {
            let part = part * step;
            let face = t.faces.face_of(corner);
            let others = 1.0 / (t.faces.valence(face) - 1) as f32;
            let weight = |c| if c == corner { 1.0 - part } else { part * others };
            t.faces.corners_of(face).map(|c| (t.faces.vertex(c), weight(c))).collect()
        }
        Path::Face { corner, after, before } => grid_point(t, corner, after * step, before * step),
    }
}

/// The sources of the point in the face of a corner at shares `x` of the edge after it and `y` of the edge before it.
pub fn grid_point(t: &Topology, corner: CornerId, x: f32, y: f32) -> Sources {
    let (next, prev) = (t.faces.next(corner), t.faces.prev(corner));
    let at = |c| t.faces.vertex(c);
    if t.faces.valence(t.faces.face_of(corner)) != 4 {
        return vec![(at(corner), 1.0 - x - y), (at(next), x), (at(prev), y)];
    }
    let opposite = t.faces.next(next);
    vec![
        (at(corner), (1.0 - x) * (1.0 - y)),
        (at(next), x * (1.0 - y)),
        (at(opposite), x * y),
        (at(prev), (1.0 - x) * y),
    ]
}

/// The sources of the point at a share of the way between two points.
pub fn between(from: &Sources, to: &Sources, share: f32) -> Sources {
    let mut sources: Sources = from.iter().map(|&(v, weight)| (v, (1.0 - share) * weight)).collect();
    for &(vertex, weight) in to {
        match sources.iter_mut().find(|(v, _)| *v == vertex) {
            Some((_, known)) => *known += share * weight,
            None => sources.push((vertex, share * weight)),
        }
    }
    sources
}
