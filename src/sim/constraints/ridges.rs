//! Folds of the surface that are sharper than the target length can follow. An edge across such a fold cuts it off, and
//! where edges come to lie by chance it becomes a saw blade; so the edges of the cage along it become chains.

use crate::mesh::edit::{next, prev};
use crate::mesh::{CornerId, EdgeId, FaceId, IdVec, Topology, VertexId};
use crate::sim::constraints::chain::{CageChains, Chain, ChainKind};
use crate::sim::surface::manifold::Manifold;
use crate::subdivide::Refiner;
use glam::Vec3;
use std::collections::BTreeMap;

/// The surface makes a ridge where its normal turns by more than this over one target length. Smaller values make more
/// chains, which take freedom from the triangles beside them; larger ones let more of a fold be cut off. \[radians\]
const SHARP: f32 = 1.6;
/// A ridge goes on where the normal still turns by this. \[radians\]
const BLUNT: f32 = 1.2;
/// Least length of what is sharp in a ridge, as a multiple of the target length: shorter ones end as soon as they begin.
const LEAST_LENGTH: f32 = 2.0;
/// Of two parallel edges of the cage that are nearer than this multiple of the target length the sharper is the ridge.
const APART: f32 = 1.0;
/// Edges of the cage with less than this between their faces are no candidates, as smooth folds are sharper at the cage.
/// \[radians\]
const LEAST_DIHEDRAL: f32 = 0.3;
/// Triangles that a walk away from an edge goes through.
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

/// The triangulated surface.
pub(crate) struct RefinedSurface<'a> {
    pub topology: &'a Topology,
    pub points: &'a IdVec<VertexId, Vec3>,
    pub target: &'a IdVec<VertexId, f32>,
}

/// Marks the ridges among the edges of the cage that are no constraints yet. `levels` lead to the surface.
pub(crate) fn mark(
    manifold: &Manifold,
    levels: &[&Refiner],
    surface: &RefinedSurface<'_>,
    marked: &mut BTreeMap<EdgeId, ChainKind>,
) {
    let t = &manifold.refiner.level.topology;
    let candidates = candidates(t, levels, surface, marked);
    let bend_of: BTreeMap<EdgeId, &Candidate> = candidates.iter().map(|c| (c.edge, c)).collect();
    let kept: Vec<&Candidate> = candidates.iter().filter(|c| is_sharpest(t, c, &bend_of)).collect();
    for piece in pieces(t, &kept) {
        let sharp: f32 = piece.iter().filter(|c| c.bend > SHARP).map(|c| c.length / c.target).sum();
        if sharp >= LEAST_LENGTH {
            marked.extend(piece.iter().map(|c| (c.edge, ChainKind { ridge: true, ..ChainKind::default() })));
        }
    }
}

fn candidates(
    t: &Topology,
    levels: &[&Refiner],
    surface: &RefinedSurface<'_>,
    marked: &BTreeMap<EdgeId, ChainKind>,
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
            !marked.contains_key(&edge) && m.cross(n).length().atan2(m.dot(n)) > LEAST_DIHEDRAL
        }
        _ => false,
    };
    let edges: Vec<EdgeId> = t.edges.ids().filter(is_bent).collect();
    let paths = edges.iter().map(|&e| (ChainKind::default(), false, t.edges[e].to_vec())).collect();
    let curves = CageChains { paths }.refine(levels).pop().unwrap_or_default();
    let measured = edges.iter().zip(curves).filter_map(|(&edge, curve)| {
        let steps = curve.windows(2);
        let n = steps.len().max(1) as f32;
        let bend = steps.clone().map(|p| surface.bend(p[0], p[1])).sum::<f32>() / n;
        let length = steps.map(|p| at(p[0]).distance(at(p[1]))).sum();
        let middle = curve[curve.len() / 2];
        (bend > BLUNT).then(|| Candidate { edge, bend, middle: at(middle), length, target: surface.target[middle] })
    });
    measured.collect()
}

/// Whether no parallel edge nearby bends more; of equals the first counts.
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

/// Groups of edges that are joined at their ends.
fn pieces<'a>(t: &Topology, edges: &[&'a Candidate]) -> Vec<Vec<&'a Candidate>> {
    let mut at: BTreeMap<VertexId, Vec<usize>> = BTreeMap::new();
    for (i, c) in edges.iter().enumerate() {
        t.edges[c.edge].iter().for_each(|&v| at.entry(v).or_default().push(i));
    }
    let mut seen = vec![false; edges.len()];
    let mut pieces = Vec::new();
    for seed in 0..edges.len() {
        if std::mem::replace(&mut seen[seed], true) {
            continue;
        }
        let mut piece = vec![seed];
        let mut done = 0;
        while let Some(&i) = piece.get(done) {
            done += 1;
            for j in t.edges[edges[i].edge].iter().flat_map(|v| &at[v]) {
                if !std::mem::replace(&mut seen[*j], true) {
                    piece.push(*j);
                }
            }
        }
        pieces.push(piece.into_iter().map(|i| edges[i]).collect());
    }
    pieces
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
        let half = |a: VertexId, b: VertexId| {
            let faces = &self.topology.faces;
            self.topology.vertex_corners.row(a).iter().copied().find(|&c| faces.vertex(faces.next(c)) == b)
        };
        let (Some(left), Some(right)) = (half(a, b), half(b, a)) else { return 0.0 };
        let reach = 0.25 * (self.target[a] + self.target[b]);
        let (m, n) = (self.normal_beyond(left, reach), self.normal_beyond(right, reach));
        m.cross(n).length().atan2(m.dot(n))
    }

    /// The normal at a distance from the middle of a half-edge, straight away from it over the surface.
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
            // What leads away from the side here leads into the next triangle there.
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
