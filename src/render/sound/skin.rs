//! The first refinement of a cage, face by face, and which faces turn over on it.

use super::marks::Marks;
use super::piece::{Cell, Former, LANES, Piece, heights, others};
use super::tree::Tree;
use crate::mesh::{FaceId, IdVec, VertexId};
use crate::subdivide::{Connectivity, Level, Numbering, Stencils, VertexRows, carried_points};
use glam::{Vec3, Vec4};
use rayon::prelude::*;

/// A child that looks this far to the other side is turned over, as a cosine. Nearer to 0 takes the overhang of a steep
/// flank for one.
const TURNED: f32 = -0.1;
/// The place of a face that is not known.
const NONE: u32 = u32::MAX;
/// Faces that are measured in one go.
const BLOCK: usize = 64;

/// A cage's first refinement.
pub struct Skin<'a> {
    pub(super) level: &'a Level,
    pub(super) rows: VertexRows<'a>,
    pub(super) numbering: Numbering,
    refined: IdVec<VertexId, Vec3>,
    pub(super) pieces: Vec<Piece>,
    /// Where the piece of each face is.
    places: IdVec<FaceId, u32>,
    /// Where the faces look without their moves, zero where any way is right. None where nothing is known of it.
    looks: Option<IdVec<FaceId, Vec3>>,
    /// The cells of faces with many vertices, but for the first of each.
    more: Vec<Cell>,
    pub(super) tree: Option<Tree>,
}

impl<'a> Skin<'a> {
    /// The skin of a level with the given points. Faces that are near each other are near in memory, where they are in
    /// `order`. They look along `looks` without their moves, zero where any way is right, if that is known.
    pub fn new(
        level: &'a Level,
        points: &IdVec<VertexId, Vec3>,
        order: &[FaceId],
        looks: Option<IdVec<FaceId, Vec3>>,
    ) -> Self {
        Self::by_rows(level, level.vertex_rows(), points, order, looks)
    }

    /// The same, by masks that are kept.
    pub fn of(
        connectivity: &'a Connectivity,
        points: &IdVec<VertexId, Vec3>,
        order: &[FaceId],
        looks: Option<IdVec<FaceId, Vec3>>,
    ) -> Self {
        Self::by_rows(connectivity.level(), connectivity.vertex_rows(), points, order, looks)
    }

    fn by_rows(
        level: &'a Level,
        rows: VertexRows<'a>,
        points: &IdVec<VertexId, Vec3>,
        order: &[FaceId],
        looks: Option<IdVec<FaceId, Vec3>>,
    ) -> Self {
        let refined = carried_points(&rows, points);
        let mut skin = Self::with(level, rows, refined, looks);
        skin.extend(order);
        skin
    }

    /// The skin of a level of which nothing is known yet: only what is learnt may be asked about.
    pub fn bare(level: &'a Level) -> Self {
        let refined = IdVec::filled(Vec3::ZERO, Numbering::new(level).vertices());
        Self::with(level, level.vertex_rows(), refined, None)
    }

    fn with(
        level: &'a Level,
        rows: VertexRows<'a>,
        refined: IdVec<VertexId, Vec3>,
        looks: Option<IdVec<FaceId, Vec3>>,
    ) -> Self {
        let (numbering, places) = (Numbering::new(level), IdVec::filled(NONE, level.topology.faces.len()));
        Self { level, rows, numbering, refined, pieces: Vec::new(), places, looks, more: Vec::new(), tree: None }
    }

    /// Adds faces whose children are where the cage's points put them.
    pub fn learn(&mut self, points: &IdVec<VertexId, Vec3>, faces: &[FaceId]) {
        self.refine(points, faces);
        self.extend(faces);
    }

    /// Takes the children to where the cage's points put them now. `at` are the faces with a point that has moved: all that
    /// move are children of these. `touching` has them and the faces that share some of those children.
    pub fn update(&mut self, points: &IdVec<VertexId, Vec3>, at: &[FaceId], touching: &[FaceId]) {
        self.refine(points, at);
        let mut places: Vec<usize> = touching.iter().map(|&face| self.place(face)).collect();
        places.sort_unstable();
        let Self { level, numbering, refined, looks, pieces, more, .. } = self;
        let former = Former { level, numbering: *numbering, refined, looks: looks.as_ref() };
        let large: Vec<&Piece> = places.iter().map(|&place| &pieces[place]).filter(|p| p.valence > LANES).collect();
        let cells: Vec<Vec<Cell>> = large.par_iter().map(|piece| former.others(piece.face)).collect();
        for (piece, cells) in large.into_iter().zip(cells) {
            more[piece.more..piece.more + cells.len()].copy_from_slice(&cells);
        }
        pieces.par_chunks_mut(BLOCK).enumerate().for_each(|(number, pieces)| {
            let first = BLOCK * number;
            let within = places.partition_point(|&p| p < first)..places.partition_point(|&p| p < first + pieces.len());
            for &place in &places[within] {
                let known = &mut pieces[place - first];
                *known = former.piece(known.face, known.more, more);
            }
        });
        if let Some(tree) = &mut self.tree {
            tree.refit(&places, |place| self.pieces[place].bounds);
        }
    }

    /// Takes some faces for such as may pass a neighbour in the plane of both, until they are updated.
    pub fn loosen(&mut self, faces: &[FaceId]) {
        for &face in faces {
            let piece = &mut self.pieces[self.places[face] as usize];
            (piece.is_even, piece.is_loose) = (false, true);
        }
    }

    /// Puts the children of some faces where the cage's points are.
    fn refine(&mut self, points: &IdVec<VertexId, Vec3>, faces: &[FaceId]) {
        let mut children = Marks::new(self.refined.len());
        for &face in faces {
            children_of(self.level, self.numbering, face).for_each(|child| children.add(child));
        }
        let refined = |&child: &VertexId| place(&self.rows, child, points);
        let places: Vec<Vec3> = children.list.par_iter().with_min_len(BLOCK).map(refined).collect();
        children.list.iter().zip(places).for_each(|(&child, place)| self.refined[child] = place);
    }

    /// Adds faces whose children are in their places.
    fn extend(&mut self, faces: &[FaceId]) {
        let Self { level, numbering, refined, pieces, places, looks, more, .. } = self;
        let former = Former { level, numbering: *numbering, refined, looks: looks.as_ref() };
        let start = |rest: &mut usize, &face: &FaceId| {
            let start = *rest;
            *rest += others(level.topology.faces.valence(face));
            Some(start)
        };
        let starts: Vec<usize> = faces.iter().scan(more.len(), start).collect();
        more.par_extend(faces.par_iter().with_min_len(BLOCK).flat_map_iter(|&face| former.others(face)));
        let piece = |(&face, &start): (&FaceId, &usize)| former.piece(face, start, more);
        faces.iter().zip(pieces.len() as u32..).for_each(|(&face, place)| places[face] = place);
        pieces.par_extend(faces.par_iter().zip(&starts).with_min_len(BLOCK).map(piece));
    }

    /// Whether something is known of a face.
    pub fn knows(&self, face: FaceId) -> bool {
        self.places[face] != NONE
    }

    /// Where the piece of a face is.
    #[inline]
    pub(super) fn place(&self, face: FaceId) -> usize {
        self.places[face] as usize
    }

    #[inline]
    fn piece(&self, face: FaceId) -> &Piece {
        &self.pieces[self.place(face)]
    }

    /// The vertices of a face.
    #[inline]
    pub(super) fn vertices<'p>(&'p self, piece: &'p Piece) -> &'p [VertexId] {
        // Those of most are at hand.
        if piece.valence > LANES {
            return self.level.topology.faces.vertices_of(piece.face);
        }
        &piece.vertices[..piece.valence]
    }

    /// The range of a face along an axis.
    #[inline]
    pub(super) fn heights(&self, piece: &Piece, axis: Vec3) -> (f32, f32) {
        heights(&piece.cell, self.others(piece), axis)
    }

    /// The cells of a face after the first, which most have not.
    #[inline]
    fn others(&self, piece: &Piece) -> &[Cell] {
        if piece.valence > LANES { &self.more[piece.more..piece.more + others(piece.valence)] } else { &[] }
    }

    /// The children of a face.
    #[inline]
    pub(super) fn cells<'p>(&'p self, piece: &'p Piece) -> impl Iterator<Item = &'p Cell> + Clone {
        std::iter::once(&piece.cell).chain(self.others(piece))
    }

    /// A cell of a face.
    #[inline]
    pub(super) fn cell<'p>(&'p self, piece: &'p Piece, number: usize) -> &'p Cell {
        if number == 0 { &piece.cell } else { &self.more[piece.more + number - 1] }
    }

    /// Where a vertex of the refinement is.
    pub fn child_point(&self, vertex: VertexId) -> Vec3 {
        self.refined[vertex]
    }

    /// The faces that have a child which looks away from where they look without their moves.
    pub fn turned(&self, faces: &[FaceId]) -> Vec<FaceId> {
        self.looks.as_ref().map_or_else(Vec::new, |looks| self.turned_from(looks, faces))
    }

    /// The faces that have a child which looks away from the direction of the face.
    pub fn turned_from(&self, directions: &IdVec<FaceId, Vec3>, faces: &[FaceId]) -> Vec<FaceId> {
        faces.par_iter().with_min_len(BLOCK).copied().filter(|&f| self.is_turned(f, directions[f], TURNED)).collect()
    }

    /// Where a face looks without its moves, zero where any way is right or nothing is known of it.
    pub fn look(&self, face: FaceId) -> Vec3 {
        self.looks.as_ref().map_or(Vec3::ZERO, |looks| looks[face])
    }

    /// Whether a child of a face looks away from `normal` by a cosine of less than `least`.
    pub fn is_turned(&self, face: FaceId, normal: Vec3, least: f32) -> bool {
        normal != Vec3::ZERO && !self.all_look(self.piece(face), normal, least)
    }

    /// Whether the normals of all children of a face have this cosine or more with an axis.
    #[inline]
    pub(super) fn all_look(&self, piece: &Piece, axis: Vec3, least: f32) -> bool {
        let all = |cell: &Cell| cell.normals.dot(axis).cmpge(Vec4::splat(least)).all();
        all(&piece.cell) && self.others(piece).iter().all(all)
    }

    /// Whether a face is sound where no other layer is near.
    pub fn is_even(&self, face: FaceId) -> bool {
        self.piece(face).is_even
    }

    /// Mean normal of a face's children.
    pub fn normal(&self, face: FaceId) -> Vec3 {
        self.piece(face).normal
    }
}

/// Where a vertex is that is made of some points.
pub fn place(rows: &impl Stencils<Source = VertexId>, vertex: VertexId, points: &IdVec<VertexId, Vec3>) -> Vec3 {
    let mut place = Vec3::ZERO;
    rows.row(vertex.index(), &mut |v, w| place += w * points[v]);
    place
}

/// The vertices of a face's children.
fn children_of(level: &Level, numbering: Numbering, face: FaceId) -> impl Iterator<Item = VertexId> {
    let t = &level.topology;
    let of = move |c| [numbering.of_vertex(t.faces.vertex(c)), numbering.of_edge(t.corner_edge[c])];
    t.faces.corners_of(face).flat_map(of).chain(std::iter::once(numbering.of_face(face)))
}
