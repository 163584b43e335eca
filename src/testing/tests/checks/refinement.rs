//! Refinements against independent rules: counts, children of subsets, and points where no sharpness takes part.

use super::product::{REFINED, agrees, fans};
use glam::Vec3;
use std::collections::BTreeSet;
use tailor_mesh::connectivity::{CornerId, EdgeId, FaceId, Topology, VertexId};
use tailor_mesh::garment::{BoundaryInterpolation, Elements, Mesh, Scheme};

/// The faults of a refinement: counts, face points, edge-free smooth points, borders, subsets.
pub fn refinement_faults(cage: &Mesh, child: &Mesh) -> Vec<String> {
    let mut faults = Vec::new();
    let t = Topology::new(cage.faces.clone(), cage.points.len());
    let corners = cage.faces.corners().len();
    let is_loop = cage.rules.scheme == Scheme::Loop;
    let faces = if is_loop { 4 * cage.faces.len() } else { corners };
    if child.faces.len() != faces {
        return vec![format!("{} faces instead of {faces}", child.faces.len())];
    }
    let points = cage.points.len() + t.edges.len() + if is_loop { 0 } else { cage.faces.len() };
    if child.points.len() != points {
        faults.push(format!("{} points instead of {points}", child.points.len()));
    }
    let valence = if is_loop { 3 } else { 4 };
    if let Some(face) = child.faces.ids().find(|&f| child.faces.valence(f) != valence) {
        faults.push(format!("{face:?} has {} corners", child.faces.valence(face)));
    }
    for subset in cage.subsets.iter() {
        let (Elements::Faces(from), Some(Elements::Faces(to))) =
            (&subset.elements, child.subset(&subset.name).map(|s| &s.elements))
        else {
            continue;
        };
        let children = |f: &FaceId| if is_loop { 4 * f.index()..4 * f.index() + 4 } else { cage.faces.range(*f) };
        let wanted: BTreeSet<usize> = from.iter().flat_map(children).collect();
        if wanted != to.iter().map(|f| f.index()).collect() {
            faults.push(format!("{} does not hold the children of its faces", subset.name));
        }
    }
    if cage.rules.scheme == Scheme::CatmullClark {
        faults.extend(catmull_clark_faults(cage, child, &t));
    }
    faults
}

/// Compares the points of a refinement with the rules of Catmull and Clark, where no sharpness takes part.
fn catmull_clark_faults(cage: &Mesh, child: &Mesh, t: &Topology) -> Vec<String> {
    let p = |v: VertexId| cage.points[v];
    let (low, high) = cage.points.iter().fold((Vec3::MAX, Vec3::MIN), |(l, h), &p| (l.min(p), h.max(p)));
    let slack = REFINED * (low.distance(high) + high.abs().max_element());
    // The child face of each corner has the same number; the wanted point is one of its four.
    let has = |c: CornerId, wanted: Vec3| {
        child.faces.vertices_of(FaceId::new(c.index())).iter().any(|&v| child.points[v].distance(wanted) <= slack)
    };
    let mean = |f: FaceId| {
        let vertices = t.faces.vertices_of(f);
        vertices.iter().map(|&v| p(v)).sum::<Vec3>() / vertices.len() as f32
    };
    let mut faults = Vec::new();
    for c in t.faces.corners().ids() {
        let f = t.faces.face_of(c);
        if !has(c, mean(f)) {
            faults.push(format!("{f:?} has no point at its centre {}", mean(f)));
        }
    }
    let sharp: BTreeSet<VertexId> = cage
        .creases
        .iter()
        .flat_map(|c| c.vertices.iter().copied())
        .chain(cage.corners.iter().map(|c| c.vertex))
        .collect();
    let all_fans = fans(t);
    for v in (0..t.vertex_count()).map(VertexId::new) {
        let corners = t.vertex_corners.row(v);
        let edges: BTreeSet<EdgeId> =
            corners.iter().flat_map(|&c| [t.corner_edge[c], t.corner_edge[t.faces.prev(c)]]).collect();
        let odd = sharp.contains(&v) || corners.is_empty() || all_fans[&v] != 1 || !edges.iter().all(|&e| agrees(t, e));
        if odd || cage.rules.boundary == BoundaryInterpolation::None {
            continue;
        }
        let other = |e: EdgeId| t.edges[e].into_iter().find(|&w| w != v).map_or(p(v), p);
        let border: Vec<EdgeId> = edges.iter().copied().filter(|&e| t.is_border(e)).collect();
        let wanted = match border.as_slice() {
            [] => {
                let n = corners.len() as f32;
                let around = corners.iter().map(|&c| mean(t.faces.face_of(c))).sum::<Vec3>() / n;
                let middle = edges.iter().map(|&e| p(v).midpoint(other(e))).sum::<Vec3>() / n;
                (around + 2.0 * middle + (n - 3.0) * p(v)) / n
            }
            _ if corners.len() == 1 && cage.rules.boundary == BoundaryInterpolation::EdgeAndCorner => p(v),
            &[a, b] => 0.75 * p(v) + 0.125 * (other(a) + other(b)),
            _ => continue,
        };
        if !has(corners[0], wanted) {
            faults.push(format!("{v:?} does not go to {wanted}"));
        }
    }
    faults
}
