//! A face of a cage refined once: its children in SIMD blocks of four, with their normals and bounds.

use super::bvh::Aabb;
use super::simd::{Aabbx4, Intervalx4, Mask, Vec3x4, WIDTH, bits};
use super::{FACES_PER_TASK, evaluate, unique};
use glam::{Vec3, Vec4};
use rayon::prelude::*;
use tailor_mesh::connectivity::{FaceId, IdVec, VertexId};
use tailor_mesh::subdivide::{Level, Numbering, VertexRows};

/// Cosine between a face's normal and a child's below which the face is bent. Larger makes fewer faces smooth.
pub const SMOOTH: f32 = 0.9;
/// Cosine between the normals of a face with and without displacement below which the face is not smooth.
const UNDISTURBED: f32 = 0.5;
/// Cosine of a corner's angle above which a triangle is a sliver.
const SLIVER: f32 = 0.9;
/// Area of a corner of a child, as a share of the child's, by which the corner may turn inwards: rounding.
const REFLEX: f32 = 1e-4;

/// A child of a face: the face, and the number of its corner at which the child is.
pub type ChildId = (FaceId, usize);

/// Up to four children of a face. Elements without a child repeat the last one.
///
/// Points have OpenSubdiv's names: a vertex point, an edge point and a face point belong to a vertex, an edge and a face of
/// the cage.
#[derive(Clone, Copy)]
pub struct ChildBlock {
    pub vertex_points: Vec3x4,
    /// The points of the edges that leave the vertices.
    pub edge_points: Vec3x4,
    pub face_point: Vec3,
    /// The number of children.
    pub count: usize,
    /// The points of the edges before the vertices.
    pub previous_edge_points: Vec3x4,
    /// Unit normals, zero without area.
    pub normals: Vec3x4,
    /// Whether all children are convex.
    pub is_convex: bool,
}

/// A face with its children.
pub struct RefinedFace {
    pub face: FaceId,
    pub valence: usize,
    /// The first vertices; all of a triangle or quad.
    pub vertices: [VertexId; WIDTH],
    /// Mean normal.
    pub normal: Vec3,
    /// Least cosine between it and the normal of a child.
    pub least_cosine: f32,
    /// Interval along the normal.
    pub extent: (f32, f32),
    pub aabb: Aabb,
    /// The first children.
    pub first: ChildBlock,
    /// The children after the first four.
    others: Box<[ChildBlock]>,
    /// Almost flat, near its normal without displacement, no sliver, and with convex children.
    pub is_smooth: bool,
    /// Whether it may overlap a neighbour within their common plane: a sliver, a face moved within its plane, or one with a
    /// child that is not convex.
    pub may_overlap: bool,
    /// Whether all children are convex.
    pub is_convex: bool,
}

/// The first refinement of a cage.
pub struct Refinement<'a> {
    pub level: &'a Level,
    /// Its points as weighted sums of the cage's.
    pub rows: VertexRows<'a>,
    pub numbering: Numbering,
    pub points: IdVec<VertexId, Vec3>,
    /// Normals of the faces without displacement, zero where unknown. None if all are.
    pub rest_normals: Option<&'a IdVec<FaceId, Vec3>>,
}

impl Refinement<'_> {
    /// A face with its children.
    pub fn face(&self, face: FaceId) -> RefinedFace {
        let vertices = self.level.topology.faces.vertices_of(face);
        let (first, mut area) = self.block(face, 0);
        let more = (WIDTH..vertices.len()).step_by(WIDTH).map(|from| self.block(face, from));
        let others: Box<[ChildBlock]> =
            more.inspect(|(_, of_block)| area += of_block).map(|(block, _)| block).collect();
        let blocks = || std::iter::once(&first).chain(&others);
        let normal = area.normalize_or_zero();
        let least_cosine = blocks().map(|block| block.normals.dot(normal).min_element()).fold(1.0, f32::min);
        let aabb = aabb(blocks());
        let is_undisturbed = self.rest_normals.is_some_and(|normals| normal.dot(normals[face]) >= UNDISTURBED);
        let is_sliver = vertices.len() == 3 && first.is_sliver();
        let is_convex = blocks().all(|block| block.is_convex);
        let mut refined = RefinedFace {
            face,
            valence: vertices.len(),
            vertices: std::array::from_fn(|i| vertices[if i < vertices.len() { i } else { 0 }]),
            normal,
            least_cosine,
            extent: (0.0, 0.0),
            aabb,
            is_smooth: is_undisturbed && least_cosine >= SMOOTH && !is_sliver && is_convex,
            may_overlap: is_sliver || !is_convex,
            is_convex,
            first,
            others,
        };
        refined.extent = refined.extent(normal);
        refined
    }

    /// The children of a face from number `first` on, and twice their area as a vector.
    fn block(&self, face: FaceId, first: usize) -> (ChildBlock, Vec3) {
        let t = &self.level.topology;
        let (vertices, range) = (t.faces.vertices_of(face), t.faces.range(face));
        let edges = &t.corner_edge.as_slice()[range];
        let (last, count) = (vertices.len() - 1, (vertices.len() - first).min(WIDTH));
        let child: [usize; WIDTH] = std::array::from_fn(|i| (first + i).min(last));
        let vertex_point = |i: usize| self.points[self.numbering.of_vertex(vertices[i])];
        let edge_point = |i: usize| self.points[self.numbering.of_edge(edges[i])];
        let own_edges = child.map(edge_point);
        let previous = |i: usize| {
            let edge = if child[i] == 0 { last } else { child[i] - 1 };
            own_edges.get(edge.wrapping_sub(first)).copied().unwrap_or_else(|| edge_point(edge))
        };
        let edge_points = Vec3x4::new(own_edges);
        let is_quad = vertices.len() == WIDTH;
        let mut block = ChildBlock {
            vertex_points: Vec3x4::new(child.map(vertex_point)),
            edge_points,
            face_point: self.points[self.numbering.of_face(face)],
            count,
            previous_edge_points: if is_quad {
                edge_points.rotated()
            } else {
                Vec3x4::new(std::array::from_fn(previous))
            },
            normals: Vec3x4::default(),
            is_convex: true,
        };
        let areas = (Vec3x4::splat(block.face_point) - block.vertex_points)
            .cross(&(block.previous_edge_points - block.edge_points));
        block.normals = areas.normalize_or_zero();
        block.is_convex = block.has_convex_corners(&areas);
        (block, (0..count).map(|i| areas.at(i)).sum())
    }

    /// Moves the children of some faces to where `points` of the cage put them.
    pub fn update(&mut self, points: &IdVec<VertexId, Vec3>, faces: &[FaceId]) {
        let (t, numbering) = (&self.level.topology, self.numbering);
        let at_corner = |c| [numbering.of_vertex(t.faces.vertex(c)), numbering.of_edge(t.corner_edge[c])];
        let of_face = |&f| t.faces.corners_of(f).flat_map(at_corner).chain([numbering.of_face(f)]);
        let children = unique(self.points.len(), faces.iter().flat_map(of_face));
        let evaluated = |&child: &VertexId| evaluate(&self.rows, child, points);
        let moved: Vec<Vec3> = children.par_iter().with_min_len(FACES_PER_TASK).map(evaluated).collect();
        children.iter().zip(moved).for_each(|(&child, point)| self.points[child] = point);
    }
}

impl RefinedFace {
    /// The box of a face that others may cross: that of no point if all of the face is one point.
    pub fn crossable(&self) -> Aabb {
        if self.aabb.low == self.aabb.high { Aabb::EMPTY } else { self.aabb }
    }

    /// The children.
    #[inline]
    pub fn blocks(&self) -> impl Iterator<Item = &ChildBlock> + Clone {
        std::iter::once(&self.first).chain(&self.others)
    }

    #[inline]
    pub fn block(&self, number: usize) -> &ChildBlock {
        if number == 0 { &self.first } else { &self.others[number - 1] }
    }

    /// The corners of a child: vertex point, edge point, face point, previous edge point.
    pub fn child(&self, number: usize) -> [Vec3; 4] {
        self.block(number / WIDTH).child(number % WIDTH)
    }

    /// Interval along an axis.
    #[inline]
    pub fn extent(&self, axis: Vec3) -> (f32, f32) {
        let others = self.others.iter().map(|block| block.extents(axis));
        others.fold(self.first.extents(axis), |all, of| all.merged(&of)).whole()
    }

    /// Whether the normals of all children have at least this cosine with an axis.
    #[inline]
    pub fn all_face(&self, axis: Vec3, least: f32) -> bool {
        self.blocks().all(|block| block.normals.dot(axis).cmpge(Vec4::splat(least)).all())
    }
}

impl ChildBlock {
    /// Whether no corner of a child turns inwards. `areas` are twice those of the children.
    fn has_convex_corners(&self, areas: &Vec3x4) -> bool {
        let (vertex, edge, previous) = (self.vertex_points, self.edge_points, self.previous_edge_points);
        let face = Vec3x4::splat(self.face_point);
        let least = areas.dots(&self.normals) * -REFLEX;
        let is_convex = |corner: &Vec3x4, next: &Vec3x4, before: &Vec3x4| {
            (*next - *corner).cross(&(*before - *corner)).dots(&self.normals).cmpge(least).all()
        };
        is_convex(&vertex, &edge, &previous)
            && is_convex(&edge, &face, &vertex)
            && is_convex(&face, &previous, &edge)
            && is_convex(&previous, &vertex, &face)
    }

    /// Whether the triangle whose children these are is a sliver.
    fn is_sliver(&self) -> bool {
        let [a, b, c] = [0, 1, 2].map(|i| self.vertex_points.at(i));
        let [ab, bc, ca] = [b - a, c - b, a - c].map(Vec3::normalize_or_zero);
        (-ca.dot(ab)).max(-ab.dot(bc)).max(-bc.dot(ca)) > SLIVER
    }

    /// The elements that have a child.
    #[inline]
    pub fn mask(&self) -> Mask {
        (1 << self.count) - 1
    }

    /// The corners of a child: vertex point, edge point, face point, previous edge point.
    #[inline]
    pub fn child(&self, i: usize) -> [Vec3; 4] {
        [self.vertex_points.at(i), self.edge_points.at(i), self.face_point, self.previous_edge_points.at(i)]
    }

    /// The block with its points, except for the normals, in a frame.
    #[inline]
    pub fn in_frame(&self, axes: &[Vec3; 3]) -> Self {
        Self {
            vertex_points: self.vertex_points.in_frame(axes),
            edge_points: self.edge_points.in_frame(axes),
            previous_edge_points: self.previous_edge_points.in_frame(axes),
            face_point: Vec3::from(axes.map(|axis| axis.dot(self.face_point))),
            ..*self
        }
    }

    /// The boxes of the children.
    #[inline]
    pub fn aabbs(&self) -> Aabbx4 {
        let face_point = Vec3x4::splat(self.face_point);
        Aabbx4::of([&self.vertex_points, &self.edge_points, &self.previous_edge_points, &face_point])
    }

    /// Intervals along an axis. The previous edge points of a face are its edge points too, so its interval needs no more.
    #[inline]
    fn extents(&self, axis: Vec3) -> Intervalx4 {
        let (a, b) = (self.vertex_points.dot(axis), self.edge_points.dot(axis));
        let c = Vec4::splat(self.face_point.dot(axis));
        Intervalx4 { low: a.min(b).min(c), high: a.max(b).max(c) }
    }
}

/// The box of blocks.
pub fn aabb<'a>(blocks: impl Iterator<Item = &'a ChildBlock>) -> Aabb {
    blocks.map(|block| block.aabbs().whole()).fold(Aabb::EMPTY, |all, of| all.merged(&of))
}

/// The points of a face's refinement: vertex points, edge points and the face point.
pub fn points<'a>(blocks: impl Iterator<Item = &'a ChildBlock> + Clone) -> impl Iterator<Item = Vec3> + Clone {
    let face_point = blocks.clone().next().map(|block| block.face_point);
    blocks.flat_map(|b| bits(b.mask()).flat_map(|i| [b.vertex_points.at(i), b.edge_points.at(i)])).chain(face_point)
}
