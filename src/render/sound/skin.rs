//! The first refinement of a cage as triangles, face by face, and which faces cross or turn over on it.
//!
//! Reference: Volino and Magnenat Thalmann 1994 (a patch all of whose normals are on one side of a plane does not cross
//! itself): faces that touch are looked at closely only where that fails.

use super::tree::{Bounds, Tree};
use crate::mesh::{CornerId, FaceId, IdVec, VertexId};
use crate::subdivide::{Level, Numbering, Stencils};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Cosine of the angle to the plane below which normals count as on its other side. Larger looks at more faces closely.
const ONE_SIDED: f32 = 0.1;
/// Cosine between a face's normal and a child's below which it is bent. Larger looks at more faces.
const EVEN: f32 = 0.8;
/// A child that looks this far to the other side is turned over, as a cosine. Nearer to 0 takes the overhang of a steep
/// flank for one.
const TURNED: f32 = -0.2;

/// What the search for crossings needs of a face.
#[derive(Clone, Copy)]
struct Patch {
    /// Mean normal.
    normal: Vec3,
    /// Least cosine between it and the normal of a child.
    spread: f32,
}

/// A cage's first refinement.
pub struct Skin<'a> {
    pub(super) level: &'a Level,
    numbering: Numbering,
    points: IdVec<VertexId, Vec3>,
    pub(super) boxes: IdVec<FaceId, Bounds>,
    patches: IdVec<FaceId, Patch>,
    tree: Option<Tree>,
}

/// A triangle of a child by its vertices and places.
struct Triangle {
    vertices: [VertexId; 3],
    points: [DVec3; 3],
}

impl<'a> Skin<'a> {
    /// The skin of a cage with the given points.
    pub fn new(level: &'a Level, points: &IdVec<VertexId, Vec3>) -> Self {
        let refined = crate::subdivide::carried_points(&level.vertex_stencils(), points);
        let mut skin = Self {
            level,
            numbering: Numbering::new(level),
            points: refined,
            boxes: IdVec::default(),
            patches: IdVec::default(),
            tree: None,
        };
        let faces = (0..level.topology.faces.len()).into_par_iter().map(FaceId::new);
        let (boxes, patches): (Vec<Bounds>, Vec<Patch>) = faces.map(|f| skin.measured(f)).unzip();
        (skin.boxes, skin.patches) = (boxes.into(), patches.into());
        skin
    }

    /// Moves the children of `faces` to where the cage's points put them now.
    pub fn update(&mut self, points: &IdVec<VertexId, Vec3>, faces: &[FaceId]) {
        let t = &self.level.topology;
        let stencils = self.level.vertex_stencils();
        for &face in faces {
            for corner in t.faces.corners_of(face) {
                for child in self.quad(face, corner) {
                    let mut place = Vec3::ZERO;
                    stencils.row(child.index(), &mut |v, w| place += w * points[v]);
                    self.points[child] = place;
                }
            }
        }
        for &face in faces {
            (self.boxes[face], self.patches[face]) = self.measured(face);
        }
        if let Some(tree) = &mut self.tree {
            tree.refit(&self.boxes);
        }
    }

    /// The children's vertices from the corner on: the vertex, the middle of its edge, the centre, the middle before.
    #[inline]
    fn quad(&self, face: FaceId, corner: CornerId) -> [VertexId; 4] {
        let t = &self.level.topology;
        [
            self.numbering.of_vertex(t.faces.vertex(corner)),
            self.numbering.of_edge(t.corner_edge[corner]),
            self.numbering.of_face(face),
            self.numbering.of_edge(t.corner_edge[self.prev(face, corner)]),
        ]
    }

    /// The corner before, without a search for its face.
    #[inline]
    fn prev(&self, face: FaceId, corner: CornerId) -> CornerId {
        let range = self.level.topology.faces.range(face);
        CornerId::new(if corner.index() == range.start { range.end - 1 } else { corner.index() - 1 })
    }

    #[inline]
    fn places(&self, face: FaceId, corner: CornerId) -> [Vec3; 4] {
        self.quad(face, corner).map(|v| self.points[v])
    }

    /// The children of a face.
    pub(super) fn quads(&self, face: FaceId) -> impl Iterator<Item = [Vec3; 4]> {
        self.level.topology.faces.corners_of(face).map(move |corner| self.places(face, corner))
    }

    /// Area vector of the child of a corner.
    #[inline]
    fn area(&self, face: FaceId, corner: CornerId) -> Vec3 {
        let [a, b, c, d] = self.places(face, corner);
        (c - a).cross(d - b)
    }

    fn measured(&self, face: FaceId) -> (Bounds, Patch) {
        let corners = self.level.topology.faces.corners_of(face);
        let (mut bounds, mut sum) = (Bounds::EMPTY, Vec3::ZERO);
        for corner in corners.clone() {
            for p in self.places(face, corner) {
                bounds = Bounds { low: bounds.low.min(p), high: bounds.high.max(p) };
            }
            sum += self.area(face, corner);
        }
        let normal = sum.normalize_or_zero();
        let spread = corners.map(|c| self.area(face, c).normalize_or_zero().dot(normal)).fold(1.0, f32::min);
        (bounds, Patch { normal, spread })
    }

    /// Faces of `active` that have a child which looks away from `normals`, zero where any may.
    pub fn turned(&self, active: &[FaceId], normals: &IdVec<FaceId, Vec3>) -> Vec<FaceId> {
        let is_turned = |face: &&FaceId| self.is_turned(**face, normals[**face], TURNED);
        active.par_iter().filter(is_turned).copied().collect()
    }

    /// Whether a child of a face looks away from `normal` by a cosine of less than `least`.
    pub fn is_turned(&self, face: FaceId, normal: Vec3, least: f32) -> bool {
        let (patch, mut corners) = (self.patches[face], self.level.topology.faces.corners_of(face));
        let is_even = patch.spread > 0.5 && patch.normal.dot(normal) > 0.5;
        normal != Vec3::ZERO && !is_even && corners.any(|c| self.area(face, c).normalize_or_zero().dot(normal) < least)
    }

    /// Whether a face's children look to different sides.
    pub fn is_bent(&self, face: FaceId) -> bool {
        self.patches[face].spread < EVEN
    }

    /// Mean normal of a face's children.
    pub fn normal(&self, face: FaceId) -> Vec3 {
        self.patches[face].normal
    }

    /// Pairs of faces that cross, or a face twice that crosses itself, with at least one of `active`, whose faces
    /// `is_active` tells.
    pub fn crossings(&mut self, active: &[FaceId], is_active: &IdVec<FaceId, bool>) -> Vec<[FaceId; 2]> {
        let boxes = &self.boxes;
        self.tree.get_or_insert_with(|| Tree::new(boxes));
        let Some(tree) = &self.tree else { return Vec::new() };
        let with = |&face: &FaceId| {
            let mut found: Vec<[FaceId; 2]> = Vec::new();
            tree.visit(&self.boxes, &self.boxes[face], &mut |other| {
                let is_other_turn = is_active[other] && other.index() < face.index();
                if !is_other_turn && self.cross(face, other) {
                    found.push([face, other]);
                }
            });
            found.sort_unstable();
            found
        };
        active.par_iter().flat_map_iter(with).collect()
    }

    /// Whether the children of two faces cross, or of one.
    pub fn cross(&self, f: FaceId, g: FaceId) -> bool {
        if f == g {
            return self.patches[f].spread < ONE_SIDED && self.children_cross(f, g);
        }
        let faces = &self.level.topology.faces;
        let touch = faces.vertices_of(f).iter().any(|v| faces.vertices_of(g).contains(v));
        match touch {
            true => !self.is_one_sided(f, g) && self.children_cross(f, g),
            false => {
                !self.is_apart(f, g, self.patches[f].normal)
                    && !self.is_apart(f, g, self.patches[g].normal)
                    && self.children_cross(f, g)
            }
        }
    }

    fn is_one_sided(&self, f: FaceId, g: FaceId) -> bool {
        let (a, b) = (self.patches[f], self.patches[g]);
        let axis = (a.normal + b.normal).normalize_or_zero();
        if a.spread.min(b.spread) > 0.9 && a.normal.dot(axis) > 0.6 {
            return true;
        }
        let faces = &self.level.topology.faces;
        let mut corners = [f, g].into_iter().flat_map(|face| faces.corners_of(face).map(move |c| (face, c)));
        corners.all(|(face, c)| self.area(face, c).normalize_or_zero().dot(axis) > ONE_SIDED)
    }

    /// Whether a plane across `axis` parts two faces.
    fn is_apart(&self, f: FaceId, g: FaceId, axis: Vec3) -> bool {
        let range = |face: FaceId| {
            let corners = self.level.topology.faces.corners_of(face);
            let heights = corners.flat_map(|c| self.places(face, c)).map(|p| p.dot(axis));
            heights.fold((f32::MAX, f32::MIN), |(low, high), h| (low.min(h), high.max(h)))
        };
        let ((a, b), (c, d)) = (range(f), range(g));
        b < c || d < a
    }

    fn children_cross(&self, f: FaceId, g: FaceId) -> bool {
        let faces = &self.level.topology.faces;
        for (i, a) in faces.corners_of(f).enumerate() {
            let bounds = Bounds::of(&self.places(f, a));
            for (j, b) in faces.corners_of(g).enumerate() {
                // A child's own two triangles have an edge in common.
                if (f == g && j <= i) || !bounds.meets(&Bounds::of(&self.places(g, b))) {
                    continue;
                }
                let (first, second) = (self.triangles(f, a), self.triangles(g, b));
                if first.iter().any(|x| second.iter().any(|y| pierce(x, y))) {
                    return true;
                }
            }
        }
        false
    }

    /// The child of a corner, cut as the refined mesh has it.
    fn triangles(&self, face: FaceId, corner: CornerId) -> [Triangle; 2] {
        let range = self.level.topology.faces.range(face);
        let is_odd = range.len() == 4 && (corner.index() - range.start) % 2 == 1;
        let [a, b, c, d] = self.quad(face, corner);
        let cut = if is_odd { [[b, c, d], [b, d, a]] } else { [[a, b, c], [a, c, d]] };
        cut.map(|vertices| Triangle { vertices, points: vertices.map(|v| self.points[v].as_dvec3()) })
    }
}

/// Whether triangles without a common vertex pass through each other.
fn pierce(a: &Triangle, b: &Triangle) -> bool {
    let joined = a.vertices.iter().any(|v| b.vertices.contains(v));
    !joined && (edges_pierce(&a.points, &b.points) || edges_pierce(&b.points, &a.points))
}

/// Whether an edge of `a` passes through `b`.
fn edges_pierce(a: &[DVec3; 3], &[p, q, r]: &[DVec3; 3]) -> bool {
    let normal = (q - p).cross(r - p);
    let side = a.map(|x| (x - p).dot(normal));
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
