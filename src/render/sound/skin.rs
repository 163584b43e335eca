//! The first refinement of a cage, face by face, and which faces turn over on it.

use super::marks::Marks;
use super::piece::{Cell, LANES, Piece};
use super::tree::Tree;
use crate::mesh::{FaceId, IdVec, VertexId};
use crate::subdivide::{Cage, Level, Numbering, Stencils, VertexRows};
use glam::{Vec3, Vec4};
use rayon::prelude::*;

/// Cosine between a face's normal and a child's below which it is bent. Larger looks at more faces.
pub const EVEN: f32 = 0.9;
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
    rows: VertexRows<'a>,
    pub(super) numbering: Numbering,
    refined: IdVec<VertexId, Vec3>,
    pub(super) pieces: Vec<Piece>,
    /// Where the piece of each face is.
    places: IdVec<FaceId, u32>,
    /// The cells of faces with many vertices, but for the first of each.
    more: Vec<Cell>,
    pub(super) tree: Option<Tree>,
}

impl<'a> Skin<'a> {
    /// The skin of a cage with the given points. Faces that are near each other are near in memory, where they are in
    /// `order`.
    pub fn new(cage: &'a Cage, points: &IdVec<VertexId, Vec3>, order: &[FaceId]) -> Self {
        let mut skin = Self::with(cage.level(), cage.vertex_rows(), cage.refined_points(points));
        skin.extend(order);
        skin
    }

    /// The skin of a level of which nothing is known yet: only what is learnt may be asked about.
    pub fn bare(level: &'a Level) -> Self {
        let refined = IdVec::filled(Vec3::ZERO, Numbering::new(level).vertices());
        Self::with(level, VertexRows::Masks(level.vertex_stencils()), refined)
    }

    fn with(level: &'a Level, rows: VertexRows<'a>, refined: IdVec<VertexId, Vec3>) -> Self {
        let (numbering, places) = (Numbering::new(level), IdVec::filled(NONE, level.topology.faces.len()));
        Self { level, rows, numbering, refined, pieces: Vec::new(), places, more: Vec::new(), tree: None }
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
        let (level, numbering, refined) = (self.level, self.numbering, &self.refined);
        let of_block = |(number, pieces): (usize, &mut [Piece])| {
            let first = BLOCK * number;
            let within = places.partition_point(|&p| p < first)..places.partition_point(|&p| p < first + pieces.len());
            let renew = |&place: &usize| {
                let known = &mut pieces[place - first];
                let (piece, cells) = Piece::new(level, numbering, known.face, |v| refined[v]);
                *known = Piece { more: known.more, ..piece };
                (known.more, cells)
            };
            places[within].iter().map(renew).filter(|(_, cells)| !cells.is_empty()).collect::<Vec<_>>()
        };
        let large: Vec<(usize, Vec<Cell>)> =
            self.pieces.par_chunks_mut(BLOCK).enumerate().flat_map_iter(of_block).collect();
        for (first, cells) in large {
            self.more[first..first + cells.len()].copy_from_slice(&cells);
        }
        if let Some(tree) = &mut self.tree {
            tree.refit(&places, |place| self.pieces[place].bounds);
        }
    }

    /// Puts the children of some faces where the cage's points are.
    fn refine(&mut self, points: &IdVec<VertexId, Vec3>, faces: &[FaceId]) {
        let mut children = Marks::new(self.refined.len());
        for &face in faces {
            vertices(self.level, self.numbering, face).for_each(|child| children.add(child));
        }
        let refined = |child: &VertexId| {
            let mut place = Vec3::ZERO;
            self.rows.row(child.index(), &mut |v, w| place += w * points[v]);
            place
        };
        let places: Vec<Vec3> = children.list.par_iter().with_min_len(BLOCK).map(refined).collect();
        children.list.iter().zip(places).for_each(|(&child, place)| self.refined[child] = place);
    }

    /// Adds faces whose children are in their places.
    fn extend(&mut self, faces: &[FaceId]) {
        let Self { level, numbering, refined, pieces, places, more, .. } = self;
        let formed = |face: FaceId| Piece::new(level, *numbering, face, |v| refined[v]);
        let first = pieces.len();
        pieces.par_extend(faces.par_iter().with_min_len(BLOCK).map(|&face| formed(face).0));
        let large: Vec<usize> = (first..pieces.len()).filter(|&place| pieces[place].valence > LANES).collect();
        let cells: Vec<Vec<Cell>> = large.par_iter().map(|&place| formed(pieces[place].face).1).collect();
        for (place, cells) in large.into_iter().zip(cells) {
            pieces[place].more = more.len();
            more.extend(cells);
        }
        pieces[first..].iter().zip(first as u32..).for_each(|(piece, place)| places[piece.face] = place);
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

    /// The children of a face.
    #[inline]
    pub(super) fn cells<'p>(&'p self, piece: &'p Piece) -> impl Iterator<Item = &'p Cell> + Clone {
        let others = (piece.valence - 1) / LANES;
        std::iter::once(&piece.cell).chain(if others > 0 { &self.more[piece.more..piece.more + others] } else { &[] })
    }

    /// A cell of a face.
    #[inline]
    pub(super) fn cell<'p>(&'p self, piece: &'p Piece, number: usize) -> &'p Cell {
        if number == 0 { &piece.cell } else { &self.more[piece.more + number - 1] }
    }

    /// The faces that have a child which looks away from `normals`, zero where any may.
    pub fn turned(&self, faces: &[FaceId], normals: &IdVec<FaceId, Vec3>) -> Vec<FaceId> {
        faces.par_iter().with_min_len(BLOCK).copied().filter(|&f| self.is_turned(f, normals[f], TURNED)).collect()
    }

    /// Whether a child of a face looks away from `normal` by a cosine of less than `least`.
    pub fn is_turned(&self, face: FaceId, normal: Vec3, least: f32) -> bool {
        normal != Vec3::ZERO && !self.all_look(self.piece(face), normal, least)
    }

    /// Whether the normals of all children of a face have this cosine or more with an axis.
    #[inline]
    pub(super) fn all_look(&self, piece: &Piece, axis: Vec3, least: f32) -> bool {
        self.cells(piece).all(|cell| cell.normals.dot(axis).cmpge(Vec4::splat(least)).all())
    }

    /// Whether a face's children look to different sides.
    pub fn is_bent(&self, face: FaceId) -> bool {
        self.piece(face).spread < EVEN
    }

    /// Mean normal of a face's children.
    pub fn normal(&self, face: FaceId) -> Vec3 {
        self.piece(face).normal
    }
}

/// The vertices of a face's children.
fn vertices(level: &Level, numbering: Numbering, face: FaceId) -> impl Iterator<Item = VertexId> {
    let t = &level.topology;
    let of = move |c| [numbering.of_vertex(t.faces.vertex(c)), numbering.of_edge(t.corner_edge[c])];
    t.faces.corners_of(face).flat_map(of).chain(std::iter::once(numbering.of_face(face)))
}
