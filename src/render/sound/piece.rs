//! A face of a cage with its children, in one piece of memory.

use super::lanes::{Boxes, Four, Lanes, Ranges, each};
use super::tree::Bounds;
use crate::mesh::{CornerId, FaceId, VertexId};
use crate::subdivide::{Level, Numbering};
use glam::{Vec3, Vec4};

/// Children of a cell.
pub const LANES: usize = 4;

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
    /// Where the skin has the other cells, if there are any.
    pub more: usize,
}

impl Piece {
    /// A face with its children, whose vertices are `at` places, and the cells of those after the first.
    pub fn new(level: &Level, numbering: Numbering, face: FaceId, at: impl Fn(VertexId) -> Vec3) -> (Self, Vec<Cell>) {
        let t = &level.topology;
        let (first, valence) = (t.faces.range(face).start, t.faces.valence(face));
        let centre = at(numbering.of_face(face));
        let corner = |i: usize| CornerId::new(first + i);
        let middle = |i: usize| at(numbering.of_edge(t.corner_edge[corner(i)]));
        let cell = |start: usize| {
            let child = |lane: usize| (start + lane).min(valence - 1);
            let middles: [Vec3; LANES] = std::array::from_fn(|lane| middle(child(lane)));
            let before = |lane: usize| {
                let edge = if child(lane) == 0 { valence - 1 } else { child(lane) - 1 };
                middles.get(edge.wrapping_sub(start)).copied().unwrap_or_else(|| middle(edge))
            };
            let corners = std::array::from_fn(|lane| at(numbering.of_vertex(t.faces.vertex(corner(child(lane))))));
            let befores = std::array::from_fn(before);
            Cell::new(corners, middles, befores, centre, (valence - start).min(LANES))
        };
        let (own, more) = (cell(0), (LANES..valence).step_by(LANES).map(cell).collect::<Vec<_>>());
        let mut vertices = [t.faces.vertex(corner(0)); LANES];
        (1..LANES.min(valence)).for_each(|i| vertices[i] = t.faces.vertex(corner(i)));
        let cells = || std::iter::once(&own).chain(&more);
        let normal = cells().fold(Vec3::ZERO, |sum, cell| sum + cell.area()).normalize_or_zero();
        let piece = Self {
            face,
            valence,
            vertices,
            normal,
            spread: cells().map(|cell| cell.normals.dot(normal).min_element()).fold(1.0, f32::min),
            heights: heights(cells(), normal),
            bounds: cells().map(|cell| cell.boxes().whole()).fold(Bounds::EMPTY, |all, b| all.and(&b)),
            cell: own,
            more: 0,
        };
        (piece, more)
    }
}

impl Cell {
    fn new(corners: [Vec3; 4], middles: [Vec3; 4], befores: [Vec3; 4], centre: Vec3, count: usize) -> Self {
        let [corners, middles, befores] = [corners, middles, befores].map(Four::new);
        let mut cell = Self { corners, middles, befores, normals: Four::default(), centre, count };
        cell.normals = cell.areas().normalize_or_zero();
        cell
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

    /// Twice their areas, as vectors.
    #[inline]
    fn areas(&self) -> Four {
        Four::splat(self.centre).minus(&self.corners).cross(&self.befores.minus(&self.middles))
    }

    /// Twice the area of all, as a vector.
    #[inline]
    fn area(&self) -> Vec3 {
        let areas = self.areas();
        (0..self.count).map(|child| areas.at(child)).sum()
    }
}

/// The range of a face along an axis.
#[inline]
pub fn heights<'a>(mut cells: impl Iterator<Item = &'a Cell>, axis: Vec3) -> (f32, f32) {
    let of = |cell: &Cell| {
        let (a, b, c) = (cell.corners.dot(axis), cell.middles.dot(axis), Vec4::splat(cell.centre.dot(axis)));
        Ranges { low: a.min(b).min(c), high: a.max(b).max(c) }
    };
    let both = |a: Ranges, b: Ranges| Ranges { low: a.low.min(b.low), high: a.high.max(b.high) };
    let first = cells.next().map_or(Ranges { low: Vec4::MAX, high: Vec4::MIN }, of);
    cells.map(of).fold(first, both).whole()
}

/// The points of a face: corners, middles of edges, and the centre.
pub fn samples<'a>(cells: impl Iterator<Item = &'a Cell> + Clone) -> impl Iterator<Item = Vec3> + Clone {
    let centre = cells.clone().next().map(|cell| cell.centre);
    cells.flat_map(|cell| each(cell.all()).flat_map(|i| [cell.corners.at(i), cell.middles.at(i)])).chain(centre)
}
