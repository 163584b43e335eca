//! The triangle of the simulation mesh over a point of the baseline: found by walking to it from one near by, in UV space
//! where the region lies there in one piece, which is exact and knows no layers, else over the triangles' own planes. A
//! walk crosses no chain, so that it stays on its own piece of cloth and its own side of the seams.

use super::Net;
use super::region::Regions;
use crate::mesh::{CornerId, FaceId, IdVec};
use crate::sim::{SimProduct, closest_weights};
use glam::{Mat3A, Vec3, Vec3A};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

/// A walk that is longer goes in circles.
const MAX_STEPS: usize = 512;
/// A point that is no farther beyond a chain, as a share of its triangle's height, is of that triangle: chords leave out
/// what a curve bends. Others may have come to the wrong side of a notch, and are searched.
const BEYOND_CHAIN: f32 = 0.05;
/// Triangles that a search looks at: enough to get around the end of a dart.
const MAX_SEARCHED: usize = 96;
/// How much farther a triangle counts that faces the other way, as a share of its longest side.
const TURNED: f32 = 0.5;
/// Triangles that are remembered at a time.
const REMEMBERED: usize = 32;

/// The triangles of the simulation mesh and the ways between them.
pub(super) struct Locator<'a> {
    product: &'a SimProduct,
    regions: &'a Regions,
    /// The triangle across each half-edge that is on no chain.
    across: IdVec<CornerId, Option<FaceId>>,
    /// A triangle of the simulation mesh near each one of the baseline; none in a region that has none.
    start: IdVec<FaceId, Option<FaceId>>,
}

/// A triangle of the baseline, and those of the simulation mesh that its points were found in.
pub(super) struct Near {
    corners: [Vec3; 3],
    normal: Vec3,
    is_flat: bool,
    last: Option<FaceId>,
    seen: [Seen; REMEMBERED],
}

/// A triangle of the simulation mesh as a triangle of the baseline sees it.
#[derive(Clone, Copy)]
struct Seen {
    face: Option<FaceId>,
    /// Its weights at the corners of the triangle of the baseline.
    weights: Mat3A,
    is_facing: bool,
    /// Samples that were found in it.
    count: u32,
}

const UNSEEN: Seen = Seen { face: None, weights: Mat3A::ZERO, is_facing: false, count: 0 };

impl Near {
    pub fn new() -> Self {
        let corners = [Vec3::ZERO; 3];
        Self { corners, normal: Vec3::ZERO, is_flat: false, last: None, seen: [UNSEEN; REMEMBERED] }
    }
}

impl<'a> Locator<'a> {
    pub fn new(product: &'a SimProduct, net: &Net, regions: &'a Regions) -> Self {
        let t = &net.topology;
        let across = t.faces.corners().ids().map(|c| {
            let twin = t.twin(c).filter(|_| !net.is_chain[t.corner_edge[c]]);
            twin.map(|twin| FaceId::new(twin.index() / 3))
        });
        Self { product, regions, across: across.collect(), start: starts(product, regions) }
    }

    /// Turns to a triangle of the baseline, before any point of it is located. Whether there is anything over it.
    pub fn turn_to(&self, face: FaceId, near: &mut Near) -> bool {
        let base = &self.product.baseline;
        near.is_flat = self.regions.is_flat[self.regions.of[face] as usize];
        near.corners = match near.is_flat {
            true => [0, 1, 2].map(|k| base.uvs[CornerId::new(3 * face.index() + k)].extend(0.0)),
            false => base.triangle(face),
        };
        near.normal = base.facets[face].normal;
        near.last = self.start[face];
        near.seen.iter_mut().for_each(|s| s.face = None);
        near.last.is_some()
    }

    /// Counts a point for the triangle of the simulation mesh over it.
    pub fn count(&self, near: &mut Near, weights: Vec3, found: &mut impl FnMut(FaceId, u32)) {
        let Some(start) = near.last else { return };
        let face = self.walk(near, start, weights, found);
        near.last = Some(face);
        self.see(near, face, found).count += 1;
    }

    /// Tells of the triangles with points that were not told of yet.
    pub fn finish(near: &mut Near, found: &mut impl FnMut(FaceId, u32)) {
        for seen in &mut near.seen {
            if let Some(face) = seen.face.take().filter(|_| seen.count > 0) {
                found(face, seen.count);
            }
        }
    }

    fn walk(&self, near: &mut Near, start: FaceId, weights: Vec3, found: &mut impl FnMut(FaceId, u32)) -> FaceId {
        let point = Vec3A::from(weights);
        let (mut face, mut before) = (start, None);
        for _ in 0..MAX_STEPS {
            let seen = self.see(near, face, found);
            let (own, is_facing) = (seen.weights * point, seen.is_facing);
            let least = own.min_element();
            if least >= 0.0 && is_facing {
                return face;
            }
            match self.step(face, own.into()) {
                // Between two triangles that bend away from it, the point is as near to either.
                Some(next) if before == Some(next) && is_facing => return face.min(next),
                Some(next) if before != Some(next) => (face, before) = (next, Some(face)),
                None if is_facing && least > -BEYOND_CHAIN => return face,
                _ => break,
            }
        }
        self.search(near, face, weights)
    }

    /// The triangle across the side that a point is farthest beyond.
    fn step(&self, face: FaceId, weights: Vec3) -> Option<FaceId> {
        let mut next = None;
        let mut least = 0.0;
        for k in 0..3 {
            // A weight is below zero beyond the side that is opposite its corner.
            let across = self.across[CornerId::new(3 * face.index() + (k + 1) % 3)];
            if weights[k] < least && across.is_some() {
                (next, least) = (across, weights[k]);
            }
        }
        next
    }

    /// How the triangle of the baseline sees one of the simulation mesh.
    fn see<'n>(&self, near: &'n mut Near, face: FaceId, found: &mut impl FnMut(FaceId, u32)) -> &'n mut Seen {
        let slot = face.index() % REMEMBERED;
        if near.seen[slot].face != Some(face) {
            let old = near.seen[slot];
            if let Some(other) = old.face.filter(|_| old.count > 0) {
                found(other, old.count);
            }
            near.seen[slot] = self.sight(near, face);
        }
        &mut near.seen[slot]
    }

    fn sight(&self, near: &Near, face: FaceId) -> Seen {
        let [a, b, c] = self.chart(near.is_flat, face);
        let normal = (b - a).cross(c - a);
        let over = normal / normal.length_squared();
        let column = |p: Vec3| {
            let (u, v) = ((c - b).cross(p - b).dot(over), (a - c).cross(p - c).dot(over));
            Vec3A::new(u, v, 1.0 - u - v)
        };
        let [x, y, z] = near.corners.map(column);
        let weights = Mat3A::from_cols(x, y, z);
        let is_facing = weights.is_finite() && (near.is_flat || normal.dot(near.normal) > 0.0);
        Seen { face: Some(face), weights, is_facing, count: 0 }
    }

    /// The corners of a triangle of the simulation mesh in UV, or in space.
    fn chart(&self, is_flat: bool, face: FaceId) -> [Vec3; 3] {
        match is_flat {
            true => [0, 1, 2].map(|k| self.product.places[CornerId::new(3 * face.index() + k)].uv.extend(0.0)),
            false => self.product.triangles[face.index()].map(|v| self.product.points[v]),
        }
    }

    /// The closest triangle around one, those that face the same way first.
    fn search(&self, near: &Near, start: FaceId, weights: Vec3) -> FaceId {
        let [a, b, c] = near.corners;
        let point = a * weights.x + b * weights.y + c * weights.z;
        let distance = |face: FaceId| {
            let [a, b, c] = self.chart(near.is_flat, face);
            let w = closest_weights(a, b, c, point);
            let is_turned = !near.is_flat && (b - a).cross(c - a).dot(near.normal) <= 0.0;
            let side = a.distance(b).max(b.distance(c)).max(c.distance(a));
            (a * w.x + b * w.y + c * w.z).distance(point) + if is_turned { TURNED * side } else { 0.0 }
        };
        // Distances are not negative, so that their bits are in their order.
        let key = |face: FaceId| (distance(face).to_bits(), face);
        let mut queue = BinaryHeap::from([Reverse(key(start))]);
        let mut reached = vec![start];
        let mut best = key(start);
        while let Some(Reverse(nearest)) = queue.pop().filter(|_| reached.len() < MAX_SEARCHED) {
            best = best.min(nearest);
            for k in 0..3 {
                let across = self.across[CornerId::new(3 * nearest.1.index() + k)];
                if let Some(other) = across.filter(|f| !reached.contains(f)) {
                    reached.push(other);
                    queue.push(Reverse(key(other)));
                }
            }
        }
        best.1
    }
}

/// A triangle of the simulation mesh near each triangle of the baseline: one with a corner there, else that of a
/// neighbour on the same side of the chains.
fn starts(product: &SimProduct, regions: &Regions) -> IdVec<FaceId, Option<FaceId>> {
    let base = &product.baseline;
    let mut start = IdVec::<FaceId, Option<FaceId>>::filled(None, base.topology.faces.len());
    let of_product = regions.of_product(product);
    let mut queue = VecDeque::new();
    for (corner, place) in product.places.enumerated() {
        let (face, at) = (FaceId::new(corner.index() / 3), place.location.face);
        if start[at].is_none() && regions.of[at] == of_product[face] {
            start[at] = Some(face);
            queue.push_back(at);
        }
    }
    while let Some(face) = queue.pop_front() {
        for k in 0..3 {
            let Some(twin) = base.open_twin(CornerId::new(3 * face.index() + k)) else { continue };
            let other = FaceId::new(twin.index() / 3);
            if start[other].is_none() {
                start[other] = start[face];
                queue.push_back(other);
            }
        }
    }
    start
}
