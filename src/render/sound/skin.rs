//! The first refinement of a cage as triangles, face by face, and which faces cross or turn over on it.
//!
//! Reference: Volino and Magnenat Thalmann 1994 (a patch all of whose normals are on one side of a plane does not cross
//! itself): faces that touch are looked at closely only where that fails.

use super::tree::{Bounds, Tree};
use crate::mesh::{CornerId, FaceId, IdVec, VertexId};
use crate::subdivide::{Cage, Level, Numbering, Stencils, VertexRows};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// Cosine of the angle to the plane below which normals count as on its other side. Larger looks at more faces closely.
const ONE_SIDED: f32 = 0.1;
/// Cosine between a face's normal and a child's below which it is bent. Larger looks at more faces.
const EVEN: f32 = 0.8;
/// A child that looks this far to the other side is turned over, as a cosine. Nearer to 0 takes the overhang of a steep
/// flank for one.
const TURNED: f32 = -0.2;

/// Faces that are measured in one go.
const BLOCK: usize = 512;

/// What the search for crossings needs of a face.
#[derive(Clone, Copy, Default)]
struct Patch {
    /// Mean normal.
    normal: Vec3,
    /// Least cosine between it and the normal of a child.
    spread: f32,
    /// Range along the normal.
    heights: (f32, f32),
}

/// A child by its face and its number there, and its quad.
type Child<'a> = (FaceId, usize, &'a [Vec3; 4]);

/// A cage's first refinement, stored face by face, so that a pair of faces is two pieces of memory.
pub struct Skin<'a> {
    pub(super) level: &'a Level,
    rows: VertexRows<'a>,
    numbering: Numbering,
    refined: IdVec<VertexId, Vec3>,
    /// The children's points: of each face corners and middles of edges by turns, then the centre.
    samples: Vec<Vec3>,
    /// Unit normals of the children, zero without area.
    normals: IdVec<CornerId, Vec3>,
    pub(super) boxes: IdVec<FaceId, Bounds>,
    patches: IdVec<FaceId, Patch>,
    tree: Option<Tree>,
}

impl<'a> Skin<'a> {
    /// The skin of a cage with the given points.
    pub fn new(cage: &'a Cage, points: &IdVec<VertexId, Vec3>) -> Self {
        let mut skin = Self::empty(cage.level(), cage.vertex_rows(), cage.refined_points(points));
        skin.measure_all();
        skin
    }

    /// The skin of some faces of a cage, which alone may be asked about.
    pub fn of(level: &'a Level, points: &IdVec<VertexId, Vec3>, faces: &[FaceId]) -> Self {
        let refined = IdVec::filled(Vec3::ZERO, Numbering::new(level).vertices());
        let mut skin = Self::empty(level, VertexRows::Masks(level.vertex_stencils()), refined);
        skin.update(points, faces);
        skin
    }

    fn empty(level: &'a Level, rows: VertexRows<'a>, refined: IdVec<VertexId, Vec3>) -> Self {
        let all = &level.topology.faces;
        Self {
            level,
            rows,
            numbering: Numbering::new(level),
            refined,
            samples: vec![Vec3::ZERO; 2 * all.corners().len() + all.len()],
            normals: IdVec::filled(Vec3::ZERO, all.corners().len()),
            boxes: IdVec::filled(Bounds::EMPTY, all.len()),
            patches: IdVec::filled(Patch::default(), all.len()),
            tree: None,
        }
    }

    fn measure_all(&mut self) {
        let (level, numbering, refined) = (self.level, self.numbering, &self.refined);
        let faces = &level.topology.faces;
        let (mut samples, mut normals) = (self.samples.as_mut_slice(), self.normals.as_mut_slice());
        let mut blocks = Vec::new();
        for first in (0..faces.len()).step_by(BLOCK) {
            let own = first..faces.len().min(first + BLOCK);
            let corners: usize = own.clone().map(|face| faces.valence(FaceId::new(face))).sum();
            let (own_samples, own_normals);
            (own_samples, samples) = samples.split_at_mut(2 * corners + own.len());
            (own_normals, normals) = normals.split_at_mut(corners);
            blocks.push((own, own_samples, own_normals));
        }
        let boxes = self.boxes.as_mut_slice().par_chunks_mut(BLOCK);
        let known = boxes.zip(self.patches.as_mut_slice().par_chunks_mut(BLOCK));
        blocks.into_par_iter().zip(known).for_each(|((own, mut samples, mut normals), (boxes, patches))| {
            for ((face, bounds), patch) in own.map(FaceId::new).zip(boxes).zip(patches) {
                let (its_samples, its_normals);
                (its_samples, samples) = samples.split_at_mut(2 * faces.valence(face) + 1);
                (its_normals, normals) = normals.split_at_mut(faces.valence(face));
                let children = vertices(level, numbering, face).map(|v| refined[v]);
                (*bounds, *patch) = measure(children, its_samples, its_normals);
            }
        });
    }

    /// Moves the children of `faces` to where the cage's points put them now.
    pub fn update(&mut self, points: &IdVec<VertexId, Vec3>, faces: &[FaceId]) {
        let (level, numbering) = (self.level, self.numbering);
        let mut is_moved = IdVec::filled(false, self.refined.len());
        faces.iter().flat_map(|&f| vertices(level, numbering, f)).for_each(|child| is_moved[child] = true);
        for child in is_moved.ids().filter(|&child| is_moved[child]) {
            let mut place = Vec3::ZERO;
            self.rows.row(child.index(), &mut |v, w| place += w * points[v]);
            self.refined[child] = place;
        }
        for &face in faces {
            let (range, corners) = (self.range(face), level.topology.faces.range(face));
            let children = vertices(level, numbering, face).map(|v| self.refined[v]);
            (self.boxes[face], self.patches[face]) =
                measure(children, &mut self.samples[range], &mut self.normals.as_mut_slice()[corners]);
        }
        if let Some(tree) = &mut self.tree {
            tree.refit(&self.boxes);
        }
    }

    #[inline]
    fn range(&self, face: FaceId) -> Range<usize> {
        let corners = self.level.topology.faces.range(face);
        2 * corners.start + face.index()..2 * corners.end + face.index() + 1
    }

    /// The children's points: corners and middles of edges by turns, then the centre.
    #[inline]
    pub(super) fn samples(&self, face: FaceId) -> &[Vec3] {
        &self.samples[self.range(face)]
    }

    /// Unit normals of the children of a face, zero without area.
    #[inline]
    fn normals(&self, face: FaceId) -> &[Vec3] {
        &self.normals.as_slice()[self.level.topology.faces.range(face)]
    }

    /// Faces of `active` that have a child which looks away from `normals`, zero where any may.
    pub fn turned(&self, active: &[FaceId], normals: &IdVec<FaceId, Vec3>) -> Vec<FaceId> {
        let is_turned = |face: &&FaceId| self.is_turned(**face, normals[**face], TURNED);
        active.par_iter().filter(is_turned).copied().collect()
    }

    /// Whether a child of a face looks away from `normal` by a cosine of less than `least`.
    pub fn is_turned(&self, face: FaceId, normal: Vec3, least: f32) -> bool {
        normal != Vec3::ZERO && self.normals(face).iter().any(|n| n.dot(normal) < least)
    }

    /// Whether a face's children look to different sides.
    pub fn is_bent(&self, face: FaceId) -> bool {
        self.patches[face].spread < EVEN
    }

    /// Mean normal of a face's children.
    pub fn normal(&self, face: FaceId) -> Vec3 {
        self.patches[face].normal
    }

    /// Pairs of faces that cross, or a face twice that crosses itself, with at least one that is active.
    pub fn crossings(&mut self, is_active: &IdVec<FaceId, bool>) -> Vec<[FaceId; 2]> {
        let boxes = &self.boxes;
        self.tree.get_or_insert_with(|| Tree::new(boxes));
        let Some(tree) = &self.tree else { return Vec::new() };
        // What is near one face is near the others of its group.
        let of_group = |group: usize| {
            let mut found: Vec<[FaceId; 2]> = Vec::new();
            let own: Vec<(FaceId, &Bounds)> = tree.group(group).filter(|(face, _)| is_active[*face]).collect();
            let around = own.iter().fold(Bounds::EMPTY, |all, (_, b)| all.and(b));
            tree.visit(&around, &mut |other, bounds| {
                let is_own_turn = |face: FaceId| !is_active[other] || face <= other;
                let near = own.iter().filter(|(face, b)| is_own_turn(*face) && b.meets(bounds));
                found.extend(near.map(|&(face, _)| [face, other]).filter(|&[f, g]| self.cross(f, g)));
            });
            found
        };
        (0..tree.groups()).into_par_iter().flat_map_iter(of_group).collect()
    }

    /// Whether the children of two faces cross, or of one.
    pub fn cross(&self, f: FaceId, g: FaceId) -> bool {
        if f == g {
            return self.patches[f].spread < ONE_SIDED && self.children_cross(f, g, true);
        }
        if self.touch(f, g) {
            return !self.is_one_sided(f, g) && self.children_cross(f, g, true);
        }
        !self.is_apart(f, g) && !self.is_apart(g, f) && self.children_cross(f, g, false)
    }

    /// Whether two faces have a vertex in common.
    pub(super) fn touch(&self, f: FaceId, g: FaceId) -> bool {
        let faces = &self.level.topology.faces;
        let (a, b) = (faces.vertices_of(f), faces.vertices_of(g));
        if let (Ok(a), Ok(b)) = (<&[VertexId; 4]>::try_from(a), <&[VertexId; 4]>::try_from(b)) {
            // All at once is faster than to stop at the first.
            return a.iter().fold(false, |any, v| b.iter().fold(any, |any, w| any | (v == w)));
        }
        a.iter().any(|v| b.contains(v))
    }

    /// Whether faces that touch cannot cross, as they look to one side. Of the narrow triangles where a seam ends, one may
    /// pass another all the same.
    fn is_one_sided(&self, f: FaceId, g: FaceId) -> bool {
        if [f, g].iter().any(|&face| self.level.topology.faces.valence(face) != 4) {
            return false;
        }
        let (a, b) = (self.patches[f], self.patches[g]);
        let axis = (a.normal + b.normal).normalize_or_zero();
        let is_even = a.spread.min(b.spread) > 0.9 && a.normal.dot(axis) > 0.6;
        is_even || [f, g].iter().all(|&face| self.normals(face).iter().all(|n| n.dot(axis) > ONE_SIDED))
    }

    /// Whether a plane across the normal of `f` parts two faces.
    fn is_apart(&self, f: FaceId, g: FaceId) -> bool {
        let Patch { normal, heights: (low, high), .. } = self.patches[f];
        let mut heights = self.samples(g).iter().map(|p| p.dot(normal));
        // All on the side of the first one.
        match heights.next() {
            Some(first) if first > high => heights.all(|h| h > high),
            Some(first) if first < low => heights.all(|h| h < low),
            _ => false,
        }
    }

    /// `joined` tells whether they may have vertices in common.
    fn children_cross(&self, f: FaceId, g: FaceId, joined: bool) -> bool {
        let near = |face: FaceId, other: FaceId| {
            let children = quads(self.samples(face)).enumerate().map(|(i, quad)| (i, quad, Bounds::of(&quad)));
            children.filter(move |(_, _, bounds)| bounds.meets(&self.boxes[other]))
        };
        let of_g: Vec<(usize, [Vec3; 4], Bounds)> = near(g, f).collect();
        if of_g.is_empty() {
            return false;
        }
        near(f, g).any(|(i, a, bounds)| {
            // A child's own two triangles have an edge in common.
            let others = of_g.iter().filter(|(j, _, its)| (f != g || *j > i) && bounds.meets(its));
            others.into_iter().any(|(j, b, _)| {
                let mut looks = [self.normals(f)[i], self.normals(g)[*j]].into_iter();
                let are_apart = looks.any(|axis| are_apart(heights(&a, axis), heights(b, axis)));
                !are_apart && self.triangles_cross((f, i, &a), (g, *j, b), joined)
            })
        })
    }

    /// Whether the triangles of two children cross, given with their faces and quads.
    fn triangles_cross(&self, (f, i, a): Child, (g, j, b): Child, joined: bool) -> bool {
        // Triangles that have a vertex in common do not count.
        let mut same = [[false; 4]; 4];
        if joined {
            let (a, b) = (self.quad_vertices(f, i), self.quad_vertices(g, j));
            same = a.map(|v| b.map(|w| v == w));
        }
        let are_joined = |x: &[usize; 3], y: &[usize; 3]| x.iter().any(|&k| y.iter().any(|&l| same[k][l]));
        let (first, second) = (self.cuts(f, i), self.cuts(g, j));
        let (a, b) = (a.map(|p| p.as_dvec3()), b.map(|p| p.as_dvec3()));
        let pierces = |x: &[usize; 3], y: &[usize; 3]| !are_joined(x, y) && pierce(&x.map(|k| a[k]), &y.map(|k| b[k]));
        first.iter().any(|x| second.iter().any(|y| pierces(x, y)))
    }

    /// The two triangles of a child, by places in its quad, cut as the refined mesh has it.
    fn cuts(&self, face: FaceId, child: usize) -> [[usize; 3]; 2] {
        let is_odd = self.level.topology.faces.valence(face) == 4 && child % 2 == 1;
        if is_odd { [[1, 2, 3], [1, 3, 0]] } else { [[0, 1, 2], [0, 2, 3]] }
    }

    /// The vertices of a child, in the order of its quad.
    fn quad_vertices(&self, face: FaceId, child: usize) -> [VertexId; 4] {
        let t = &self.level.topology;
        let corners = t.faces.range(face);
        let corner = CornerId::new(corners.start + child);
        let prev = CornerId::new(if child == 0 { corners.end - 1 } else { corner.index() - 1 });
        let middle = |c: CornerId| self.numbering.of_edge(t.corner_edge[c]);
        let own = self.numbering.of_vertex(t.faces.vertex(corner));
        [own, middle(corner), self.numbering.of_face(face), middle(prev)]
    }
}

/// The children of a face from its samples: the corner, the middle of its edge, the centre, the middle before.
#[inline]
pub(super) fn quads(samples: &[Vec3]) -> impl Iterator<Item = [Vec3; 4]> {
    let last = samples.len() - 1;
    (0..last / 2).map(move |i| {
        let before = if i == 0 { last - 1 } else { 2 * i - 1 };
        [samples[2 * i], samples[2 * i + 1], samples[last], samples[before]]
    })
}

/// Area vector of a quad, twice.
#[inline]
fn area([a, b, c, d]: [Vec3; 4]) -> Vec3 {
    (c - a).cross(d - b)
}

/// The vertices of a face's children, in the order of its samples.
fn vertices(level: &Level, numbering: Numbering, face: FaceId) -> impl Iterator<Item = VertexId> {
    let t = &level.topology;
    let of = move |c| [numbering.of_vertex(t.faces.vertex(c)), numbering.of_edge(t.corner_edge[c])];
    t.faces.corners_of(face).flat_map(of).chain(std::iter::once(numbering.of_face(face)))
}

/// Puts the samples of a face where its children are, and measures them.
fn measure(children: impl Iterator<Item = Vec3>, samples: &mut [Vec3], normals: &mut [Vec3]) -> (Bounds, Patch) {
    samples.iter_mut().zip(children).for_each(|(sample, child)| *sample = child);
    normals.iter_mut().zip(quads(samples)).for_each(|(normal, quad)| *normal = area(quad).normalize_or_zero());
    let normal = quads(samples).map(area).sum::<Vec3>().normalize_or_zero();
    let spread = normals.iter().map(|n| n.dot(normal)).fold(1.0, f32::min);
    (Bounds::of(samples), Patch { normal, spread, heights: heights(samples, normal) })
}

/// The range of points along an axis.
#[inline]
pub(super) fn heights(points: &[Vec3], axis: Vec3) -> (f32, f32) {
    // Comparisons are single instructions, where `f32::min` must see to what is not a number in either.
    let add = |(low, high), h| (if h < low { h } else { low }, if h > high { h } else { high });
    points.iter().map(|p| p.dot(axis)).fold((f32::MAX, f32::MIN), add)
}

fn are_apart((a, b): (f32, f32), (c, d): (f32, f32)) -> bool {
    b < c || d < a
}

/// Whether triangles without a common vertex pass through each other.
fn pierce(a: &[DVec3; 3], b: &[DVec3; 3]) -> bool {
    let of_b = sides(a, b);
    if is_one_side(&of_b) {
        return false;
    }
    let of_a = sides(b, a);
    !is_one_side(&of_a) && (edges_pierce(a, &of_b, b) || edges_pierce(b, &of_a, a))
}

/// How far the corners of `a` are before the plane of `b`, times its area.
fn sides(a: &[DVec3; 3], &[p, q, r]: &[DVec3; 3]) -> [f64; 3] {
    let normal = (q - p).cross(r - p);
    a.map(|x| (x - p).dot(normal))
}

fn is_one_side(sides: &[f64; 3]) -> bool {
    sides.iter().all(|&s| s > 0.0) || sides.iter().all(|&s| s < 0.0)
}

/// Whether an edge of `a`, whose corners are on these sides of `b`, passes through `b`.
fn edges_pierce(a: &[DVec3; 3], side: &[f64; 3], &[p, q, r]: &[DVec3; 3]) -> bool {
    let normal = (q - p).cross(r - p);
    (0..3).any(|i| {
        let (s, t) = (side[i], side[(i + 1) % 3]);
        if s * t >= 0.0 {
            return false;
        }
        let x = a[i] + (a[(i + 1) % 3] - a[i]) * (s / (s - t));
        let inside = |u: DVec3, v: DVec3| (v - u).cross(x - u).dot(normal) >= 0.0;
        inside(p, q) && inside(q, r) && inside(r, p)
    })
}
