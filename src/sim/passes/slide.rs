//! Vertices of a chain slide along its curve.

use crate::mesh::edit::{next, prev};
use crate::mesh::{CornerId, VertexId, WedgeId};
use crate::sim::constraints::spacing::SHORTEST;
use crate::sim::passes::relax::VertexMove;
use crate::sim::sim_mesh::{SimMesh, Wedge};
use glam::Vec3;

/// How much of the way leads to the middle of the triangles on both sides, the rest to where the chain's own edges are
/// even. The first makes better triangles, the second more even edges.
const TO_MIDDLE: f32 = 0.8;
/// Where bends make edges of a chain this share of the target length, or more, all of [`TO_MIDDLE`] holds; none where they
/// are as short as they get. A smaller share lets chords cut more of the bends off: 0.8 leaves 0.3 % more of curves astray.
const STRAIGHT: f32 = 1.0;
/// Largest part of an edge of the chain that its end moves at once, so that two ends never pass each other.
const LONGEST_SLIDE: f32 = 0.4;

/// What else moves with a chain's vertex.
pub(crate) struct Slide {
    /// The constrained half-edges along the chain and against it.
    ahead: CornerId,
    back: CornerId,
    /// By how much. \[stage units\]
    by: f32,
    /// By how many of the edges that the chain asks for.
    by_count: f32,
    /// The site on the other side of the chain.
    other: Option<(WedgeId, Wedge)>,
}

impl Slide {
    /// Does the move; it becomes the move back.
    pub(crate) fn swap(&mut self, mesh: &mut SimMesh<'_>) {
        for (half, starts) in [(self.ahead, true), (self.back, false)] {
            let Some(mark) = mesh.mark[half] else { continue };
            let span = &mut mesh.spans[mark.span()];
            *(if starts { &mut span.from } else { &mut span.to }) += self.by;
            span.counts[usize::from(!starts)] += self.by_count;
        }
        (self.by, self.by_count) = (-self.by, -self.by_count);
        if let Some((id, wedge)) = &mut self.other {
            std::mem::swap(&mut mesh.wedges[*id], wedge);
        }
    }

    /// The site of an id, if it is that on the other side.
    pub(crate) fn other_wedge(&self, id: WedgeId) -> Option<&Wedge> {
        self.other.as_ref().filter(|(own, _)| *own == id).map(|(_, wedge)| wedge)
    }
}

/// By how much a chain's vertex wants to move along it. \[stage units\]
pub(crate) fn even_place(mesh: &SimMesh<'_>, vertex: VertexId) -> Option<f32> {
    let [ahead, back] = mesh.chain_neighbours(vertex)?;
    let (after, before) = (mesh.span(ahead)?.along(), mesh.span(back)?.along());
    let chain = mesh.chain(after.chain);
    let half_way = 0.5 * (before.count() + after.count());
    // A loop's two edges may count from different turns.
    let even = chain.at_count(before.counts[0] + half_way) - before.to;
    let other = |half: CornerId| {
        let start = mesh.topology.vertex(half);
        mesh.points[if start == vertex { mesh.topology.target(half) } else { start }]
    };
    let central = (other(ahead) - other(back)).normalize_or_zero().dot(to_middle(mesh, vertex));
    let (low, high) = (before.from - before.to, after.to - after.from);
    let share = TO_MIDDLE * freedom(mesh, vertex, ahead);
    Some((even + share * (central - even)).clamp(LONGEST_SLIDE * low, LONGEST_SLIDE * high.max(0.0)))
}

/// How freely a chain's vertex may slide, 0 to 1: where the curve bends as sharply as edges follow it, uneven edges would
/// cut it off. `ahead` is the constrained edge along the chain.
fn freedom(mesh: &SimMesh<'_>, vertex: VertexId, ahead: CornerId) -> f32 {
    let straight = mesh.target[vertex] / mesh.baseline.target_at(mesh.place(ahead).location);
    ((straight - SHORTEST) / (STRAIGHT - SHORTEST)).clamp(0.0, 1.0)
}

/// The way from a vertex to the middle of the triangles around it, weighted by their areas.
fn to_middle(mesh: &SimMesh<'_>, vertex: VertexId) -> Vec3 {
    let own = mesh.points[vertex];
    let (mut sum, mut weight) = (Vec3::ZERO, 0.0f32);
    for corner in mesh.topology.fan(vertex) {
        let (a, b) = (mesh.topology.target(corner), mesh.topology.vertex(prev(corner)));
        let (u, v) = (mesh.points[a] - own, mesh.points[b] - own);
        let w = u.cross(v).length();
        sum += w * (u + v);
        weight += w;
    }
    sum / (3.0 * weight).max(f32::MIN_POSITIVE)
}

/// The move of a chain's vertex.
pub(crate) fn slide(mesh: &SimMesh<'_>, vertex: VertexId, by: f32) -> Option<VertexMove> {
    let [ahead, back] = mesh.chain_neighbours(vertex)?;
    let after = mesh.span(ahead)?.along();
    let before = mesh.span(back)?.along();
    let (s, chain) = (before.to + by, mesh.chain(after.chain));
    let (turn, at) = chain.wound(s);
    let by_count = chain.count_of(turn, at) - before.counts[1];
    let (position, left) = (mesh.point_on(chain, at), mesh.wedge_on_curve(chain, at, true));
    let right = mesh.wedge_on_curve(chain, at, false);
    // The corner of a half-edge lies on its left: of one that leaves forward, on the chain's left.
    let leaves = |half: CornerId| mesh.topology.vertex(half) == vertex;
    let on_left = if leaves(ahead) { Some(ahead) } else { Some(next(back)).filter(|_| !leaves(back)) };
    let on_right = if leaves(back) { Some(back) } else { Some(next(ahead)).filter(|_| !leaves(ahead)) };
    let wedge = |corner: Option<CornerId>, wedge: Option<Wedge>| Some((mesh.corner_wedge[corner?], wedge?));
    let (left, right) = (wedge(on_left, left), wedge(on_right, right));
    let target = chain.length_of(at);
    let ((id, wedge), other) = match (left, right) {
        (Some(left), right) => (left, right),
        (None, right) => (right?, None),
    };
    Some(VertexMove {
        vertex,
        position,
        target,
        id,
        wedge,
        slide: Some(Box::new(Slide { ahead, back, by, by_count, other })),
    })
}
