//! The subdivision masks of Catmull-Clark, Loop and bilinear subdivision, as weights of the parent level's corners.
//!
//! A corner names both a vertex and a face-varying value. One mask therefore serves points and face-varying primvars.
//!
//! Sources: Catmull and Clark 1978; Loop 1987; creases by DeRose, Kass and Truong 1998. Smooth triangle weights and
//! non-manifold elements follow OpenSubdiv (`sdc/catmarkScheme.h`, `sdc/loopScheme.h`).

use super::level::{Level, Rule, Spoke, refined_sharpness};
use crate::connectivity::{CornerId, EdgeId, FaceId, VertexId};
use crate::garment::{Scheme, TriangleRule};

/// Weight of a triangle's centre in the mask of its edges, under `TriangleRule::Smooth` (Niessner et al. 2012).
const SMOOTH_TRIANGLE_WEIGHT: f32 = 0.470;

/// Emits the mask of a face's centre, times `scale`.
#[inline(always)]
pub fn face(level: &Level, face: FaceId, scale: f32, sink: &mut impl FnMut(CornerId, f32)) {
    let corners = level.topology.faces.corners_of(face);
    let weight = scale / corners.len() as f32;
    corners.for_each(|c| sink(c, weight));
}

/// Emits the mask of an edge's midpoint, times `scale`.
#[inline(always)]
pub fn middle(level: &Level, edge: EdgeId, scale: f32, sink: &mut impl FnMut(CornerId, f32)) {
    let first = level.topology.edge_corners.row(edge)[0];
    sink(first, 0.5 * scale);
    sink(level.topology.faces.next(first), 0.5 * scale);
}

/// Emits the mask of the child of an edge.
#[inline(always)]
pub fn edge(level: &Level, edge: EdgeId, sink: &mut impl FnMut(CornerId, f32)) {
    let sharp = match level.scheme {
        Scheme::Bilinear | Scheme::None => 1.0,
        _ => level.edge_sharpness[edge].min(1.0),
    };
    if sharp > 0.0 {
        middle(level, edge, sharp, sink);
    }
    if sharp < 1.0 {
        match level.scheme {
            Scheme::Loop => smooth_loop_edge(level, edge, 1.0 - sharp, sink),
            _ => smooth_edge(level, edge, 1.0 - sharp, sink),
        }
    }
}

#[inline(always)]
fn smooth_edge(level: &Level, edge: EdgeId, scale: f32, sink: &mut impl FnMut(CornerId, f32)) {
    let faces = &level.topology.faces;
    let halves = level.topology.edge_corners.row(edge);
    if let (&[a, b], Some(4)) = (halves, faces.regular_valence()) {
        sink(a, 0.375 * scale);
        sink(faces.ahead(a, 1), 0.375 * scale);
        for corner in [faces.ahead(a, 2), faces.ahead(a, 3), faces.ahead(b, 2), faces.ahead(b, 3)] {
            sink(corner, 0.0625 * scale);
        }
        return;
    }
    let face_weight = smooth_edge_face_weight(level, halves);
    middle(level, edge, (1.0 - face_weight * halves.len() as f32) * scale, sink);
    for &half in halves {
        face(level, faces.face_of(half), face_weight * scale, sink);
    }
}

/// Weight of each face's centre in the mask of a smooth edge.
fn smooth_edge_face_weight(level: &Level, halves: &[CornerId]) -> f32 {
    let faces = &level.topology.faces;
    if let (TriangleRule::Smooth, &[a, b]) = (level.triangles, halves) {
        let weight = |c| if faces.valence(faces.face_of(c)) == 3 { SMOOTH_TRIANGLE_WEIGHT } else { 0.25 };
        return 0.5 * (weight(a) + weight(b));
    }
    0.5 / halves.len() as f32
}

#[inline(always)]
fn smooth_loop_edge(level: &Level, edge: EdgeId, scale: f32, sink: &mut impl FnMut(CornerId, f32)) {
    let halves = level.topology.edge_corners.row(edge);
    middle(level, edge, 0.75 * scale, sink);
    let opposite = 0.25 * scale / halves.len() as f32;
    halves.iter().for_each(|&c| sink(level.topology.faces.prev(c), opposite));
}

/// Emits the mask of the child of a vertex, which must have a face.
#[inline(always)]
pub fn vertex(level: &Level, vertex: VertexId, sink: &mut impl FnMut(CornerId, f32)) {
    let own = level.topology.vertex_corners.row(vertex)[0];
    match level.scheme {
        Scheme::Bilinear | Scheme::None => sink(own, 1.0),
        _ if level.rules[vertex].is_smooth() => smooth_vertex(level, vertex, 1.0, sink),
        _ => {
            for (corner, weight) in sharp_vertex(level, vertex, own) {
                sink(corner, weight);
            }
        }
    }
}

/// The mask of a crease or corner. If the next level has another rule, both masks are blended by the remaining
/// sharpness.
///
/// The weights are returned rather than passed to the caller's sink. This keeps the sink inlined in all other masks.
fn sharp_vertex(level: &Level, vertex: VertexId, own: CornerId) -> Vec<(CornerId, f32)> {
    let mut mask = Vec::with_capacity(4);
    let sink = &mut |corner, weight| mask.push((corner, weight));
    let rule = level.rules[vertex];
    let mut spokes = Vec::with_capacity(8);
    level.spokes(vertex, &mut spokes);
    let sharpness = level.vertex_sharpness[vertex];
    let sharpnesses = |s: &Spoke| level.edge_sharpness[s.edge];
    let refined = |s: &Spoke| refined_sharpness(sharpnesses(s));
    let child = Rule::new(refined_sharpness(sharpness), spokes.iter().map(refined));
    let ring = Ring { level, vertex, own, spokes: &spokes };
    if child == rule {
        ring.mask(rule, &sharpnesses, 1.0, sink);
        return mask;
    }
    let keep = fractional_weight(sharpness, spokes.iter().map(sharpnesses));
    if keep > 0.0 {
        ring.mask(rule, &sharpnesses, keep, sink);
    }
    if keep < 1.0 {
        ring.mask(child, &refined, 1.0 - keep, sink);
    }
    mask
}

/// A vertex and its edges.
struct Ring<'a> {
    level: &'a Level,
    vertex: VertexId,
    /// A corner of the vertex.
    own: CornerId,
    spokes: &'a [Spoke],
}

impl Ring<'_> {
    /// Emits the mask of `rule`, times `scale`. A crease runs along the spokes of positive `sharpness`.
    fn mask(&self, rule: Rule, sharpness: &dyn Fn(&Spoke) -> f32, scale: f32, sink: &mut impl FnMut(CornerId, f32)) {
        match rule {
            Rule::Smooth | Rule::Dart => smooth_vertex(self.level, self.vertex, scale, sink),
            Rule::Corner => sink(self.own, scale),
            Rule::Crease => {
                sink(self.own, 0.75 * scale);
                self.spokes.iter().filter(|s| sharpness(s) > 0.0).for_each(|s| sink(s.far, 0.125 * scale));
            }
        }
    }
}

/// Weight of the sharper mask in a level at which sharpness falls to zero: the mean of the fading sharpnesses. \[0 to
/// 1\]
pub fn fractional_weight(vertex: f32, edges: impl Iterator<Item = f32>) -> f32 {
    let fading = |s: &f32| *s > 0.0 && *s <= 1.0;
    let (sum, count) = std::iter::once(vertex)
        .filter(|&s| s > 0.0 && refined_sharpness(s) <= 0.0)
        .chain(edges.filter(fading))
        .fold((0.0, 0), |(sum, count), s| (sum + s, count + 1));
    if count == 0 { 0.0 } else { (sum / count as f32).min(1.0) }
}

#[inline(always)]
fn smooth_vertex(level: &Level, vertex: VertexId, scale: f32, sink: &mut impl FnMut(CornerId, f32)) {
    let corners = level.topology.vertex_corners.row(vertex);
    if level.scheme == Scheme::Loop {
        return smooth_loop_vertex(level, corners, scale, sink);
    }
    let faces = &level.topology.faces;
    let valence = corners.len() as f32;
    let ring = scale / (valence * valence);
    if faces.regular_valence() == Some(4) {
        sink(corners[0], scale * (valence - 1.75) / valence);
        for &corner in corners {
            sink(faces.ahead(corner, 1), 1.5 * ring);
            sink(faces.ahead(corner, 2), 0.25 * ring);
        }
        return;
    }
    sink(corners[0], scale * (valence - 2.0) / valence);
    for &corner in corners {
        sink(faces.next(corner), ring);
        face(level, faces.face_of(corner), ring, sink);
    }
}

#[inline(always)]
fn smooth_loop_vertex(level: &Level, corners: &[CornerId], scale: f32, sink: &mut impl FnMut(CornerId, f32)) {
    let valence = corners.len() as f64;
    let beta = 0.25 * (std::f64::consts::TAU / valence).cos() + 0.375;
    let ring = (0.625 - beta * beta) / valence;
    sink(corners[0], scale * (1.0 - ring * valence) as f32);
    corners.iter().for_each(|&c| sink(level.topology.faces.next(c), scale * ring as f32));
}
