//! The triangle of the simulation mesh over a point of the baseline: found by walking to it from one near by, in UV space
//! where the region lies there in one piece, which is exact and knows no layers, else over the triangles' own planes. A
//! walk crosses no chain, so that it stays on its own piece of cloth and its own side of the seams.

use super::Net;
use super::region::Regions;
use crate::mesh::{CornerId, FaceId, IdVec};
use crate::sim::{SimProduct, closest_weights};
use glam::{Vec3, Vec3A};
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

/// The triangles of the simulation mesh and the ways between them.
pub(super) struct Locator<'a> {
    product: &'a SimProduct,
    regions: &'a Regions,
    charts: IdVec<FaceId, Chart>,
    /// The triangle across each half-edge that is on no chain.
    across: IdVec<CornerId, Option<FaceId>>,
    /// A triangle of the simulation mesh near each one of the baseline; none in a region that has none.
    start: IdVec<FaceId, Option<FaceId>>,
}

/// A triangle of the simulation mesh in UV, or in space as its plane sees it: its weights at any point there.
struct Chart {
    origin: Vec3A,
    /// How the first two weights grow from the origin, where they are zero.
    growth: [Vec3A; 2],
    /// In UV that of the plane; zero for a triangle without area.
    normal: Vec3A,
}

impl Chart {
    fn new([a, b, c]: [Vec3; 3], is_flat: bool) -> Self {
        let normal = (b - a).cross(c - a);
        let over = normal / normal.length_squared();
        let growth = [over.cross(c - b), over.cross(a - c)].map(Vec3A::from);
        let facing = if is_flat { Vec3::Z } else { normal };
        let is_whole = growth[0].is_finite() && growth[1].is_finite();
        Self { origin: c.into(), growth, normal: if is_whole { facing.into() } else { Vec3A::ZERO } }
    }

    fn weights(&self, point: Vec3A) -> Vec3 {
        let from = point - self.origin;
        let [u, v] = self.growth.map(|g| g.dot(from));
        Vec3::new(u, v, 1.0 - u - v)
    }
}

/// A triangle of the baseline whose points are located, in UV or in space.
pub(super) struct Near {
    pub corners: [Vec3A; 3],
    normal: Vec3A,
    is_flat: bool,
    last: FaceId,
}

impl<'a> Locator<'a> {
    pub fn new(product: &'a SimProduct, net: &Net, regions: &'a Regions) -> Self {
        let t = &net.topology;
        let across = net.twin.enumerated().map(|(c, twin)| {
            let twin = twin.filter(|_| !net.is_chain[t.corner_edge[c]]);
            twin.map(|twin| FaceId::new(twin.index() / 3))
        });
        let of = regions.of_product(product);
        let chart = |(face, &region): (FaceId, &u32)| {
            let is_flat = regions.is_flat[region as usize];
            Chart::new(chart(product, is_flat, face), is_flat)
        };
        let start = starts(product, regions, &of);
        Self { product, regions, charts: of.enumerated().map(chart).collect(), across: across.collect(), start }
    }

    /// A triangle of the baseline, to locate points of it; none where nothing is over it.
    pub fn near(&self, face: FaceId) -> Option<Near> {
        let base = &self.product.baseline;
        let is_flat = self.regions.is_flat[self.regions.of[face] as usize];
        let (corners, normal) = match is_flat {
            true => ([0, 1, 2].map(|k| base.uvs[CornerId::new(3 * face.index() + k)].extend(0.0)), Vec3::Z),
            false => (base.triangle(face), base.facets[face].normal),
        };
        let corners = corners.map(Vec3A::from);
        self.start[face].map(|last| Near { corners, normal: normal.into(), is_flat, last })
    }

    /// Takes points of a triangle of the baseline and tells how many of them each triangle of the simulation mesh is over.
    ///
    /// Those that lie in the triangle over one of them are counted with it, so that few have to be walked to.
    pub fn count(&self, near: &mut Near, points: &mut Vec<Vec3A>, mut found: impl FnMut(FaceId, u32)) {
        while let Some(point) = points.pop() {
            near.last = self.walk(near, point);
            let chart = &self.charts[near.last];
            let mut kept = points.len();
            if chart.normal.dot(near.normal) > 0.0 {
                kept = 0;
                // Without a branch, which would be guessed wrong half the time.
                for i in 0..points.len() {
                    points[kept] = points[i];
                    kept += usize::from(chart.weights(points[i]).min_element() < 0.0);
                }
            }
            found(near.last, 1 + (points.len() - kept) as u32);
            points.truncate(kept);
        }
    }

    fn walk(&self, near: &Near, point: Vec3A) -> FaceId {
        let (mut face, mut before) = (near.last, None);
        for _ in 0..MAX_STEPS {
            let chart = &self.charts[face];
            let own = chart.weights(point);
            let least = own.min_element();
            let is_facing = chart.normal.dot(near.normal) > 0.0;
            if least >= 0.0 && is_facing {
                return face;
            }
            match self.step(face, own) {
                // Between two triangles that bend away from it, the point is as near to either.
                Some(next) if before == Some(next) && is_facing => return face.min(next),
                Some(next) if before != Some(next) => (face, before) = (next, Some(face)),
                None if is_facing && least > -BEYOND_CHAIN => return face,
                _ => break,
            }
        }
        self.search(near, face, point.into())
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

    /// The closest triangle around one, those that face the same way first.
    fn search(&self, near: &Near, start: FaceId, point: Vec3) -> FaceId {
        let normal = Vec3::from(near.normal);
        let distance = |face: FaceId| {
            let [a, b, c] = chart(self.product, near.is_flat, face);
            let w = closest_weights(a, b, c, point);
            let is_turned = !near.is_flat && (b - a).cross(c - a).dot(normal) <= 0.0;
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

/// The corners of a triangle of the simulation mesh in UV, or in space.
fn chart(product: &SimProduct, is_flat: bool, face: FaceId) -> [Vec3; 3] {
    match is_flat {
        true => [0, 1, 2].map(|k| product.places[CornerId::new(3 * face.index() + k)].uv.extend(0.0)),
        false => product.triangles[face.index()].map(|v| product.points[v]),
    }
}

/// A triangle of the simulation mesh near each triangle of the baseline: one with a corner there, else that of a
/// neighbour on the same side of the chains.
fn starts(product: &SimProduct, regions: &Regions, of_product: &IdVec<FaceId, u32>) -> IdVec<FaceId, Option<FaceId>> {
    let base = &product.baseline;
    let mut start = IdVec::<FaceId, Option<FaceId>>::filled(None, base.topology.faces.len());
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
