//! Ridges: folds of the surface that are sharper than the target length can follow. Edges across such a fold cut it off and
//! leave it jagged, so the edges of the cage along it become chains.

use super::cage_edges::{half_edge, refine_paths};
use super::chain::{Chain, ChainKind};
use crate::mesh::edit::{next, prev};
use crate::mesh::{CornerId, EdgeId, FaceId, Groups, IdVec, Topology, VertexId};
use crate::sim::geometry::angle;
use crate::sim::surface::triangulation::RefinedSurface;
use crate::subdivide::Level;
use glam::Vec3;
use std::collections::BTreeMap;

/// A ridge is where the normal turns by more than this over one target length. Smaller values make more chains, which
/// constrain the triangles beside them; larger ones let chords cut off more of a fold. \[radians\]
const SHARP: f32 = 1.6;
/// A ridge continues where the normal still turns by this. \[radians\]
const BLUNT: f32 = 1.2;
/// Least total length of a ridge's sharp edges, as a multiple of the target length.
const LEAST_LENGTH: f32 = 2.0;
/// Parallel edges of the cage nearer than this multiple of the target length compete; the sharper one is the ridge.
const APART: f32 = 1.0;
/// Least dihedral of a candidate edge: folds are sharper on the cage than on the refined surface. \[radians\]
const LEAST_DIHEDRAL: f32 = 0.3;
/// Most triangles of a walk away from an edge.
const MAX_STEPS: usize = 64;

/// An edge of the cage that may be part of a ridge.
struct Candidate {
    edge: EdgeId,
    /// The turn of the normal across it. \[radians\]
    bend: f32,
    middle: Vec3,
    length: f32,
    target: f32,
}

/// Adds the ridges among the unconstrained edges of the cage to `kinds`. The last of `levels` is the surface's.
pub(crate) fn add_ridges(
    t: &Topology,
    levels: &[&Level],
    surface: &RefinedSurface<'_>,
    kinds: &mut BTreeMap<EdgeId, ChainKind>,
) {
    let candidates = candidates(t, levels, surface, kinds);
    let bend_of: BTreeMap<EdgeId, &Candidate> = candidates.iter().map(|c| (c.edge, c)).collect();
    let kept: Vec<&Candidate> = candidates.iter().filter(|c| is_sharpest(t, c, &bend_of)).collect();
    for piece in pieces(t, &kept) {
        let sharp: f32 = piece.iter().filter(|c| c.bend > SHARP).map(|c| c.length / c.target).sum();
        if sharp >= LEAST_LENGTH {
            kinds.extend(piece.iter().map(|c| (c.edge, ChainKind { ridge: true, ..ChainKind::default() })));
        }
    }
}

fn candidates(
    t: &Topology,
    levels: &[&Level],
    surface: &RefinedSurface<'_>,
    kinds: &BTreeMap<EdgeId, ChainKind>,
) -> Vec<Candidate> {
    let at = |v: VertexId| surface.points[v];
    let normal = |face: FaceId| {
        let vertices = t.faces.vertices_of(face);
        let origin = at(vertices[0]);
        let fan = vertices.windows(2).map(|p| (at(p[0]) - origin).cross(at(p[1]) - origin));
        fan.sum::<Vec3>().normalize_or_zero()
    };
    let normals: IdVec<FaceId, Vec3> = t.faces.ids().map(normal).collect();
    let is_bent = |&edge: &EdgeId| match *t.edge_corners.row(edge) {
        [a, b] => {
            let (m, n) = (normals[t.faces.face_of(a)], normals[t.faces.face_of(b)]);
            !kinds.contains_key(&edge) && angle(m, n) > LEAST_DIHEDRAL
        }
        _ => false,
    };
    let edges: Vec<EdgeId> = t.edges.ids().filter(is_bent).collect();
    let curves = refine_paths(edges.iter().map(|&e| t.edges[e].to_vec()).collect(), levels);
    let measured = edges.iter().zip(&curves[levels.len() - 1]).filter_map(|(&edge, curve)| {
        let steps = curve.windows(2);
        let n = steps.len() as f32;
        let bend = steps.clone().map(|p| surface.bend(p[0], p[1])).sum::<f32>() / n;
        let length = steps.map(|p| at(p[0]).distance(at(p[1]))).sum();
        let middle = curve[curve.len() / 2];
        (bend > BLUNT).then(|| Candidate { edge, bend, middle: at(middle), length, target: surface.target[middle] })
    });
    measured.collect()
}

/// Whether the edge bends more than all parallel ones nearby; of equals the first counts.
fn is_sharpest(t: &Topology, own: &Candidate, all: &BTreeMap<EdgeId, &Candidate>) -> bool {
    t.edge_corners.row(own.edge).iter().all(|&corner| {
        let face = t.faces.face_of(corner);
        if t.faces.valence(face) != 4 {
            return true;
        }
        let opposite = t.corner_edge[t.faces.next(t.faces.next(corner))];
        all.get(&opposite).is_none_or(|other| {
            let near = own.middle.distance(other.middle) < APART * own.target;
            let sharper = (other.bend, std::cmp::Reverse(other.edge)) > (own.bend, std::cmp::Reverse(own.edge));
            !(near && sharper)
        })
    })
}

/// Groups of edges that are connected at their ends.
fn pieces<'a>(t: &Topology, edges: &[&'a Candidate]) -> Vec<Vec<&'a Candidate>> {
    let mut groups = Groups::<VertexId>::new(t.vertex_count());
    for candidate in edges {
        let [a, b] = t.edges[candidate.edge];
        groups.join(a, b);
    }
    let mut pieces = BTreeMap::<VertexId, Vec<&Candidate>>::new();
    for &candidate in edges {
        pieces.entry(groups.first(t.edges[candidate.edge][0])).or_default().push(candidate);
    }
    pieces.into_values().collect()
}

impl RefinedSurface<'_> {
    /// Finds the normals on both sides of a chain: at the chain itself, but half a target length away from a ridge.
    pub(crate) fn set_normals(&self, chain: &mut Chain) {
        let part = if chain.kind.ridge { 0.5 } else { 0.0 };
        let reach = |v: VertexId| part * self.target[v];
        let beyond = |half: Option<CornerId>, v| half.map_or(Vec3::ZERO, |h| self.normal_beyond(h, reach(v)));
        let sides = chain.left.iter().zip(&chain.right).zip(&chain.vertices);
        chain.normals = sides.map(|((&left, &right), &v)| [beyond(left, v), beyond(right, v)]).collect();
    }

    /// The angle between the normals half a target length to the left and to the right of an edge. \[radians\]
    fn bend(&self, a: VertexId, b: VertexId) -> f32 {
        let half = |a, b| half_edge(self.topology, a, b);
        let (Some(left), Some(right)) = (half(a, b), half(b, a)) else { return 0.0 };
        let reach = 0.25 * (self.target[a] + self.target[b]);
        angle(self.normal_beyond(left, reach), self.normal_beyond(right, reach))
    }

    /// The normal at a distance from the middle of a half-edge, by a straight walk away from it over the surface.
    fn normal_beyond(&self, half: CornerId, reach: f32) -> Vec3 {
        let at = |c: CornerId| self.points[self.topology.faces.vertex(c)];
        let mut from = at(half).midpoint(at(next(half)));
        let mut half = half;
        let mut normal = self.normal(half);
        let mut way = normal.cross(at(next(half)) - at(half)).normalize_or_zero();
        let mut left = reach;
        for _ in 0..MAX_STEPS {
            let Some((side, passed)) = [next(half), prev(half)]
                .into_iter()
                .filter_map(|c| Some((c, crossing(from, way, normal, at(c), at(next(c)))?)))
                .min_by(|a, b| a.1.total_cmp(&b.1))
            else {
                break;
            };
            let twin = self.topology.twin(side);
            let (Some(twin), true) = (twin, passed < left) else { break };
            left -= passed;
            from += way * passed;
            let along = (at(next(side)) - at(side)).normalize_or_zero();
            // Unfolds the direction into the next triangle.
            let (own, across) = (way.dot(along), way.dot(along.cross(normal)));
            normal = self.normal(twin);
            way = along * own + along.cross(normal) * across;
            half = twin;
        }
        normal
    }

    fn normal(&self, half: CornerId) -> Vec3 {
        let [a, b, c] = [half, next(half), prev(half)].map(|c| self.points[self.topology.faces.vertex(c)]);
        (b - a).cross(c - a).normalize_or_zero()
    }
}

/// How far along `way` a line in a triangle's plane leaves it through the side from `a` to `b`, counter-clockwise.
fn crossing(from: Vec3, way: Vec3, normal: Vec3, a: Vec3, b: Vec3) -> Option<f32> {
    let outward = (b - a).cross(normal);
    let speed = way.dot(outward);
    (speed > 0.0).then(|| ((a - from).dot(outward) / speed).max(0.0))
}
