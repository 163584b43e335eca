//! The first refinement of a cage, face by face, and which faces turn over on it.

use super::tree::{Bounds, Tree};
use crate::mesh::{CornerId, FaceId, IdVec, VertexId};
use crate::subdivide::{Cage, Level, Numbering, Stencils, VertexRows};
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;

/// Cosine between a face's normal and a child's below which it is bent. Larger looks at more faces.
const EVEN: f32 = 0.8;
/// A child that looks this far to the other side is turned over, as a cosine. Nearer to 0 takes the overhang of a steep
/// flank for one.
const TURNED: f32 = -0.1;

/// Faces that are measured in one go.
const BLOCK: usize = 512;

/// What the search for crossings needs of a face.
#[derive(Clone, Copy, Default)]
pub(super) struct Patch {
    /// Mean normal.
    pub normal: Vec3,
    /// Least cosine between it and the normal of a child.
    pub spread: f32,
    /// Range along the normal.
    pub heights: (f32, f32),
}

/// A cage's first refinement, stored face by face, so that a pair of faces is two pieces of memory.
pub struct Skin<'a> {
    pub(super) level: &'a Level,
    rows: VertexRows<'a>,
    pub(super) numbering: Numbering,
    refined: IdVec<VertexId, Vec3>,
    /// The children's points: of each face corners and middles of edges by turns, then the centre.
    samples: Vec<Vec3>,
    /// Unit normals of the children, zero without area.
    normals: IdVec<CornerId, Vec3>,
    pub(super) boxes: IdVec<FaceId, Bounds>,
    pub(super) patches: IdVec<FaceId, Patch>,
    pub(super) tree: Option<Tree>,
}

impl<'a> Skin<'a> {
    /// The skin of a cage with the given points.
    pub fn new(cage: &'a Cage, points: &IdVec<VertexId, Vec3>) -> Self {
        let mut skin = Self::empty(cage.level(), cage.vertex_rows(), cage.refined_points(points));
        skin.measure(|_| true);
        skin
    }

    /// The skin of a level of which nothing is known yet: only what is updated may be asked about.
    pub fn bare(level: &'a Level) -> Self {
        let refined = IdVec::filled(Vec3::ZERO, Numbering::new(level).vertices());
        Self::empty(level, VertexRows::Masks(level.vertex_stencils()), refined)
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

    /// Takes the children of the faces that are asked for to where the refined points are now.
    fn measure(&mut self, is_asked: impl Fn(FaceId) -> bool + Sync) {
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
                if !is_asked(face) {
                    continue;
                }
                let children = vertices(level, numbering, face).map(|v| refined[v]);
                (*bounds, *patch) = measured(children, its_samples, its_normals);
            }
        });
    }

    /// Moves the children of the faces that are asked for to where the cage's points put them now.
    pub fn update(&mut self, points: &IdVec<VertexId, Vec3>, is_asked: &IdVec<FaceId, bool>) {
        let (level, numbering, rows) = (self.level, self.numbering, &self.rows);
        let mut is_moved = IdVec::filled(false, self.refined.len());
        for face in is_asked.ids().filter(|&face| is_asked[face]) {
            vertices(level, numbering, face).for_each(|child| is_moved[child] = true);
        }
        self.refined.as_mut_slice().par_iter_mut().enumerate().with_min_len(BLOCK).for_each(|(child, place)| {
            if is_moved[VertexId::new(child)] {
                *place = Vec3::ZERO;
                rows.row(child, &mut |v, w| *place += w * points[v]);
            }
        });
        self.measure(|face| is_asked[face]);
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
    pub(super) fn normals(&self, face: FaceId) -> &[Vec3] {
        &self.normals.as_slice()[self.level.topology.faces.range(face)]
    }

    /// Active faces that have a child which looks away from `normals`, zero where any may.
    pub fn turned(&self, is_active: &IdVec<FaceId, bool>, normals: &IdVec<FaceId, Vec3>) -> Vec<FaceId> {
        let faces = (0..is_active.len()).into_par_iter().map(FaceId::new);
        faces.filter(|&face| is_active[face] && self.is_turned(face, normals[face], TURNED)).collect()
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
fn measured(children: impl Iterator<Item = Vec3>, samples: &mut [Vec3], normals: &mut [Vec3]) -> (Bounds, Patch) {
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
