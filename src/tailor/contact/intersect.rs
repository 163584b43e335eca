//! Which refined faces intersect.
//!
//! Pairs come from a tree of bounding boxes. Bounds on normals and planes between faces exclude most of them; triangles are
//! tested in double precision. A pair needs no test of triangles in these cases:
//!
//! | pair | excluded where |
//! | --- | --- |
//! | a face with itself | its children are convex, and its normals are on one side of a plane |
//! | two faces without a common vertex | a plane across either normal, or across the line between their centres, separates them |
//! | two with a common vertex, within 60°, both smooth | always |
//! | two with a common vertex, within 60°, neither may overlap | both are almost flat, or all normals are on one side of a plane |
//! | any two with a common vertex | a plane across the line between their centres, or through an edge, separates them |
//! | any two with a common vertex, on the next refinement | they are within 60°, or one may not overlap and they are not opposed |
//!
//! Children that are not convex overlap within their plane: their faces count as such that may overlap, and no plane through
//! a common edge that is bent excludes them.
//!
//! References: Volino and Magnenat-Thalmann 1994, *Efficient self-collision detection on smoothly discretized surface
//! animations using geometrical shape regularity* (a patch whose normals are all on one side of a plane has no
//! self-intersection if its contour has none).

use super::bvh::Aabb;
use super::face::{ChildBlock, ChildId, RefinedFace, SMOOTH};
use super::faces::RefinedFaces;
use super::pairs::{Pairs, WorkLimit};
use super::simd::{ALL, Aabbx4, Intervalx4, Mask, Vec3x4, WIDTH, bits};
use glam::{DVec3, Vec3, Vec4};
use tailor_mesh::connectivity::FaceId;

/// Cosine of the angle to a plane below which normals count as on its other side. Larger tests more faces.
const ONE_SIDED: f32 = 0.1;
/// Cosine between the normals of two faces with a common vertex below which only a plane between them excludes an
/// intersection. Larger tests more faces.
const SHARP: f32 = 0.5;

/// Cosine between the normals of two faces below which they are two layers.
const OPPOSED: f32 = -0.7;

/// How far a face may move, or one relative to another.
#[derive(Clone, Copy)]
pub struct Motion {
    pub by: Vec3,
    /// How far any point may be from there.
    pub slack: f32,
}

impl Motion {
    pub const NONE: Self = Self { by: Vec3::ZERO, slack: 0.0 };

    /// The motion relative to another.
    pub fn relative_to(&self, other: &Self) -> Self {
        Self { by: self.by - other.by, slack: self.slack + other.slack }
    }

    /// The motion of the second face relative to the first.
    fn reversed(&self) -> Self {
        Self { by: -self.by, ..*self }
    }

    /// A box and where it may move.
    pub fn swept(&self, aabb: &Aabb) -> Aabb {
        aabb.swept(self.by).expanded(self.slack)
    }
}

/// A block of a face's children, of which some are near another face.
struct NearChildren<'a> {
    face: &'a RefinedFace,
    /// The number of the block's first child.
    first: usize,
    block: &'a ChildBlock,
    aabbs: Aabbx4,
    near: Mask,
}

impl<'a> NearChildren<'a> {
    /// The children in a box, block by block.
    fn of(face: &'a RefinedFace, aabb: Aabb) -> impl Iterator<Item = Self> {
        let query = Aabbx4::splat(&aabb);
        let blocks = face.blocks().enumerate().map(move |(number, block)| {
            let aabbs = block.aabbs();
            Self { face, first: WIDTH * number, block, aabbs, near: aabbs.intersecting(&query) & block.mask() }
        });
        blocks.filter(|children| children.near != 0)
    }

    fn child(&self, i: usize) -> Child {
        Child { id: (self.face.face, self.first + i), valence: self.face.valence, corners: self.block.child(i) }
    }
}

/// A child of a face.
pub(super) struct Child {
    pub id: ChildId,
    valence: usize,
    corners: [Vec3; 4],
}

impl RefinedFaces<'_> {
    /// Pairs of faces that intersect, or a face twice that intersects itself, of which at least one is active. An active face
    /// in a crowd that is too close to be tested counts as one that intersects itself. Incomplete beyond the bound of `work`.
    pub fn intersecting_pairs(&self, active: &[FaceId], work: &WorkLimit) -> Vec<[FaceId; 2]> {
        let of = |slot: usize| &self.faces[slot];
        let may = |a, b| self.may_cross(of(a), of(b));
        let cross = |a, b| self.cross(of(a), of(b));
        let Pairs { found, crowded } = self.tree().pairs(&self.slots_of(active), may, cross, work);
        let all = found.into_iter().chain(crowded.into_iter().map(|slot| [slot; 2]));
        all.map(|pair| pair.map(|slot| self.faces[slot].face)).collect()
    }

    /// Whether the children of two faces intersect, or of one.
    pub fn intersect(&self, f: FaceId, g: FaceId) -> bool {
        self.do_intersect(self.face(f), self.face(g))
    }

    fn do_intersect(&self, a: &RefinedFace, b: &RefinedFace) -> bool {
        self.may_cross(a, b) && self.cross(a, b)
    }

    /// Whether no bound excludes that two faces intersect, or one itself.
    fn may_cross(&self, a: &RefinedFace, b: &RefinedFace) -> bool {
        let (f, g) = in_order(a, b);
        if f.face != g.face && self.touch(f, g) {
            return !are_smooth(f, g) && self.may_touching_intersect(f, g);
        }
        self.may_intersect(f, g, &Motion::NONE)
    }

    /// Whether triangles of two faces, or of one, intersect.
    fn cross(&self, a: &RefinedFace, b: &RefinedFace) -> bool {
        let (f, g) = in_order(a, b);
        find_near_children(f, g, &Motion::NONE, &mut |a, b| self.triangles_intersect(a, b))
    }

    /// Whether faces without a common vertex may intersect, or a face itself, where the first moves.
    #[inline]
    pub(super) fn may_intersect(&self, f: &RefinedFace, g: &RefinedFace, motion: &Motion) -> bool {
        if f.face == g.face {
            return f.least_cosine < ONE_SIDED || !f.is_convex;
        }
        !separated_along_normal(f, g, motion)
            && !separated_along_normal(g, f, &motion.reversed())
            && !separated_along_centres(f, g)
    }

    /// Whether faces with a common vertex may intersect.
    #[inline]
    pub(super) fn may_touching_intersect(&self, f: &RefinedFace, g: &RefinedFace) -> bool {
        let between = || (f.normal + g.normal).normalize_or_zero();
        let face_one_way = || {
            let axis = between();
            f.least_cosine.min(g.least_cosine) > SMOOTH || [f, g].iter().all(|face| face.all_face(axis, ONE_SIDED))
        };
        let may_overlap = f.may_overlap || g.may_overlap;
        if !may_overlap && are_within_sharp(f, g) && face_one_way() || separated_along_centres(f, g) {
            return false;
        }
        let axis = between();
        !self.separated_at_edge(f, g, axis) && !self.separated_at_edge(g, f, axis)
    }

    /// Whether two faces have a common vertex.
    #[inline]
    pub(super) fn touch(&self, f: &RefinedFace, g: &RefinedFace) -> bool {
        if f.valence <= WIDTH && g.valence <= WIDTH {
            // All comparisons at once are faster than to stop at the first.
            return f.vertices.iter().fold(false, |any, v| g.vertices.iter().fold(any, |any, w| any | (v == w)));
        }
        let [a, b] = [f, g].map(|face| self.vertices(face));
        a.iter().any(|v| b.contains(v))
    }

    /// Whether a plane along `axis`, through an edge of `f` with a common vertex, separates two faces except for the points in
    /// it.
    fn separated_at_edge(&self, f: &RefinedFace, g: &RefinedFace, axis: Vec3) -> bool {
        let [of_f, of_g] = [f, g].map(|face| self.vertices(face));
        let vertex_point = |i: usize| f.block(i / WIDTH).vertex_points.at(i % WIDTH);
        let is_common = |i: usize| of_g.contains(&of_f[i]);
        let mut is_next_common = is_common(0);
        (0..f.valence).any(|i| {
            let next = if i + 1 == f.valence { 0 } else { i + 1 };
            let are_common = [is_next_common, is_common(next)];
            is_next_common = are_common[1];
            if are_common == [false; 2] {
                return false;
            }
            let (from, to) = (vertex_point(i), vertex_point(next));
            let plane = Plane { from, normal: axis.cross(to - from) };
            if plane.height(g.first.face_point) >= 0.0 || plane.height(f.first.face_point) < 0.0 {
                return false;
            }
            // The point of a common edge is off the plane; what is nearer to the plane than it may intersect, and so may a
            // child there that is not convex.
            let edge_point = (are_common == [true; 2]).then(|| f.block(i / WIDTH).edge_points.at(i % WIDTH));
            let least = edge_point.map_or(0.0, |point| plane.height(point).abs());
            if least > 0.0 && !(f.is_convex && g.is_convex) {
                return false;
            }
            let common = [from, to, edge_point.unwrap_or(from)];
            plane.all(g, common, |heights| heights.cmplt(Vec4::splat(-least)).bitmask())
                && plane.all(f, common, |heights| heights.cmpge(Vec4::splat(least)).bitmask())
        })
    }

    /// The children of two faces that intersect.
    pub fn intersecting_children(&self, f: FaceId, g: FaceId) -> Vec<[ChildId; 2]> {
        let children = |face: &RefinedFace| {
            let (id, valence) = (face.face, face.valence);
            let child = |number| Child { id: (id, number), valence, corners: face.child(number) };
            (0..valence).map(child).collect::<Vec<_>>()
        };
        let (of_f, of_g) = (children(self.face(f)), children(self.face(g)));
        let pairs = of_f.iter().flat_map(|a| of_g.iter().map(move |b| (a, b)));
        let intersecting =
            pairs.filter(|(a, b)| (f != g || a.id < b.id) && self.triangles_intersect(a, b)).map(|(a, b)| [a.id, b.id]);
        intersecting.collect()
    }

    /// Whether the triangles of two children intersect. Triangles with a common vertex do not count.
    fn triangles_intersect(&self, a: &Child, b: &Child) -> bool {
        let (of_a, of_b) = (a.triangles(), b.triangles());
        let (in_a, in_b) = (self.child_vertices(a.id), self.child_vertices(b.id));
        let joined = of_a.map(|x| of_b.map(|y| x.iter().any(|&k| y.iter().any(|&l| in_a[k] == in_b[l]))));
        if joined == [[true; 2]; 2] {
            return false;
        }
        let (p, q) = (a.corners.map(|p| p.as_dvec3()), b.corners.map(|p| p.as_dvec3()));
        let intersect = |x: usize, y: usize| pierce(&of_a[x].map(|k| p[k]), &of_b[y].map(|k| q[k]));
        (0..2).any(|x| (0..2).any(|y| !joined[x][y] && intersect(x, y)))
    }
}

impl Child {
    /// The two triangles, by corners, cut as the refined mesh has it: from the first corner of its quad, where children of
    /// quads keep the parent's corner at the parent's place.
    fn triangles(&self) -> [[usize; 3]; 2] {
        let is_odd = self.valence == 4 && self.id.1 % 2 == 1;
        if is_odd { [[1, 2, 3], [1, 3, 0]] } else { [[0, 1, 2], [0, 2, 3]] }
    }
}

/// Two faces in an order that is independent of their order in memory.
fn in_order<'a>(a: &'a RefinedFace, b: &'a RefinedFace) -> (&'a RefinedFace, &'a RefinedFace) {
    if a.face <= b.face { (a, b) } else { (b, a) }
}

/// Whether both faces are smooth, with less than 60° between them.
#[inline]
fn are_smooth(f: &RefinedFace, g: &RefinedFace) -> bool {
    f.is_smooth && g.is_smooth && are_within_sharp(f, g)
}

#[inline]
pub(super) fn are_within_sharp(f: &RefinedFace, g: &RefinedFace) -> bool {
    f.normal.dot(g.normal) >= SHARP
}

/// Whether the normals of two faces are almost opposite, as those of two layers.
#[inline]
pub(super) fn are_opposed(f: &RefinedFace, g: &RefinedFace) -> bool {
    f.normal.dot(g.normal) <= OPPOSED
}

/// Whether a plane across the normal of `f` separates two faces, where `f` moves.
#[inline]
fn separated_along_normal(f: &RefinedFace, g: &RefinedFace, motion: &Motion) -> bool {
    let ((a, b), (c, d)) = (f.extent, g.extent(f.normal));
    let by = motion.by.dot(f.normal);
    b + by.max(0.0) + motion.slack < c || d + motion.slack < a + by.min(0.0)
}

/// Whether a plane across the line between their centres separates two faces, except for points in it.
#[inline]
fn separated_along_centres(f: &RefinedFace, g: &RefinedFace) -> bool {
    let axis = g.first.face_point - f.first.face_point;
    let ((low, end), (start, high)) = (f.extent(axis), g.extent(axis));
    // Not where the centres coincide and all heights are equal.
    low < high && end <= start
}

/// Passes pairs of children that may intersect, where `f` moves, to `visit` until it returns true; whether it did. Pairs of
/// children of one face come once.
pub(super) fn find_near_children(
    f: &RefinedFace,
    g: &RefinedFace,
    motion: &Motion,
    visit: &mut impl FnMut(&Child, &Child) -> bool,
) -> bool {
    let common = motion.swept(&f.aabb).intersection(&g.aabb);
    let mut of_f = NearChildren::of(f, motion.reversed().swept(&g.aabb));
    of_f.any(|a| {
        NearChildren::of(g, common).any(|b| {
            bits(a.near).any(|i| {
                let own = a.child(i);
                let mut near = b.near & b.aabbs.intersecting(&Aabbx4::splat(&motion.swept(&a.aabbs.at(i))));
                if f.face == g.face {
                    near &= after(own.id.1, b.first);
                }
                if near != 0 {
                    near &= not_separated(&own.corners, a.block.normals.at(i), b.block, motion);
                }
                bits(near).any(|j| visit(&own, &b.child(j)))
            })
        })
    })
}

/// The children of `b` that none of three axes separates from a quad, which has a normal and moves: the normals of both and
/// the line between their centres.
#[inline]
fn not_separated(quad: &[Vec3; 4], normal: Vec3, b: &ChildBlock, motion: &Motion) -> Mask {
    let own = quad.map(Vec3x4::splat);
    let (face_points, by) = (Vec3x4::splat(b.face_point), Vec3x4::splat(motion.by));
    let along = |axes: &Vec3x4, slack: f32| {
        let of_b = [&b.vertex_points, &b.edge_points, &b.previous_edge_points, &face_points].map(|p| p.dots(axes));
        let swept = Intervalx4::hull(own.map(|point| point.dots(axes))).swept(by.dots(axes)).expanded(slack);
        swept.intersecting(&Intervalx4::hull(of_b))
    };
    let between = b.vertex_points + face_points - own[0] - own[2];
    along(&Vec3x4::splat(normal), motion.slack) & along(&b.normals, motion.slack) & along(&between, 0.0)
}

/// The elements of a block, whose first child has the number `first`, with a larger number than `number`.
fn after(number: usize, first: usize) -> Mask {
    let passed = (number + 1).saturating_sub(first).min(WIDTH);
    ALL & !((1 << passed) - 1)
}

/// A plane that may separate two faces.
struct Plane {
    from: Vec3,
    normal: Vec3,
}

impl Plane {
    fn height(&self, point: Vec3) -> f32 {
        (point - self.from).dot(self.normal)
    }

    /// Whether all points of a face, except for `common`, have heights that pass a test.
    fn all(&self, face: &RefinedFace, common: [Vec3; 3], test: impl Fn(Vec4) -> Mask) -> bool {
        let from = Vec3x4::splat(self.from);
        let pass = |points: &Vec3x4| {
            let others = ALL & !test((*points - from).dot(self.normal));
            others == 0 || others & !common.iter().fold(0, |all, &point| all | points.equal_to(point)) == 0
        };
        face.blocks().all(|b| pass(&Vec3x4::splat(b.face_point)) && pass(&b.vertex_points) && pass(&b.edge_points))
    }
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

/// Signed distances of points to the plane of a triangle, times twice its area.
fn sides(points: &[DVec3; 3], &[p, q, r]: &[DVec3; 3]) -> [f64; 3] {
    let normal = (q - p).cross(r - p);
    points.map(|x| (x - p).dot(normal))
}

fn is_one_side(sides: &[f64; 3]) -> bool {
    sides.iter().all(|&s| s > 0.0) || sides.iter().all(|&s| s < 0.0)
}

/// Whether an edge of `a`, whose corners have these signed distances to `b`, passes through `b`.
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
mod tests;
