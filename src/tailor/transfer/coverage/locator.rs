//! Point location: the triangle of the simulation mesh over a point of the baseline, by a walk from a triangle near by.
//!
//! The walk is in UV space where the region is unfolded there, which is exact and separates layers; elsewhere it is
//! over the triangles' own planes. It crosses no chain, so that it stays on its panel and its side of each seam.

use super::regions::Regions;
use crate::contact::Aabb;
use crate::sim::{Projection, SimProduct, closest_weights};
use crate::transfer::topology::SimTopology;
use glam::{Vec3, Vec3A};
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};
use tailor_mesh::connectivity::{CornerId, Csr, FaceId, IdVec, Topology};

/// Steps after which a walk is in a cycle.
const MAX_STEPS: usize = 512;
/// Distance beyond a chain up to which a point belongs to the triangle, as a share of the triangle's height: edges are
/// chords of curved chains. Points farther out may be at the wrong side of a notch, and are searched.
const BEYOND_CHAIN: f32 = 0.05;
/// Triangles that a search visits: enough to get around the end of a dart.
const MAX_SEARCHED: usize = 96;
/// Triangles of the baseline that share a box. Fewer make more boxes to look at.
const RUN: usize = 4;
/// Most that a point on a triangle is off by rounding, as a share of the largest coordinate.
const ROUNDING: f32 = 1e-6;
/// Added distance of a flipped triangle, as a share of its longest side.
const FLIPPED_PENALTY: f32 = 0.5;

/// Tables of a simulation mesh and its baseline that a [`Locator`] reads, made once for each mesh.
pub struct LocatorTables {
    pub(in crate::transfer) mesh: SimTopology,
    regions: Regions,
    maps: IdVec<FaceId, BarycentricMap>,
    /// The triangle across each half-edge that is on no chain.
    across: IdVec<CornerId, Option<FaceId>>,
    /// A triangle of the simulation mesh near each triangle of the baseline; none in a region without any.
    start: IdVec<FaceId, Option<FaceId>>,
    /// The boxes of runs of [`RUN`] triangles of the baseline in each face of the garment.
    boxes: Csr<FaceId, Aabb>,
}

/// Finds the triangle of a simulation mesh over a point of its baseline, on the same panel, layer and side.
#[derive(Clone, Copy)]
pub struct Locator<'a> {
    /// The simulation mesh.
    pub product: &'a SimProduct,
    pub(in crate::transfer) tables: &'a LocatorTables,
}

/// The barycentric coordinates of a triangle of the simulation mesh as an affine map, in UV or in space.
struct BarycentricMap {
    /// The third corner.
    origin: Vec3A,
    /// Gradients of the first two coordinates, which are zero at the origin.
    gradients: [Vec3A; 2],
    /// The z axis in UV; zero for a triangle without area.
    normal: Vec3A,
}

impl BarycentricMap {
    fn new([a, b, c]: [Vec3; 3], is_flat: bool) -> Self {
        let normal = (b - a).cross(c - a);
        let over = normal / normal.length_squared();
        let gradients = [over.cross(c - b), over.cross(a - c)].map(Vec3A::from);
        let facing = if is_flat { Vec3::Z } else { normal };
        let has_area = gradients[0].is_finite() && gradients[1].is_finite();
        Self { origin: c.into(), gradients, normal: if has_area { facing.into() } else { Vec3A::ZERO } }
    }

    fn weights(&self, point: Vec3A) -> Vec3 {
        let from = point - self.origin;
        let [u, v] = self.gradients.map(|g| g.dot(from));
        Vec3::new(u, v, 1.0 - u - v)
    }
}

/// A triangle of the baseline whose points are located.
pub(in crate::transfer) struct SampledTriangle {
    /// In UV for a flat region, else in space.
    pub corners: [Vec3A; 3],
    normal: Vec3A,
    is_flat: bool,
    /// Triangle of the simulation mesh over the last point.
    last: FaceId,
}

impl LocatorTables {
    /// The tables of `product`, whose garment has `source_faces` faces.
    pub fn new(product: &SimProduct, source_faces: usize) -> Self {
        let (mesh, regions) =
            rayon::join(|| SimTopology::new(product, source_faces), || Regions::new(&product.baseline));
        let t = &mesh.topology;
        let across = mesh.twin.enumerated().map(|(c, twin)| {
            let twin = twin.filter(|_| !mesh.is_chain[t.corner_edge[c]]);
            twin.map(|twin| FaceId::new(twin.index() / 3))
        });
        let across = across.collect();
        let of = regions.of_product(product);
        let map = |(face, &region): (FaceId, &u32)| {
            let is_flat = regions.is_flat[region as usize];
            BarycentricMap::new(corners(product, is_flat, face), is_flat)
        };
        let maps = of.enumerated().map(map).collect();
        let start = starts(product, &regions, &of);
        let points = |&triangle: &FaceId| product.baseline.triangle(triangle).map(Vec3A::from);
        // Distances of triangles are rounded, and may be less than those of boxes that fit closely.
        let farthest = product.baseline.points.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
        let rounded = move |aabb: Aabb| aabb.expanded(ROUNDING * farthest);
        let runs = |source| {
            let runs = mesh.source_triangles.row(source).chunks(RUN);
            runs.map(move |run| (source, rounded(Aabb::of(run.iter().flat_map(points)))))
        };
        let boxes = Csr::group(source_faces, (0..source_faces).map(FaceId::new).flat_map(runs), Aabb::EMPTY);
        Self { mesh, regions, maps, across, start, boxes }
    }

    /// The triangles in one of the boxes of a face of the garment.
    fn run(&self, (face, number): (FaceId, usize)) -> &[FaceId] {
        let triangles = self.mesh.source_triangles.row(face);
        &triangles[RUN * number..triangles.len().min(RUN * number + RUN)]
    }

    /// The topology of the simulation mesh.
    pub fn topology(&self) -> &Topology {
        &self.mesh.topology
    }
}

impl<'a> Locator<'a> {
    /// Finds places on `product`, of which `tables` were made.
    pub fn new(product: &'a SimProduct, tables: &'a LocatorTables) -> Self {
        Self { product, tables }
    }

    /// Finds a place for each point: the triangle and the weights of its corners. A point is given with faces of the garment
    /// on or beside which it lies. `None` where the simulation mesh has no triangle in that region.
    pub fn find<'f>(
        &self,
        count: usize,
        point: impl Fn(usize) -> (Vec3, &'f [FaceId]) + Sync,
    ) -> Vec<Option<(FaceId, Vec3)>> {
        let place = |i: usize| {
            let (point, faces) = point(i);
            let (face, weights) = self.closest(point, faces)?;
            self.place(face, weights)
        };
        (0..count).into_par_iter().map(place).collect()
    }

    /// The closest point of the baseline within some faces of the garment, on the lowest of the triangles that are as near: the
    /// triangle, and the weights of its corners.
    pub fn closest(&self, point: Vec3, faces: &[FaceId]) -> Option<(FaceId, Vec3)> {
        let from = Vec3A::from(point);
        let mut nearest: Option<Projection> = None;
        let mut look_at = |run: &[FaceId]| {
            for &triangle in run {
                let found = self.product.baseline.on_triangle(triangle, point);
                let key = |at: &Projection| (at.distance_squared.to_bits(), at.location.face);
                if nearest.as_ref().is_none_or(|nearest| key(&found) < key(nearest)) {
                    nearest = Some(found);
                }
            }
            nearest.map_or(f32::INFINITY, |nearest| nearest.distance_squared)
        };
        // The triangles of the box that is nearest are looked at first, and leave few others to look at.
        let (mut first, mut distance) = (None, f32::INFINITY);
        for &face in faces {
            for (i, aabb) in self.tables.boxes.row(face).iter().enumerate() {
                let own = aabb.distance_squared(from);
                if own < distance || first.is_none() {
                    (first, distance) = (Some((face, i)), own);
                }
            }
        }
        let first = first?;
        let mut least = look_at(self.tables.run(first));
        for &face in faces {
            for (i, aabb) in self.tables.boxes.row(face).iter().enumerate() {
                if aabb.distance_squared(from) <= least && (face, i) != first {
                    least = look_at(self.tables.run((face, i)));
                }
            }
        }
        nearest.map(|nearest| (nearest.location.face, nearest.location.weights))
    }

    /// A triangle of the baseline whose points can be located; none in a region without triangles of the simulation
    /// mesh.
    pub(in crate::transfer) fn triangle(&self, face: FaceId) -> Option<SampledTriangle> {
        let (base, regions) = (&self.product.baseline, &self.tables.regions);
        let is_flat = regions.is_flat[regions.of[face] as usize];
        let (corners, normal) = match is_flat {
            true => ([0, 1, 2].map(|k| base.uvs[CornerId::new(3 * face.index() + k)].extend(0.0)), Vec3::Z),
            false => (base.triangle(face), base.facets[face].normal),
        };
        let corners = corners.map(Vec3A::from);
        self.tables.start[face].map(|last| SampledTriangle { corners, normal: normal.into(), is_flat, last })
    }

    /// Removes the points of a triangle of the baseline and calls `found` with each triangle over them and its number
    /// of points.
    ///
    /// Each walk counts all points that lie in the triangle at its end, so that few walks are needed.
    pub(in crate::transfer) fn count(
        &self,
        triangle: &mut SampledTriangle,
        points: &mut Vec<Vec3A>,
        mut found: impl FnMut(FaceId, u32),
    ) {
        while let Some(point) = points.pop() {
            triangle.last = self.walk(triangle, point);
            let map = &self.tables.maps[triangle.last];
            let mut kept = points.len();
            if map.normal.dot(triangle.normal) > 0.0 {
                kept = 0;
                // Branchless: a branch would be mispredicted half the time.
                for i in 0..points.len() {
                    points[kept] = points[i];
                    kept += usize::from(map.weights(points[i]).min_element() < 0.0);
                }
            }
            found(triangle.last, 1 + (points.len() - kept) as u32);
            points.truncate(kept);
        }
    }

    /// The triangle of the simulation mesh over the point of a triangle of the baseline with `weights`, and the weights of
    /// its own corners there; none in a region without triangles of the simulation mesh.
    pub(in crate::transfer) fn place(&self, face: FaceId, weights: Vec3) -> Option<(FaceId, Vec3)> {
        let triangle = self.triangle(face)?;
        let [a, b, c] = triangle.corners;
        let point = a * weights.x + b * weights.y + c * weights.z;
        let found = self.walk(&triangle, point);
        let [a, b, c] = corners(self.product, triangle.is_flat, found);
        Some((found, closest_weights(a, b, c, point.into())))
    }

    fn walk(&self, triangle: &SampledTriangle, point: Vec3A) -> FaceId {
        let (mut face, mut before) = (triangle.last, None);
        for _ in 0..MAX_STEPS {
            let map = &self.tables.maps[face];
            let own = map.weights(point);
            let least = own.min_element();
            let is_facing = map.normal.dot(triangle.normal) > 0.0;
            if least >= 0.0 && is_facing {
                return face;
            }
            match self.step(face, own) {
                // A point over a convex edge is outside of both its triangles.
                Some(next) if before == Some(next) && is_facing => return face.min(next),
                Some(next) if before != Some(next) => (face, before) = (next, Some(face)),
                None if is_facing && least > -BEYOND_CHAIN => return face,
                _ => break,
            }
        }
        self.search(triangle, face, point.into())
    }

    /// The triangle across the side with the most negative coordinate.
    fn step(&self, face: FaceId, weights: Vec3) -> Option<FaceId> {
        let mut next = None;
        let mut least = 0.0;
        for k in 0..3 {
            // A coordinate is negative beyond the side opposite its corner.
            let across = self.tables.across[CornerId::new(3 * face.index() + (k + 1) % 3)];
            if weights[k] < least && across.is_some() {
                (next, least) = (across, weights[k]);
            }
        }
        next
    }

    /// The closest triangle around `start`, with a penalty for flipped ones.
    fn search(&self, triangle: &SampledTriangle, start: FaceId, point: Vec3) -> FaceId {
        let normal = Vec3::from(triangle.normal);
        let distance = |face: FaceId| {
            let [a, b, c] = corners(self.product, triangle.is_flat, face);
            let w = closest_weights(a, b, c, point);
            let is_flipped = !triangle.is_flat && (b - a).cross(c - a).dot(normal) <= 0.0;
            let side = a.distance(b).max(b.distance(c)).max(c.distance(a));
            (a * w.x + b * w.y + c * w.z).distance(point) + if is_flipped { FLIPPED_PENALTY * side } else { 0.0 }
        };
        // The bits of distances, which are not negative, sort as the distances do.
        let key = |face: FaceId| (distance(face).to_bits(), face);
        let mut queue = BinaryHeap::from([Reverse(key(start))]);
        let mut reached = vec![start];
        let mut best = key(start);
        while let Some(Reverse(nearest)) = queue.pop().filter(|_| reached.len() < MAX_SEARCHED) {
            best = best.min(nearest);
            for k in 0..3 {
                let across = self.tables.across[CornerId::new(3 * nearest.1.index() + k)];
                if let Some(other) = across.filter(|f| !reached.contains(f)) {
                    reached.push(other);
                    queue.push(Reverse(key(other)));
                }
            }
        }
        best.1
    }
}

/// The corners of a triangle of the simulation mesh, in UV for a flat region, else in space.
fn corners(product: &SimProduct, is_flat: bool, face: FaceId) -> [Vec3; 3] {
    match is_flat {
        true => [0, 1, 2].map(|k| product.places[CornerId::new(3 * face.index() + k)].uv.extend(0.0)),
        false => product.triangles[face.index()].map(|v| product.points[v]),
    }
}

/// A triangle of the simulation mesh near each triangle of the baseline: one with a corner in it, else that of a
/// neighbour in the region.
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
