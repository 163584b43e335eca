//! Which faces of a skin cross.
//!
//! Reference: Volino and Magnenat Thalmann 1994 (a patch all of whose normals are on one side of a plane does not cross
//! itself): faces that touch are looked at closely only where that fails.

use super::close::ChildOf;
use super::lanes::{Boxes, Four, Lanes, Ranges, each};
use super::piece::{Cell, EVEN, LANES, Piece};
use super::skin::Skin;
use super::tree::{Bounds, Tree};
use crate::mesh::{CornerId, FaceId, VertexId};
use glam::{DVec3, Vec3, Vec4};

/// All lanes.
const ALL: Lanes = (1 << LANES) - 1;
/// Cosine of the angle to the plane below which normals count as on its other side. Larger looks at more faces closely.
const ONE_SIDED: f32 = 0.1;
/// Cosine between the normals of two faces below which they may cross at a vertex, whatever lies between them there.
/// Larger looks at more of them closely.
pub const ACROSS: f32 = 0.5;

/// A cell of a face, of which some children are near another face.
struct Part<'a> {
    face: FaceId,
    /// The number of its first child.
    first: usize,
    cell: &'a Cell,
    boxes: Boxes,
    near: Lanes,
}

impl<'a> Part<'a> {
    /// Of the cell of a face that has this number, what is in a box.
    fn new(face: FaceId, number: usize, cell: &'a Cell, bounds: &Bounds) -> Self {
        let boxes = cell.boxes();
        Self { face, first: LANES * number, cell, boxes, near: boxes.that_meet(&Boxes::splat(bounds)) & cell.all() }
    }

    fn child(&self, lane: usize) -> Child {
        Child { face: self.face, number: self.first + lane, quad: self.cell.quad(lane) }
    }
}

/// A child of a face.
struct Child {
    face: FaceId,
    /// Its number in the face.
    number: usize,
    quad: [Vec3; 4],
}

impl Skin<'_> {
    /// Pairs of faces that cross, or a face twice that crosses itself, with at least one that is active.
    pub fn crossings(&mut self, active: &[FaceId]) -> Vec<[FaceId; 2]> {
        let pieces = &self.pieces;
        self.tree.get_or_insert_with(|| Tree::new(pieces.len(), |place| pieces[place].bounds));
        let Some(tree) = &self.tree else { return Vec::new() };
        let active: Vec<usize> = active.iter().map(|&face| self.place(face)).collect();
        let pairs = tree.pairs(&active, |a, b| self.pieces_cross(&self.pieces[a], &self.pieces[b]));
        pairs.into_iter().map(|pair| pair.map(|place| self.pieces[place].face)).collect()
    }

    /// Whether the children of two faces cross, or of one.
    pub fn cross(&self, f: FaceId, g: FaceId) -> bool {
        self.pieces_cross(&self.pieces[self.place(f)], &self.pieces[self.place(g)])
    }

    fn pieces_cross(&self, a: &Piece, b: &Piece) -> bool {
        // The same whatever their order in memory is.
        let (f, g) = if a.face <= b.face { (a, b) } else { (b, a) };
        if f.face == g.face {
            return self.may_cross_itself(f) && self.children_cross(f, g);
        }
        if self.touch(f, g) {
            return !are_even(f, g) && !self.are_sound_beside(f, g) && self.children_cross(f, g);
        }
        !self.is_apart(f, g, &Way::NONE)
            && !self.is_apart(g, f, &Way::NONE)
            && !self.are_beside(f, g)
            && self.children_cross(f, g)
    }

    /// Whether the children of a face look to so many sides that they may cross each other.
    #[inline]
    pub(super) fn may_cross_itself(&self, f: &Piece) -> bool {
        f.spread < ONE_SIDED
    }

    /// Whether faces that touch cannot cross, as they look to one side, or as something parts them.
    #[inline]
    pub(super) fn are_sound_beside(&self, f: &Piece, g: &Piece) -> bool {
        if self.are_one_sided(f, g) || self.are_beside(f, g) {
            return true;
        }
        let axis = between(f, g);
        self.are_parted(f, g, axis) || self.are_parted(g, f, axis)
    }

    /// Whether two faces have a vertex in common.
    #[inline]
    pub(super) fn touch(&self, f: &Piece, g: &Piece) -> bool {
        if f.valence <= LANES && g.valence <= LANES {
            // All at once is faster than to stop at the first.
            return f.vertices.iter().fold(false, |any, v| g.vertices.iter().fold(any, |any, w| any | (v == w)));
        }
        let [a, b] = [f, g].map(|piece| self.vertices(piece));
        a.iter().any(|v| b.contains(v))
    }

    /// Whether faces that touch cannot cross, as they look to one side. Of the narrow triangles where a seam ends, one may
    /// pass another all the same, and so may two faces at a vertex across a fold.
    #[inline]
    fn are_one_sided(&self, f: &Piece, g: &Piece) -> bool {
        if f.is_loose || g.is_loose || f.normal.dot(g.normal) < ACROSS {
            return false;
        }
        let all_look = |axis| [f, g].iter().all(|piece| self.all_look(piece, axis, ONE_SIDED));
        f.spread.min(g.spread) > EVEN || all_look(between(f, g))
    }

    /// Whether a plane along `axis`, through an edge of `f` at what it has in common with `g`, parts the two.
    fn are_parted(&self, f: &Piece, g: &Piece, axis: Vec3) -> bool {
        let [of_f, of_g] = [f, g].map(|piece| self.vertices(piece));
        let corner = |i: usize| self.cell(f, i / LANES).corners.at(i % LANES);
        let is_common = |i: usize| of_g.contains(&of_f[i]);
        let mut is_next_common = is_common(0);
        (0..f.valence).any(|i| {
            let next = if i + 1 == f.valence { 0 } else { i + 1 };
            let are_common = [is_next_common, is_common(next)];
            is_next_common = are_common[1];
            if are_common == [false; 2] {
                return false;
            }
            let (from, to) = (corner(i), corner(next));
            let plane = Plane { from, normal: axis.cross(to - from) };
            if plane.height(g.cell.centre) >= 0.0 || plane.height(f.cell.centre) < 0.0 {
                return false;
            }
            // The middle of an edge that both have is beside the plane; what is nearer than it may cross.
            let middle = (are_common == [true; 2]).then(|| self.cell(f, i / LANES).middles.at(i % LANES));
            let least = middle.map_or(0.0, |middle| plane.height(middle).abs());
            let ends = [from, to, middle.unwrap_or(from)];
            plane.all(self.cells(g), ends, |heights| heights.cmplt(Vec4::splat(-least)).bitmask())
                && plane.all(self.cells(f), ends, |heights| heights.cmpge(Vec4::splat(least)).bitmask())
        })
    }

    /// Whether a plane across the normal of `f` parts two faces, of which `f` goes a way.
    #[inline]
    pub(super) fn is_apart(&self, f: &Piece, g: &Piece, way: &Way) -> bool {
        let ((a, b), (c, d)) = (f.heights, self.heights(g, f.normal));
        let by = way.by.dot(f.normal);
        b + by.max(0.0) + way.least < c || d + way.least < a + by.min(0.0)
    }

    /// Whether a plane across the line between their centres parts two faces, which have no more in common than what is
    /// in it.
    #[inline]
    pub(super) fn are_beside(&self, f: &Piece, g: &Piece) -> bool {
        let axis = g.cell.centre - f.cell.centre;
        let ((low, end), (start, high)) = (self.heights(f, axis), self.heights(g, axis));
        // Not where the centres are in one place, and all heights are the same.
        low < high && end <= start
    }

    /// The children of two faces that cross.
    pub fn crossing_children(&self, f: FaceId, g: FaceId) -> Vec<[ChildOf; 2]> {
        let child = |&(face, number): &ChildOf| Child { face, number, quad: self.child_quad((face, number)) };
        let faces = &self.level.topology.faces;
        let of_g = |own: ChildOf| (0..faces.valence(g)).map(move |other| [own, (g, other)]);
        let pairs = (0..faces.valence(f)).flat_map(|own| of_g((f, own))).filter(|[a, b]| f != g || a < b);
        pairs.filter(|[a, b]| self.triangles_cross(&child(a), &child(b))).collect()
    }

    /// A child of a face: the corner, the middle of its edge, the centre, the middle before.
    pub fn child_quad(&self, (face, number): ChildOf) -> [Vec3; 4] {
        let piece = &self.pieces[self.place(face)];
        self.cell(piece, number / LANES).quad(number % LANES)
    }

    fn children_cross(&self, f: &Piece, g: &Piece) -> bool {
        let common = f.bounds.common(&g.bounds);
        let parts = |piece| {
            let cells = self.cells(piece).enumerate();
            cells.map(move |(number, cell)| Part::new(piece.face, number, cell, &common)).filter(|part| part.near != 0)
        };
        parts(f).any(|a| parts(g).any(|b| self.parts_cross(&a, &b)))
    }

    fn parts_cross(&self, a: &Part, b: &Part) -> bool {
        each(a.near).any(|lane| {
            let own = a.child(lane);
            let mut near = b.near & b.boxes.that_meet(&Boxes::splat(&a.boxes.at(lane)));
            if a.face == b.face {
                // A child's own two triangles have an edge in common.
                near &= after(own.number, b.first);
            }
            if near != 0 {
                near &= meeting(&own.quad, a.cell.normals.at(lane), b.cell, &Way::NONE);
            }
            each(near).any(|lane| self.triangles_cross(&own, &b.child(lane)))
        })
    }

    /// Whether the triangles of two children cross.
    fn triangles_cross(&self, a: &Child, b: &Child) -> bool {
        let (of_a, of_b) = (self.cuts(a), self.cuts(b));
        // Triangles that have a vertex in common do not count.
        let joined = self.joined((a, &of_a), (b, &of_b));
        if joined == [[true; 2]; 2] {
            return false;
        }
        let (p, q) = (a.quad.map(|p| p.as_dvec3()), b.quad.map(|p| p.as_dvec3()));
        let cross = |x: usize, y: usize| pierce(&of_a[x].map(|k| p[k]), &of_b[y].map(|k| q[k]));
        (0..2).any(|x| (0..2).any(|y| !joined[x][y] && cross(x, y)))
    }

    /// Which triangles of two children have a vertex in common.
    fn joined(&self, (a, of_a): (&Child, &[[usize; 3]; 2]), (b, of_b): (&Child, &[[usize; 3]; 2])) -> [[bool; 2]; 2] {
        let (in_a, in_b) = (self.child_vertices((a.face, a.number)), self.child_vertices((b.face, b.number)));
        of_a.map(|x| of_b.map(|y| x.iter().any(|&k| y.iter().any(|&l| in_a[k] == in_b[l]))))
    }

    /// The two triangles of a child, by places in its quad, cut as the refined mesh has it.
    fn cuts(&self, child: &Child) -> [[usize; 3]; 2] {
        let is_odd = self.level.topology.faces.valence(child.face) == 4 && child.number % 2 == 1;
        if is_odd { [[1, 2, 3], [1, 3, 0]] } else { [[0, 1, 2], [0, 2, 3]] }
    }

    /// The vertices of a face's child, in the order of its quad.
    pub fn child_vertices(&self, (face, number): ChildOf) -> [VertexId; 4] {
        let t = &self.level.topology;
        let corners = t.faces.range(face);
        let corner = CornerId::new(corners.start + number);
        let prev = CornerId::new(if number == 0 { corners.end - 1 } else { corner.index() - 1 });
        let middle = |c: CornerId| self.numbering.of_edge(t.corner_edge[c]);
        let own = self.numbering.of_vertex(t.faces.vertex(corner));
        [own, middle(corner), self.numbering.of_face(face), middle(prev)]
    }
}

/// Whether faces that touch are sound by how they are made.
#[inline]
fn are_even(f: &Piece, g: &Piece) -> bool {
    f.is_even && g.is_even && f.normal.dot(g.normal) >= ACROSS
}

/// The direction between those in which two faces look.
#[inline]
fn between(f: &Piece, g: &Piece) -> Vec3 {
    (f.normal + g.normal).normalize_or_zero()
}

/// A plane that may part two faces.
struct Plane {
    from: Vec3,
    normal: Vec3,
}

impl Plane {
    fn height(&self, point: Vec3) -> f32 {
        (point - self.from).dot(self.normal)
    }

    /// Whether all points of a face but `ends` have heights that `are_right`.
    fn all<'c>(
        &self,
        mut cells: impl Iterator<Item = &'c Cell>,
        ends: [Vec3; 3],
        are_right: impl Fn(Vec4) -> Lanes,
    ) -> bool {
        let from = Four::splat(self.from);
        let fit = |points: &Four| {
            let others = ALL & !are_right(points.minus(&from).dot(self.normal));
            others == 0 || others & !ends.iter().fold(0, |all, &end| all | points.that_are(end)) == 0
        };
        cells.all(|cell| fit(&Four::splat(cell.centre)) && fit(&cell.corners) && fit(&cell.middles))
    }
}

/// How one face may move, seen from another.
pub struct Way {
    pub by: Vec3,
    /// How far it may be beside that.
    pub least: f32,
}

impl Way {
    /// That of what does not move.
    pub const NONE: Self = Self { by: Vec3::ZERO, least: 0.0 };

    /// How the other one may move, seen from this one.
    pub fn back(&self) -> Self {
        Self { by: -self.by, ..*self }
    }
}

/// The lanes of `b` with a child that no axis, of a few that may, parts from a quad that has this normal and goes this way.
#[inline]
pub fn meeting(quad: &[Vec3; 4], normal: Vec3, b: &Cell, way: &Way) -> Lanes {
    let own = quad.map(Four::splat);
    let (centres, by) = (Four::splat(b.centre), Four::splat(way.by));
    let along = |axes: &Four, least: f32| {
        let of_b = [&b.corners, &b.middles, &b.befores, &centres].map(|points| points.dots(axes));
        Ranges::of(own.map(|point| point.dots(axes))).swept(by.dots(axes)).grown(least).that_meet(&Ranges::of(of_b))
    };
    let middles = b.corners.plus(&centres).minus(&own[0]).minus(&own[2]);
    along(&Four::splat(normal), way.least) & along(&b.normals, way.least) & along(&middles, 0.0)
}

/// The lanes of a cell whose children have a larger number than `number`, where the first has the number `first`.
fn after(number: usize, first: usize) -> Lanes {
    let passed = (number + 1).saturating_sub(first).min(LANES);
    ALL & !((1 << passed) - 1)
}

/// Whether triangles without a common vertex pass through each other.
fn pierce(a: &[DVec3; 3], b: &[DVec3; 3]) -> bool {
    let of_a = sides(a, b);
    if is_one_side(&of_a) {
        return false;
    }
    let of_b = sides(b, a);
    !is_one_side(&of_b) && (edges_pierce(a, &of_a, b) || edges_pierce(b, &of_b, a))
}

/// How far points are before the plane of a triangle, times its area.
fn sides(points: &[DVec3; 3], &[p, q, r]: &[DVec3; 3]) -> [f64; 3] {
    let normal = (q - p).cross(r - p);
    points.map(|x| (x - p).dot(normal))
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

#[cfg(test)]
mod tests {
    use crate::garment::{Garment, Scheme, SubdivisionRules};
    use crate::mesh::{FaceId, Faces, VertexId};
    use crate::render::sound::Skin;
    use crate::subdivide::Cage;
    use glam::Vec3;

    /// What crosses of a quad on the ground and one that stands on its first vertex and goes there by `run` and `rise`.
    fn crossings(run: f32, rise: f32) -> Vec<[FaceId; 2]> {
        let at = |along: f32, z: f32| Vec3::new(run * along, 0.8 * run * along, z + rise * along);
        let standing = [at(0.5, -0.6), at(1.0, -0.1), at(0.5, 0.4)];
        let points = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y].into_iter().chain(standing);
        let corners: Vec<VertexId> = [0, 1, 2, 3, 0, 4, 5, 6].map(VertexId::new).to_vec();
        let cage = Cage::new(Garment {
            points: points.collect(),
            faces: Faces::quads(corners),
            rules: SubdivisionRules { scheme: Scheme::Bilinear, ..SubdivisionRules::default() },
            ..Garment::default()
        });
        let all = [0, 1].map(FaceId::new);
        Skin::new(cage.level(), &cage.garment().points, &all, None).crossings(&all)
    }

    #[test]
    fn a_narrow_triangle_may_pass_a_flat_face_that_it_touches() {
        let pentagon = [[0.0, 0.0], [2.0, -1.0], [3.0, 0.5], [2.0, 2.0], [0.5, 1.5]];
        let points = pentagon.map(|[x, y]| Vec3::new(x, y, 0.0));
        let across = |rise: f32| [Vec3::new(1.0, 0.2, rise), Vec3::new(1.0, 0.35, -0.6 * rise)];
        let crossings = |rise: f32| {
            let cage = Cage::new(Garment {
                points: points.into_iter().chain(across(rise)).collect(),
                faces: Faces::mixed([5, 3], [0, 1, 2, 3, 4, 0, 5, 6].map(VertexId::new).to_vec()),
                rules: SubdivisionRules { scheme: Scheme::Bilinear, ..SubdivisionRules::default() },
                ..Garment::default()
            });
            let all = [0, 1].map(FaceId::new);
            let looks = Some(all.map(|_| Vec3::Z).into_iter().collect());
            let mut skin = Skin::new(cage.level(), &cage.garment().points, &all, looks);
            let narrow = all.into_iter().filter(|&face| !skin.is_even(face)).collect::<Vec<_>>();
            (skin.crossings(&narrow), narrow)
        };
        let [pentagon, triangle] = [0, 1].map(FaceId::new);
        assert_eq!(crossings(0.02), (vec![[pentagon, triangle]], vec![triangle]));
    }

    #[test]
    fn faces_that_meet_at_a_vertex_may_cross_there() {
        let both = [0, 1].map(FaceId::new);
        assert_eq!(crossings(1.0, 0.0), [both]);
        assert_eq!(crossings(1.0, -0.2), [both]);
        assert!(crossings(-1.0, 0.0).is_empty());
        assert!(crossings(1.0, 2.0).is_empty());
    }
}
