//! The triangle of the simulation mesh over a point of the baseline: in UV space where its region lies there in one
//! piece, which is exact and knows no layers; else the closest one of the region that faces the same way.

use super::region::Regions;
use crate::mesh::{CornerId, FaceId};
use crate::sim::{Location, SimProduct, closest_weights};
use glam::{Vec2, Vec3};
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::ops::Range;

/// A triangle whose longest side is more cells long than this makes the cells larger.
const MAX_CELLS: f32 = 8.0;
/// Distance at which a point counts as on a triangle, as a share of the cell: rounding alone is less.
const ON_TRIANGLE: f32 = 1e-5;
/// How much farther a triangle counts that faces the other way, as a share of the cell; more keeps the two sides of a
/// flat fold apart even where the simulation mesh cuts it short.
const TURNED: f32 = 0.5;
/// Cells of a grid along each side: three of them are told apart by one number.
const MOST_CELLS: f32 = ((1 << 20) - 1) as f32;
/// A search ends, whatever it has found, when it is this many cells wide.
const WIDEST: f32 = 16.0;

/// The triangles of the simulation mesh, in the cells of a grid for each region.
pub(super) struct Locator<'a> {
    product: &'a SimProduct,
    regions: &'a Regions,
    grids: Vec<Grid>,
}

/// The triangles of one region, where it is searched: in UV, or in space.
struct Grid {
    low: Vec3,
    /// The last cell each way.
    last: Vec3,
    cell: f32,
    cells: HashMap<u64, Range<u32>, BuildHasherDefault<Mix>>,
    triangles: Vec<FaceId>,
}

/// The triangles near a triangle of the baseline; one is used for many.
pub(super) struct Near {
    face: FaceId,
    reach: f32,
    triangles: Vec<Candidate>,
    found: Found,
    /// Where the last point was found, among the triangles: the next is likely there.
    last: usize,
}

/// Triangles of the simulation mesh, each once.
#[derive(Default)]
struct Found {
    faces: Vec<FaceId>,
    /// The search in which each triangle was found last.
    stamps: Vec<u32>,
    search: u32,
}

impl Found {
    fn clear(&mut self) {
        self.faces.clear();
        self.search = self.search.wrapping_add(1);
        if self.search == 0 {
            self.stamps.clear();
            self.search = 1;
        }
    }

    fn add(&mut self, face: FaceId) {
        if face.index() >= self.stamps.len() {
            self.stamps.resize(face.index() + 1, 0);
        }
        if std::mem::replace(&mut self.stamps[face.index()], self.search) != self.search {
            self.faces.push(face);
        }
    }
}

/// A triangle where it is searched.
struct Candidate {
    face: FaceId,
    corners: [Vec3; 3],
    bounds: (Vec3, Vec3),
    /// What is added to its distance in space.
    turned: f32,
}

impl Near {
    pub fn new() -> Self {
        Self { face: FaceId::new(0), reach: 0.0, triangles: Vec::new(), found: Found::default(), last: 0 }
    }
}

impl<'a> Locator<'a> {
    pub fn new(product: &'a SimProduct, regions: &'a Regions) -> Self {
        let mut members: Vec<Vec<FaceId>> = vec![Vec::new(); regions.is_flat.len()];
        for (face, &region) in regions.of_product(product).enumerated() {
            members[region as usize].push(face);
        }
        let mut locator = Self { product, regions, grids: Vec::new() };
        let grids = members.iter().enumerate().map(|(region, faces)| {
            let corners: Vec<_> = faces.iter().map(|&f| locator.chart(region, f)).collect();
            Grid::new(faces, &corners)
        });
        locator.grids = grids.collect();
        locator
    }

    /// The corners of a triangle of the simulation mesh where its region is searched.
    fn chart(&self, region: usize, face: FaceId) -> [Vec3; 3] {
        match self.regions.is_flat[region] {
            true => [0, 1, 2].map(|k| self.product.places[CornerId::new(3 * face.index() + k)].uv.extend(0.0)),
            false => self.corners(face),
        }
    }

    fn corners(&self, face: FaceId) -> [Vec3; 3] {
        self.product.triangles[face.index()].map(|v| self.product.points[v])
    }

    fn normal(&self, face: FaceId) -> Vec3 {
        let [a, b, c] = self.corners(face);
        (b - a).cross(c - a)
    }

    /// Turns to a triangle of the baseline, before any point of it is located.
    pub fn turn_to(&self, face: FaceId, near: &mut Near) {
        let region = self.regions.of[face] as usize;
        near.face = face;
        near.reach = if self.regions.is_flat[region] { 0.0 } else { 0.25 * self.grids[region].cell };
        self.gather(near);
    }

    fn gather(&self, near: &mut Near) {
        let region = self.regions.of[near.face] as usize;
        let base = &self.product.baseline;
        let corners = match self.regions.is_flat[region] {
            true => [0, 1, 2].map(|k| base.uvs[CornerId::new(3 * near.face.index() + k)].extend(0.0)),
            false => base.triangle(near.face),
        };
        let slack = near.reach + ON_TRIANGLE * self.grids[region].cell;
        let (low, high) = bounds(&corners);
        let (low, high) = (low - slack, high + slack);
        self.grids[region].gather(low, high, &mut near.found);
        near.triangles.clear();
        near.last = 0;
        let is_flat = self.regions.is_flat[region];
        let (normal, turned) = (base.normal(near.face), TURNED * self.grids[region].cell);
        for &face in &near.found.faces {
            let corners = self.chart(region, face);
            let bounds = bounds(&corners);
            if bounds.0.cmple(high).all() && bounds.1.cmpge(low).all() {
                let is_turned = !is_flat && self.normal(face).dot(normal) <= 0.0;
                let turned = if is_turned { turned } else { 0.0 };
                near.triangles.push(Candidate { face, corners, bounds, turned });
            }
        }
    }

    /// The triangle of the simulation mesh over a point of a triangle of the baseline; none in a region that has none.
    pub fn locate(&self, near: &mut Near, weights: Vec3) -> Option<FaceId> {
        let at = Location { face: near.face, weights };
        let region = self.regions.of[near.face] as usize;
        let cell = self.grids[region].cell;
        if self.grids[region].triangles.is_empty() {
            return None;
        }
        if self.regions.is_flat[region]
            && let Some(face) = inside_one(&near.triangles, self.product.baseline.uv(at))
        {
            return Some(face);
        }
        loop {
            let best = self.best(near, at);
            near.last = best.map_or(0, |(_, i)| i);
            let is_closest = best.is_some_and(|(distance, _)| distance <= near.reach);
            if is_closest || near.reach > WIDEST * cell {
                return best.map(|(_, i)| near.triangles[i].face);
            }
            near.reach = (2.0 * near.reach).max(0.5 * cell);
            self.gather(near);
        }
    }

    /// The best of the triangles at hand, with its distance.
    fn best(&self, near: &Near, at: Location) -> Option<(f32, usize)> {
        let base = &self.product.baseline;
        let region = self.regions.of[near.face] as usize;
        let (is_flat, cell) = (self.regions.is_flat[region], self.grids[region].cell);
        let position = base.position(at);
        let point = if is_flat { base.uv(at).extend(0.0) } else { position };
        let in_space = |i: usize| {
            let face = near.triangles[i].face;
            let turned = if self.normal(face).dot(base.normal(near.face)) > 0.0 { 0.0 } else { TURNED * cell };
            distance(self.corners(face), position) + turned
        };
        let lower = |i: usize, j: usize| near.triangles[i].face < near.triangles[j].face;
        let mut best: Option<(f32, usize)> = None;
        let order = near.triangles.get(near.last).map(|_| near.last).into_iter().chain(0..near.triangles.len());
        for i in order {
            let Candidate { corners, bounds: (low, high), turned, .. } = near.triangles[i];
            let outside = (low - point).max(point - high).max(Vec3::ZERO);
            if best.is_some_and(|(d, j)| i == j || outside.length_squared() > d * d) {
                continue;
            }
            let mut own = distance(corners, point) + turned;
            if own <= ON_TRIANGLE * cell {
                own = 0.0;
            }
            // Where a layout lies on itself, the nearer in space; else the lower of two neighbours.
            let wins = |j: usize| match is_flat && own == 0.0 {
                true => {
                    let (i_off, j_off) = (in_space(i), in_space(j));
                    i_off < j_off || i_off == j_off && lower(i, j)
                }
                false => lower(i, j),
            };
            if best.is_none_or(|(d, j)| own < d || own == d && wins(j)) {
                best = Some((own, i));
            }
        }
        best
    }
}

/// The triangle that a point is well inside of, where it is the only one: nearly every point.
fn inside_one(triangles: &[Candidate], p: Vec2) -> Option<FaceId> {
    let mut found = None;
    for Candidate { face, corners, .. } in triangles {
        let [a, b, c] = corners.map(|c| c.truncate() - p);
        let sides = Vec3::new(a.perp_dot(b), b.perp_dot(c), c.perp_dot(a));
        let slack = 1e-4 * sides.element_sum().abs();
        // Beyond a side by more than rounding, whichever way round the triangle is.
        if sides.min_element() < -slack && sides.max_element() > slack {
            continue;
        }
        let is_inside = sides.min_element() > slack || sides.max_element() < -slack;
        if !is_inside || found.is_some() {
            return None;
        }
        found = Some(*face);
    }
    found
}

impl Grid {
    /// Cells about as large as a triangle.
    fn new(faces: &[FaceId], corners: &[[Vec3; 3]]) -> Self {
        let boxes: Vec<(Vec3, Vec3)> = corners.iter().map(bounds).collect();
        let low = boxes.iter().fold(Vec3::MAX, |low, b| low.min(b.0));
        let (mut sum, mut longest) = (0.0f64, 0.0f32);
        for (from, to) in &boxes {
            let size = (*to - *from).max_element();
            sum += f64::from(size);
            longest = longest.max(size);
        }
        let mean = (sum / boxes.len().max(1) as f64) as f32;
        let cell = mean.max(longest / MAX_CELLS).max(f32::MIN_POSITIVE);
        let high = boxes.iter().fold(low, |high, b| high.max(b.1));
        let last = ((high - low) / cell).floor().min(Vec3::splat(MOST_CELLS));
        let mut grid = Self { low, last, cell, cells: HashMap::default(), triangles: Vec::new() };
        let mut entries: Vec<(u64, FaceId)> = Vec::with_capacity(4 * faces.len());
        for (&face, (from, to)) in faces.iter().zip(&boxes) {
            grid.for_each_cell(*from, *to, |cell| entries.push((cell, face)));
        }
        entries.sort_unstable();
        for group in entries.chunk_by(|a, b| a.0 == b.0) {
            let start = grid.triangles.len() as u32;
            grid.triangles.extend(group.iter().map(|e| e.1));
            grid.cells.insert(group[0].0, start..grid.triangles.len() as u32);
        }
        grid
    }

    fn for_each_cell(&self, low: Vec3, high: Vec3, mut visit: impl FnMut(u64)) {
        if !self.last.is_finite() {
            return;
        }
        let at = |p: Vec3| ((p - self.low) / self.cell).floor().clamp(Vec3::ZERO, self.last).as_u64vec3();
        let (low, high) = (at(low), at(high));
        for z in low.z..=high.z {
            for y in low.y..=high.y {
                (low.x..=high.x).for_each(|x| visit(x | y << 20 | z << 40));
            }
        }
    }

    /// The triangles in the cells of a box.
    fn gather(&self, low: Vec3, high: Vec3, found: &mut Found) {
        found.clear();
        self.for_each_cell(low, high, |cell| {
            let range = self.cells.get(&cell).cloned().unwrap_or(0..0);
            self.triangles[range.start as usize..range.end as usize].iter().for_each(|&f| found.add(f));
        });
    }
}

/// Mixes the bits of a cell's number.
#[derive(Default)]
struct Mix(u64);

impl Hasher for Mix {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&b| self.write_u64(u64::from(b)));
    }

    fn write_u64(&mut self, number: u64) {
        let mixed = (self.0.rotate_left(5) ^ number).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.0 = mixed ^ (mixed >> 32);
    }
}

fn bounds(corners: &[Vec3; 3]) -> (Vec3, Vec3) {
    let [a, b, c] = *corners;
    (a.min(b).min(c), a.max(b).max(c))
}

fn distance([a, b, c]: [Vec3; 3], point: Vec3) -> f32 {
    let w = closest_weights(a, b, c, point);
    (a * w.x + b * w.y + c * w.z).distance(point)
}
