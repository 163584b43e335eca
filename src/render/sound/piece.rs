//! A face of a cage with its children, in one piece of memory.

use super::lanes::{Boxes, Four, Lanes, Ranges, each};
use super::tree::Bounds;
use crate::mesh::{FaceId, IdVec, VertexId};
use crate::subdivide::{Level, Numbering};
use glam::{Vec3, Vec4};

/// Children of a cell.
pub const LANES: usize = 4;

/// Cosine between a face's normal and a child's below which it is bent. Larger looks at more faces.
pub const EVEN: f32 = 0.9;
/// Cosine between the normals of a face with and without its moves below which it is looked at.
const ONE_WAY: f32 = 0.5;
/// Cosine of a corner's angle above which a triangle is narrow: it may pass a neighbour in the plane of both.
const NARROW: f32 = 0.9;

/// Four children of a face, in lanes: all that a quad has. Lanes without a child repeat the last one.
#[derive(Clone, Copy)]
pub struct Cell {
    /// The corners of the face.
    pub corners: Four,
    /// The middles of the edges after them.
    pub middles: Four,
    /// The centre of the face.
    pub centre: Vec3,
    /// The number of children.
    pub count: usize,
    /// The middles of the edges before them.
    pub befores: Four,
    /// Unit normals, zero without area.
    pub normals: Four,
}

/// A face with its children.
#[derive(Clone, Copy)]
pub struct Piece {
    /// The face.
    pub face: FaceId,
    /// Its number of vertices.
    pub valence: usize,
    /// The first of them; all of a quad's.
    pub vertices: [VertexId; LANES],
    /// Mean normal.
    pub normal: Vec3,
    /// Least cosine between it and the normal of a child.
    pub spread: f32,
    /// Range along the normal.
    pub heights: (f32, f32),
    /// The box of the children.
    pub bounds: Bounds,
    /// The first children.
    pub cell: Cell,
    /// Whether it is sound where no other layer is near.
    pub is_even: bool,
    /// Whether it may pass a neighbour in the plane of both, as narrow triangles do.
    pub is_loose: bool,
    /// Where the skin has the other cells, if there are any.
    pub more: usize,
}

/// What pieces are made of.
pub struct Former<'a> {
    pub level: &'a Level,
    pub numbering: Numbering,
    /// The points of the first refinement.
    pub refined: &'a IdVec<VertexId, Vec3>,
    /// Where the faces look without their moves, if that is known.
    pub looks: Option<&'a IdVec<FaceId, Vec3>>,
}

impl Former<'_> {
    /// The cells of a face after the first.
    pub fn others(&self, face: FaceId) -> Vec<Cell> {
        let valence = self.level.topology.faces.valence(face);
        (LANES..valence).step_by(LANES).map(|first| self.cell(face, first).0).collect()
    }

    /// A face whose cells after the first are in `all`, from `more` on.
    pub fn piece(&self, face: FaceId, more: usize, all: &[Cell]) -> Piece {
        let of_face = self.level.topology.faces.vertices_of(face);
        let others = &all[more..more + others(of_face.len())];
        let (cell, area) = self.cell(face, 0);
        let cells = || std::iter::once(&cell).chain(others);
        let normal = others.iter().fold(area, |sum, cell| sum + cell.area()).normalize_or_zero();
        let spread = cells().map(|cell| cell.normals.dot(normal).min_element()).fold(1.0, f32::min);
        let looks_right = self.looks.is_some_and(|looks| normal.dot(looks[face]) >= ONE_WAY);
        let is_narrow = of_face.len() == 3 && cell.is_narrow();
        Piece {
            face,
            valence: of_face.len(),
            vertices: std::array::from_fn(|i| of_face[if i < of_face.len() { i } else { 0 }]),
            normal,
            spread,
            heights: heights(&cell, others, normal),
            bounds: cells().map(|cell| cell.boxes().whole()).fold(Bounds::EMPTY, |all, b| all.and(&b)),
            is_even: looks_right && spread >= EVEN && !is_narrow,
            is_loose: is_narrow,
            cell,
            more,
        }
    }

    /// The children of a face from the one with this number on, and twice their area as a vector.
    fn cell(&self, face: FaceId, first: usize) -> (Cell, Vec3) {
        let t = &self.level.topology;
        let (vertices, range) = (t.faces.vertices_of(face), t.faces.range(face));
        let edges = &t.corner_edge.as_slice()[range];
        let (last, count) = (vertices.len() - 1, (vertices.len() - first).min(LANES));
        let child: [usize; LANES] = std::array::from_fn(|lane| (first + lane).min(last));
        let corner = |i: usize| self.refined[self.numbering.of_vertex(vertices[i])];
        let middle = |i: usize| self.refined[self.numbering.of_edge(edges[i])];
        let middles = child.map(middle);
        let before = |lane: usize| {
            let edge = if child[lane] == 0 { last } else { child[lane] - 1 };
            middles.get(edge.wrapping_sub(first)).copied().unwrap_or_else(|| middle(edge))
        };
        let centre = self.refined[self.numbering.of_face(face)];
        let around = Four::new(middles);
        let befores = if last + 1 == LANES { around.rolled() } else { Four::new(std::array::from_fn(before)) };
        Cell::new(Four::new(child.map(corner)), around, befores, centre, count)
    }
}

impl Cell {
    /// The cell, and twice its area as a vector.
    #[inline]
    fn new(corners: Four, middles: Four, befores: Four, centre: Vec3, count: usize) -> (Self, Vec3) {
        let mut cell = Self { corners, middles, befores, normals: Four::default(), centre, count };
        let areas = cell.areas();
        cell.normals = areas.normalize_or_zero();
        (cell, cell.sum(&areas))
    }

    /// Whether the triangle that this is all of is narrow.
    fn is_narrow(&self) -> bool {
        let [a, b, c] = [0, 1, 2].map(|i| self.corners.at(i));
        let [ab, bc, ca] = [b - a, c - b, a - c].map(Vec3::normalize_or_zero);
        (-ca.dot(ab)).max(-ab.dot(bc)).max(-bc.dot(ca)) > NARROW
    }

    /// The lanes that have a child.
    #[inline]
    pub fn all(&self) -> Lanes {
        (1 << self.count) - 1
    }

    /// A child: the corner, the middle of its edge, the centre, the middle before.
    #[inline]
    pub fn quad(&self, child: usize) -> [Vec3; 4] {
        [self.corners.at(child), self.middles.at(child), self.centre, self.befores.at(child)]
    }

    /// The points in a frame; the normals are as they are.
    #[inline]
    pub fn within(&self, axes: &[Vec3; 3]) -> Self {
        let [corners, middles, befores] =
            [&self.corners, &self.middles, &self.befores].map(|points| points.within(axes));
        Self { corners, middles, befores, centre: Vec3::from(axes.map(|axis| axis.dot(self.centre))), ..*self }
    }

    /// The boxes of the children.
    #[inline]
    pub fn boxes(&self) -> Boxes {
        Boxes::of([&self.corners, &self.middles, &self.befores, &Four::splat(self.centre)])
    }

    /// The ranges of the children along an axis, together.
    #[inline]
    pub fn ranges(&self, axis: Vec3) -> Ranges {
        let (a, b, c) = (self.corners.dot(axis), self.middles.dot(axis), Vec4::splat(self.centre.dot(axis)));
        Ranges { low: a.min(b).min(c), high: a.max(b).max(c) }
    }

    /// Twice their areas, as vectors.
    #[inline]
    fn areas(&self) -> Four {
        Four::splat(self.centre).minus(&self.corners).cross(&self.befores.minus(&self.middles))
    }

    /// Twice the area of all, as a vector.
    #[inline]
    fn area(&self) -> Vec3 {
        self.sum(&self.areas())
    }

    /// The sum of what belongs to each child.
    #[inline]
    fn sum(&self, of_children: &Four) -> Vec3 {
        (0..self.count).map(|child| of_children.at(child)).sum()
    }
}

/// The number of cells after the first of a face with so many vertices.
#[inline]
pub fn others(valence: usize) -> usize {
    (valence - 1) / LANES
}

/// The range of a face along an axis, which has a first cell and maybe others.
#[inline]
pub fn heights(first: &Cell, others: &[Cell], axis: Vec3) -> (f32, f32) {
    let both = |a: Ranges, b: Ranges| Ranges { low: a.low.min(b.low), high: a.high.max(b.high) };
    others.iter().map(|cell| cell.ranges(axis)).fold(first.ranges(axis), both).whole()
}

/// The points of a face: corners, middles of edges, and the centre.
pub fn samples<'a>(cells: impl Iterator<Item = &'a Cell> + Clone) -> impl Iterator<Item = Vec3> + Clone {
    let centre = cells.clone().next().map(|cell| cell.centre);
    cells.flat_map(|cell| each(cell.all()).flat_map(|i| [cell.corners.at(i), cell.middles.at(i)])).chain(centre)
}
