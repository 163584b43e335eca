//! The faces of a cage refined once, in an order in which neighbours in space are near in memory.

use super::bvh::Bvh;
use super::face::{ChildId, RefinedFace, Refinement};
use super::{FACES_PER_TASK, each_once, faces_at};
use glam::Vec3;
use rayon::prelude::*;
use std::sync::OnceLock;
use tailor_mesh::connectivity::{CornerId, FaceId, IdVec, VertexId};
use tailor_mesh::subdivide::{Level, Numbering, Stencils, VertexRows, carried_points};

/// Cosine between a child's normal and a direction below which it is flipped. Nearer to 0 takes the overhang of a steep
/// flank for a flipped child.
const FLIPPED: f32 = -0.1;
/// The slot of a face that is not here.
const NONE: u32 = u32::MAX;

/// Faces of a cage refined once.
pub struct RefinedFaces<'a> {
    pub(super) refinement: Refinement<'a>,
    pub(super) faces: Vec<RefinedFace>,
    /// Where each face is in `faces`.
    slots: IdVec<FaceId, u32>,
    /// The boxes that others may cross.
    tree: OnceLock<Bvh>,
}

impl<'a> RefinedFaces<'a> {
    /// The faces of a level in an order, refined by `rows`, which are those of the level. `rest_normals` are those of
    /// the faces without displacement, zero where unknown.
    pub fn new(
        level: &'a Level,
        rows: VertexRows<'a>,
        points: &IdVec<VertexId, Vec3>,
        order: &[FaceId],
        rest_normals: Option<&'a IdVec<FaceId, Vec3>>,
    ) -> Self {
        let mut faces = Self::with(level, carried_points(&rows, points), rows, rest_normals);
        faces.extend(order);
        faces
    }

    /// No faces of a level yet. Only faces that are added may be asked about.
    pub fn empty(level: &'a Level) -> Self {
        Self::with(level, IdVec::filled(Vec3::ZERO, Numbering::new(level).vertices()), level.vertex_rows(), None)
    }

    fn with(
        level: &'a Level,
        points: IdVec<VertexId, Vec3>,
        rows: VertexRows<'a>,
        rest_normals: Option<&'a IdVec<FaceId, Vec3>>,
    ) -> Self {
        let slots = IdVec::filled(NONE, level.topology.faces.len());
        let refinement = Refinement { level, rows, numbering: Numbering::new(level), points, rest_normals };
        Self { refinement, faces: Vec::new(), slots, tree: OnceLock::new() }
    }

    /// Adds the faces among `faces` that are missing, with the points of the cage.
    pub fn add(&mut self, points: &IdVec<VertexId, Vec3>, faces: impl Iterator<Item = FaceId>) {
        let new = each_once(faces.filter(|&face| self.slots[face] == NONE).collect());
        if !new.is_empty() {
            self.refinement.update(points, &new);
            self.extend(&new);
        }
    }

    fn extend(&mut self, faces: &[FaceId]) {
        tailor_mesh::meter::check_for(size_of::<RefinedFace>() * faces.len());
        faces.iter().zip(self.faces.len() as u32..).for_each(|(&face, slot)| self.slots[face] = slot);
        self.faces.par_extend(faces.par_iter().with_min_len(FACES_PER_TASK).map(|&face| self.refinement.face(face)));
    }

    /// Moves the faces to new points of the cage; `vertices` are those that changed. Returns the faces with a moved child,
    /// ascending.
    pub fn update(&mut self, points: &IdVec<VertexId, Vec3>, vertices: &[VertexId]) -> Vec<FaceId> {
        let t = &self.refinement.level.topology;
        let at = faces_at(t, vertices.iter().copied());
        let moved = faces_at(t, at.iter().flat_map(|&f| t.faces.vertices_of(f)).copied());
        self.refinement.update(points, &at);
        let slots = self.slots_of(&moved);
        let Self { refinement, faces, tree, .. } = self;
        faces.par_chunks_mut(FACES_PER_TASK).enumerate().for_each(|(number, faces)| {
            let first = FACES_PER_TASK * number;
            let end = first + faces.len();
            let within = slots.partition_point(|&slot| slot < first)..slots.partition_point(|&slot| slot < end);
            for &slot in &slots[within] {
                faces[slot - first] = refinement.face(faces[slot - first].face);
            }
        });
        if let Some(tree) = tree.get_mut() {
            tree.refit(&slots, |slot| faces[slot].crossable());
        }
        moved
    }

    /// Marks faces that may overlap a neighbour within a common plane. The next update of a face removes its mark.
    pub fn mark_overlapping(&mut self, faces: &[FaceId]) {
        for &face in faces {
            let face = &mut self.faces[self.slots[face] as usize];
            (face.is_smooth, face.may_overlap) = (false, true);
        }
    }

    /// The cage.
    pub fn level(&self) -> &'a Level {
        self.refinement.level
    }

    /// The points of the refinement as weighted sums of the cage's.
    pub fn rows(&self) -> &VertexRows<'a> {
        &self.refinement.rows
    }

    /// The points of the refinement.
    pub fn points(&self) -> &IdVec<VertexId, Vec3> {
        &self.refinement.points
    }

    pub(super) fn tree(&self) -> &Bvh {
        self.tree.get_or_init(|| Bvh::new(self.faces.len(), |slot| self.faces[slot].crossable()))
    }

    #[inline]
    pub(super) fn slot(&self, face: FaceId) -> usize {
        self.slots[face] as usize
    }

    /// The slots of some faces, ascending.
    pub(super) fn slots_of(&self, faces: &[FaceId]) -> Vec<usize> {
        let mut slots: Vec<usize> = faces.iter().map(|&face| self.slot(face)).collect();
        slots.sort_unstable();
        slots
    }

    #[inline]
    pub(super) fn face(&self, face: FaceId) -> &RefinedFace {
        &self.faces[self.slot(face)]
    }

    #[inline]
    pub(super) fn vertices<'f>(&'f self, face: &'f RefinedFace) -> &'f [VertexId] {
        // A face stores its first four vertices.
        face.vertices.get(..face.valence).unwrap_or_else(|| self.level().topology.faces.vertices_of(face.face))
    }

    /// The corners of a child: vertex point, edge point, face point, previous edge point.
    pub fn child(&self, (face, number): ChildId) -> [Vec3; 4] {
        self.face(face).child(number)
    }

    /// The vertices of a child in the refinement, in the order of its corners.
    pub fn child_vertices(&self, (face, number): ChildId) -> [VertexId; 4] {
        let (t, numbering) = (&self.level().topology, self.refinement.numbering);
        let range = t.faces.range(face);
        let corner = CornerId::new(range.start + number);
        let previous = CornerId::new(if number == 0 { range.end - 1 } else { corner.index() - 1 });
        let edge_point = |c: CornerId| numbering.of_edge(t.corner_edge[c]);
        [numbering.of_vertex(t.faces.vertex(corner)), edge_point(corner), numbering.of_face(face), edge_point(previous)]
    }

    /// The faces among `faces` with a child whose normal opposes the direction of its face.
    pub fn flipped(&self, faces: &[FaceId], directions: &IdVec<FaceId, Vec3>) -> Vec<FaceId> {
        let is_flipped = |&face: &FaceId| self.is_flipped(face, directions[face], FLIPPED);
        faces.par_iter().with_min_len(FACES_PER_TASK).copied().filter(is_flipped).collect()
    }

    /// Whether the normal of a child has a cosine with `direction` below `least`. No child is flipped where it is zero.
    pub fn is_flipped(&self, face: FaceId, direction: Vec3, least: f32) -> bool {
        direction != Vec3::ZERO && !self.face(face).all_face(direction, least)
    }

    /// Whether a face needs no test where no other layer is near: it is almost flat, near its normal without displacement,
    /// and no sliver.
    pub fn is_smooth(&self, face: FaceId) -> bool {
        self.face(face).is_smooth
    }

    /// Mean normal of a face's children.
    pub fn normal(&self, face: FaceId) -> Vec3 {
        self.face(face).normal
    }
}

/// A point of a refinement.
pub fn evaluate(rows: &impl Stencils<Source = VertexId>, vertex: VertexId, points: &IdVec<VertexId, Vec3>) -> Vec3 {
    let mut point = Vec3::ZERO;
    rows.row(vertex.index(), &mut |v, weight| point += weight * points[v]);
    point
}
