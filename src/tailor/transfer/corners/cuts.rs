//! Cuts of a face-varying channel: each triangle of the simulation mesh belongs to the shell that covers most of it.

use crate::sim::closest_weights;
use crate::transfer::correspondence::Correspondence;
use glam::Vec3;
use rayon::prelude::*;
use tailor_mesh::connectivity::{CornerId, Csr, FaceId, IdVec, VertexId};

/// Most triangles of an isolated part of a shell that joins its neighbours; larger parts stay.
const MAX_ISLAND: usize = 2;

/// For each triangle of the simulation mesh near a cut, a triangle of the baseline on its shell. Others take the values
/// at their corners' own locations, and have none.
pub(super) type ShellSeeds = IdVec<FaceId, Option<FaceId>>;
/// A triangle of the simulation mesh, and its seed.
pub(super) type Seeded = (FaceId, FaceId);

/// The cuts of one channel on the baseline.
pub(super) struct ChannelCuts<'a> {
    pub map: &'a Correspondence<'a>,
    /// Half-edges of the baseline that no walk crosses.
    pub barrier: IdVec<CornerId, bool>,
    /// Faces of the garment that touch a cut.
    touched: IdVec<FaceId, bool>,
    /// The neighbours of each face of the garment without a cut between them, with duplicates.
    joined: Csr<FaceId, FaceId>,
}

impl<'a> ChannelCuts<'a> {
    /// The cuts at the half-edges of `barrier`.
    pub fn new(map: &'a Correspondence<'a>, barrier: IdVec<CornerId, bool>) -> Self {
        let base = &map.product.baseline;
        let t = &base.topology;
        let mut at_cut = IdVec::<VertexId, bool>::filled(false, base.points.len());
        let mut pairs: Vec<(FaceId, FaceId)> = Vec::new();
        for (face, &source) in base.source_face.enumerated() {
            for corner in t.faces.corners_of(face) {
                if barrier[corner] {
                    t.faces.half_edge(corner).into_iter().for_each(|v| at_cut[v] = true);
                } else if let Some(twin) = base.open_twin(corner) {
                    let other = base.source_face[t.faces.face_of(twin)];
                    // The children of one edge are often consecutive.
                    if other != source && pairs.last() != Some(&(source, other)) {
                        pairs.push((source, other));
                    }
                }
            }
        }
        let rows = map.coverage.faces.rows();
        let joined = Csr::group(rows, pairs.into_iter(), FaceId::new(0));
        let mut touched = IdVec::filled(false, rows);
        for (face, &source) in base.source_face.enumerated() {
            touched[source] |= t.faces.vertices_of(face).iter().any(|&v| at_cut[v]);
        }
        Self { map, barrier, touched, joined }
    }

    /// The seeds of all triangles.
    pub fn seeds(&self) -> ShellSeeds {
        let count = self.map.product.triangles.len();
        (0..count).into_par_iter().map(|i| self.seed(FaceId::new(i))).collect::<Vec<_>>().into()
    }

    fn seed(&self, face: FaceId) -> Option<FaceId> {
        let map = self.map;
        let locations = map.corner_locations(face);
        let own = locations.map(|p| map.product.baseline.source_face[p.face]);
        if !map.coverage.sources.row(face).iter().map(|s| s.face).chain(own).any(|f| self.touched[f]) {
            return None;
        }
        let Some(source) = self.main_source(face) else { return Some(map.triangle_under(face)) };
        let inside = (0..3).find(|&k| own[k] == source);
        let corner = inside.or_else(|| (0..3).find(|&k| self.are_neighbours(own[k], source)));
        Some(corner.map_or_else(|| self.nearest_triangle(source, map.centroid(face)), |k| locations[k].face))
    }

    /// The garment's face with the largest area on the shell that covers most of a face; none without samples.
    fn main_source(&self, face: FaceId) -> Option<FaceId> {
        let row = self.map.coverage.sources.row(face);
        let shell = components(row.len(), |i, j| self.are_neighbours(row[j].face, row[i].face));
        let mut area = vec![0.0f32; row.len()];
        row.iter().zip(&shell).for_each(|(covered, &s)| area[s] += covered.area);
        let best = (0..row.len()).reduce(|best, i| if area[i] > area[best] { i } else { best })?;
        let members = row.iter().zip(&shell).filter(|(_, s)| **s == best).map(|(covered, _)| covered);
        members.reduce(|a, b| if b.area > a.area { b } else { a }).map(|covered| covered.face)
    }

    /// The nearest triangle of the baseline in a face of the garment that has samples.
    fn nearest_triangle(&self, source: FaceId, point: Vec3) -> FaceId {
        let distance = |&face: &FaceId| {
            let [a, b, c] = self.map.product.baseline.triangle(face);
            let w = closest_weights(a, b, c, point);
            (a * w.x + b * w.y + c * w.z).distance_squared(point)
        };
        let triangles = self.map.mesh.source_triangles.row(source).iter().map(|f| (distance(f), *f));
        triangles.min_by(|a, b| a.0.total_cmp(&b.0)).expect("a face with samples has triangles").1
    }

    /// Whether two faces of the garment are one, or neighbours without a cut between them.
    pub fn are_neighbours(&self, a: FaceId, b: FaceId) -> bool {
        a == b || self.joined.row(a).contains(&b)
    }

    /// Whether two triangles are on one shell, as far as the garment's faces around them show.
    pub fn are_joined(&self, a: FaceId, b: FaceId, seeds: &ShellSeeds) -> bool {
        let source = |face: FaceId| {
            let at = seeds[face].unwrap_or_else(|| self.map.corner_locations(face)[0].face);
            self.map.product.baseline.source_face[at]
        };
        let (from, to) = (source(a), source(b));
        let mut between = [a, b].into_iter().flat_map(|f| self.map.coverage.sources.row(f));
        self.are_neighbours(from, to)
            || between.any(|s| self.are_neighbours(from, s.face) && self.are_neighbours(s.face, to))
    }

    /// Isolated parts of shells that have one of `faces`, each triangle with the seed of a neighbour. `same` says
    /// whether two corners of one vertex have equal values.
    pub fn islands(
        &self,
        faces: &[FaceId],
        seeds: &ShellSeeds,
        same: impl Fn(CornerId, CornerId) -> bool + Sync,
    ) -> Vec<Seeded> {
        let island = |&face: &FaceId| self.island(face, seeds, &same).into_iter().flatten();
        let mut islands: Vec<Seeded> = faces.par_iter().flat_map_iter(island).collect();
        islands.sort_unstable();
        islands.dedup_by_key(|i| i.0);
        islands
    }

    /// The isolated part around a triangle; none if the part is large, or all around it are seams and borders.
    fn island(
        &self,
        face: FaceId,
        seeds: &ShellSeeds,
        same: impl Fn(CornerId, CornerId) -> bool,
    ) -> Option<Vec<Seeded>> {
        let (mesh, faces) = (self.map.mesh, &self.map.mesh.topology.faces);
        let next = |c| faces.next(c);
        let (mut part, mut beyond, mut at) = (vec![face], None, 0);
        while at < part.len() {
            for corner in faces.corners_of(part[at]) {
                let Some(twin) = mesh.twin[corner] else { continue };
                let other = faces.face_of(twin);
                if !(same(corner, next(twin)) && same(next(corner), twin)) {
                    beyond = beyond.or(seeds[other].filter(|_| !mesh.is_seam[mesh.topology.corner_edge[corner]]));
                } else if !part.contains(&other) {
                    if part.len() == MAX_ISLAND {
                        return None;
                    }
                    part.push(other);
                }
            }
            at += 1;
        }
        beyond.map(|seed| part.into_iter().map(|f| (f, seed)).collect())
    }
}

/// Connected components: for each of `count` items the first one of its component.
pub(super) fn components(count: usize, are_connected: impl Fn(usize, usize) -> bool) -> Vec<usize> {
    let mut first: Vec<usize> = (0..count).collect();
    for i in 0..count {
        for j in 0..i {
            if first[i] != first[j] && are_connected(i, j) {
                let (from, to) = (first[i].max(first[j]), first[i].min(first[j]));
                first.iter_mut().filter(|f| **f == from).for_each(|f| *f = to);
            }
        }
    }
    first
}
