//! Further UV sets, and all face-varying values with cuts of their own: each triangle of the simulation mesh belongs to
//! the side of a cut of which it covers the most, and takes its values from that side alone.

use super::Sites;
use super::coverage::Coverage;
use crate::mesh::{CornerId, Csr, FaceId, IdVec, VertexId};
use crate::sim::{Location, SimProduct};
use glam::Vec3;
use rayon::prelude::*;

/// A corner farther than this from its own side of the cuts was moved there, in target lengths.
const MOVED: f32 = 1e-3;
/// Triangles of the largest part of a side that is given to its neighbours rather than kept apart.
const ISLAND: usize = 2;

/// Where a corner takes its value.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source {
    /// A location on the corner's side of the cuts; its weights reach beyond the triangle where a value is continued.
    pub location: Location,
    /// Whether the vertex itself is elsewhere.
    pub moved: bool,
}

/// The cuts of one channel on the baseline.
pub(super) struct Cuts<'a> {
    product: &'a SimProduct,
    sites: &'a Sites<'a>,
    coverage: &'a Coverage,
    /// Half-edges of the baseline that no walk crosses.
    barrier: IdVec<CornerId, bool>,
    /// Faces of the garment that touch a cut.
    touched: IdVec<FaceId, bool>,
    /// The neighbours of each face of the garment without a cut between them; one may be there more than once.
    joined: Csr<FaceId, FaceId>,
}

impl<'a> Cuts<'a> {
    /// The cuts where `barrier` says; none of them where it says no more than the baseline.
    pub fn new(
        product: &'a SimProduct,
        sites: &'a Sites<'a>,
        coverage: &'a Coverage,
        barrier: IdVec<CornerId, bool>,
    ) -> Self {
        let base = &product.baseline;
        let t = &base.topology;
        let mut at_cut = IdVec::<VertexId, bool>::filled(false, base.points.len());
        let mut pairs: Vec<(FaceId, FaceId)> = Vec::new();
        for (face, &source) in base.source_face.enumerated() {
            for corner in t.faces.corners_of(face) {
                if barrier[corner] {
                    t.faces.half_edge(corner).into_iter().for_each(|v| at_cut[v] = true);
                } else if let Some(twin) = base.open_twin(corner) {
                    let other = base.source_face[t.faces.face_of(twin)];
                    // The edges that an edge of the garment becomes follow each other.
                    if other != source && pairs.last() != Some(&(source, other)) {
                        pairs.push((source, other));
                    }
                }
            }
        }
        let rows = coverage.faces.rows();
        let joined = Csr::group(rows, pairs.into_iter(), FaceId::new(0));
        let mut touched = IdVec::filled(false, rows);
        for (face, &source) in base.source_face.enumerated() {
            touched[source] |= t.faces.vertices_of(face).iter().any(|&v| at_cut[v]);
        }
        Self { product, sites, coverage, barrier, touched, joined }
    }

    /// The triangle of the baseline from which each face near a cut takes its values; none for others, which take those
    /// at their corners' own places.
    pub fn homes(&self) -> Vec<Option<FaceId>> {
        (0..self.product.triangles.len()).into_par_iter().map(|i| self.home(FaceId::new(i))).collect()
    }

    /// Where each corner of the simulation mesh takes its value.
    pub fn sources(&self, homes: &[Option<FaceId>]) -> IdVec<CornerId, Source> {
        let t = &self.sites.net.topology;
        let of_corner = |i: usize| self.of_corner(CornerId::new(i), homes);
        let mut sources: IdVec<CornerId, Source> =
            (0..t.faces.corners().len()).into_par_iter().map(of_corner).collect::<Vec<_>>().into();
        let mut moved: Vec<VertexId> =
            sources.enumerated().filter(|(_, s)| s.moved).map(|(c, _)| t.faces.vertex(c)).collect();
        moved.sort_unstable();
        moved.dedup();
        let agreed = |&v: &VertexId| self.agreed(t.vertex_corners.row(v), homes, &sources);
        let agreed: Vec<(CornerId, Source)> = moved.par_iter().flat_map_iter(agreed).collect();
        agreed.into_iter().for_each(|(corner, source)| sources[corner] = source);
        sources
    }

    /// Finds the sources around some faces again, whose homes are new. Returns the corners whose sources may be others.
    pub fn renew(
        &self,
        faces: &[(FaceId, FaceId)],
        homes: &[Option<FaceId>],
        sources: &mut IdVec<CornerId, Source>,
    ) -> Vec<CornerId> {
        let t = &self.sites.net.topology;
        let mut vertices: Vec<VertexId> = faces.iter().flat_map(|f| t.faces.vertices_of(f.0)).copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        for &vertex in &vertices {
            let corners = t.vertex_corners.row(vertex);
            corners.iter().for_each(|&c| sources[c] = self.of_corner(c, homes));
            let agreed = self.agreed(corners, homes, sources);
            agreed.into_iter().for_each(|(corner, source)| sources[corner] = source);
        }
        vertices.iter().flat_map(|&v| t.vertex_corners.row(v)).copied().collect()
    }

    /// New sources for corners of one vertex: one for those that lie on the same side.
    fn agreed(
        &self,
        corners: &[CornerId],
        homes: &[Option<FaceId>],
        sources: &IdVec<CornerId, Source>,
    ) -> Vec<(CornerId, Source)> {
        let mut agreed = Vec::new();
        if !corners.iter().any(|&c| sources[c].moved) {
            return agreed;
        }
        let faces: Vec<FaceId> = corners.iter().map(|&c| self.sites.net.topology.faces.face_of(c)).collect();
        let mut side: Vec<usize> = (0..corners.len()).collect();
        for i in 0..corners.len() {
            for j in 0..i {
                if side[i] != side[j] && self.are_joined(faces[i], faces[j], homes) {
                    let (from, to) = (side[i].max(side[j]), side[i].min(side[j]));
                    side.iter_mut().filter(|s| **s == from).for_each(|s| *s = to);
                }
            }
        }
        let off = |s: &Source, c: CornerId| {
            let vertex = self.sites.net.topology.faces.vertex(c);
            self.product.baseline.position(s.location).distance_squared(self.product.points[vertex])
        };
        for own in 0..corners.len() {
            let members = || (0..corners.len()).filter(|&i| side[i] == own).map(|i| corners[i]);
            let best =
                members().map(|c| (off(&sources[c], c), sources[c])).reduce(|a, b| if b.0 < a.0 { b } else { a });
            let Some((_, best)) = best else { continue };
            agreed.extend(members().filter(|&c| sources[c].moved).map(|c| (c, best)));
        }
        agreed
    }

    /// Whether two faces take their values from the same side, as far as the garment's faces around them say.
    fn are_joined(&self, a: FaceId, b: FaceId, homes: &[Option<FaceId>]) -> bool {
        let source = |face: FaceId| {
            let at = homes[face.index()].unwrap_or_else(|| self.places(face)[0].face);
            self.product.baseline.source_face[at]
        };
        let joined = |a: FaceId, b: FaceId| self.are_neighbours(a, b);
        let (from, to) = (source(a), source(b));
        let between = || {
            let rows = [a, b].into_iter().flat_map(|f| self.coverage.sources.row(f));
            rows.into_iter().any(|s| joined(from, s.face) && joined(s.face, to))
        };
        joined(from, to) || between()
    }

    fn home(&self, face: FaceId) -> Option<FaceId> {
        let row = self.coverage.sources.row(face);
        let places = self.places(face);
        let own = places.map(|p| self.product.baseline.source_face[p.face]);
        if !row.iter().map(|s| s.face).chain(own).any(|f| self.touched[f]) {
            return None;
        }
        let Some(source) = self.side(face) else { return Some(self.sites.centre(face)) };
        let is_there =
            |joined: bool| move |k: &usize| own[*k] == source || joined && self.are_neighbours(own[*k], source);
        let corner = (0..3).find(is_there(false)).or_else(|| (0..3).find(is_there(true)));
        Some(corner.map_or_else(|| self.nearest_child(source, self.centre(face)), |k| places[k].face))
    }

    /// Whether two faces of the garment are one, or neighbours without a cut between them.
    fn are_neighbours(&self, a: FaceId, b: FaceId) -> bool {
        a == b || self.joined.row(a).contains(&b)
    }

    fn places(&self, face: FaceId) -> [Location; 3] {
        [0, 1, 2].map(|k| self.product.places[CornerId::new(3 * face.index() + k)].location)
    }

    fn centre(&self, face: FaceId) -> Vec3 {
        self.product.triangles[face.index()].iter().map(|&v| self.product.points[v]).sum::<Vec3>() / 3.0
    }

    /// The garment's face that is most of the side of which a face covers the most.
    fn side(&self, face: FaceId) -> Option<FaceId> {
        let row = self.coverage.sources.row(face);
        let mut side: Vec<usize> = (0..row.len()).collect();
        for i in 0..row.len() {
            for j in 0..i {
                if side[i] != side[j] && self.are_neighbours(row[j].face, row[i].face) {
                    let (from, to) = (side[i].max(side[j]), side[i].min(side[j]));
                    side.iter_mut().filter(|s| **s == from).for_each(|s| *s = to);
                }
            }
        }
        let mut area = vec![0.0f32; row.len()];
        row.iter().zip(&side).for_each(|(share, &s)| area[s] += share.area);
        let best = (0..row.len()).reduce(|best, i| if area[i] > area[best] { i } else { best })?;
        let members = row.iter().zip(&side).filter(|(_, s)| **s == best).map(|(share, _)| share);
        members.reduce(|a, b| if b.area > a.area { b } else { a }).map(|share| share.face)
    }

    fn nearest_child(&self, source: FaceId, point: Vec3) -> FaceId {
        let base = &self.product.baseline;
        let distance = |&face: &FaceId| {
            let [a, b, c] = base.triangle(face);
            let w = crate::sim::closest_weights(a, b, c, point);
            (a * w.x + b * w.y + c * w.z).distance_squared(point)
        };
        let children = self.sites.net.children.row(source).iter().copied();
        let nearest = children.map(|f| (distance(&f), f)).reduce(|a, b| if b.0 < a.0 { b } else { a });
        nearest.map_or(FaceId::new(0), |n| n.1)
    }

    /// Where a corner takes its value, as its face sees it: in place, or at the nearest place of the face's side.
    fn of_corner(&self, corner: CornerId, homes: &[Option<FaceId>]) -> Source {
        let location = self.product.places[corner].location;
        let Some(home) = homes[corner.index() / 3] else { return Source { location, moved: false } };
        let base = &self.product.baseline;
        if self.are_neighbours(base.source_face[location.face], base.source_face[home]) {
            return Source { location, moved: false };
        }
        let vertex = self.product.triangles[corner.index() / 3][corner.index() % 3];
        let there = base.closest_within(home, self.product.points[vertex], &self.barrier);
        let moved = there.distance_squared.sqrt() > MOVED * self.product.target[vertex];
        Source { location: there.location, moved }
    }

    /// The homes of the neighbours on another side of the cuts: first across the longest edge, none across chains.
    pub fn other_homes(&self, face: FaceId, homes: &[Option<FaceId>]) -> impl Iterator<Item = FaceId> + use<> {
        let (t, net) = (&self.sites.net.topology, &self.sites.net);
        let length = |c: CornerId| {
            let [a, b] = t.faces.half_edge(c).map(|v| self.product.points[v]);
            a.distance_squared(b)
        };
        let open = t.faces.corners_of(face).filter(|&c| !net.is_chain[t.corner_edge[c]]);
        let others = open.filter_map(|c| Some((c, t.faces.face_of(net.twin[c]?))));
        let mut others: Vec<(CornerId, FaceId)> =
            others.filter(|(_, other)| !self.are_joined(face, *other, homes)).collect();
        others.sort_by(|a, b| length(b.0).total_cmp(&length(a.0)));
        let found: Vec<FaceId> = others.into_iter().filter_map(|(_, other)| homes[other.index()]).collect();
        found.into_iter()
    }

    /// Small parts of a side, with one of `seeds`, that touch the rest of it nowhere: each face with the home of a
    /// neighbour. `same` says whether two corners of one vertex have the same value.
    pub fn islands(
        &self,
        seeds: &[FaceId],
        homes: &[Option<FaceId>],
        same: impl Fn(CornerId, CornerId) -> bool + Sync,
    ) -> Vec<(FaceId, FaceId)> {
        let island = |&seed: &FaceId| self.island(seed, homes, &same).unwrap_or_default();
        let mut islands: Vec<(FaceId, FaceId)> = seeds.par_iter().flat_map_iter(island).collect();
        islands.sort_unstable();
        islands.dedup_by_key(|i| i.0);
        islands
    }

    /// The small part around a face, each face with the home of a neighbour.
    fn island(
        &self,
        seed: FaceId,
        homes: &[Option<FaceId>],
        same: impl Fn(CornerId, CornerId) -> bool,
    ) -> Option<Vec<(FaceId, FaceId)>> {
        let (t, net) = (&self.sites.net.topology, &self.sites.net);
        let next = |c| t.faces.next(c);
        let (mut part, mut size, mut beyond, mut at) = ([seed; ISLAND], 1, None, 0);
        while at < size {
            let face = part[at];
            at += 1;
            for corner in t.faces.corners_of(face) {
                let Some(twin) = net.twin[corner] else { continue };
                let other = t.faces.face_of(twin);
                if !(same(corner, next(twin)) && same(next(corner), twin)) {
                    beyond = beyond.or(homes[other.index()].filter(|_| !net.is_seam[t.corner_edge[corner]]));
                } else if !part[..size].contains(&other) {
                    if size == ISLAND {
                        return None;
                    }
                    part[size] = other;
                    size += 1;
                }
            }
        }
        beyond.map(|home| part[..size].iter().map(|&f| (f, home)).collect())
    }

    /// The source of a moved corner, continued beyond its side instead.
    pub fn continued(&self, corner: CornerId, source: Source) -> Source {
        let base = &self.product.baseline;
        let [a, b, c] = base.triangle(source.location.face);
        let vertex = self.product.triangles[corner.index() / 3][corner.index() % 3];
        let (u, v, p) = (b - a, c - a, self.product.points[vertex] - a);
        let normal = u.cross(v);
        let n = normal.length_squared();
        let (s, t) = (p.cross(v).dot(normal) / n, u.cross(p).dot(normal) / n);
        let weights = Vec3::new(1.0 - s - t, s, t);
        // A sliver would throw the value far away.
        if !weights.is_finite() || weights.abs().max_element() > 16.0 {
            return source;
        }
        Source { location: Location { face: source.location.face, weights }, ..source }
    }
}
