//! Which faces of a skin cross.
//!
//! Reference: Volino and Magnenat Thalmann 1994 (a patch all of whose normals are on one side of a plane does not cross
//! itself): faces that touch are looked at closely only where that fails.

use super::skin::{Skin, heights, quads};
use super::tree::{Bounds, Tree};
use crate::mesh::{CornerId, FaceId, IdVec, VertexId};
use glam::{DVec3, Vec3};

/// Cosine of the angle to the plane below which normals count as on its other side. Larger looks at more faces closely.
const ONE_SIDED: f32 = 0.1;

/// A child near another face.
#[derive(Clone, Copy)]
struct Child {
    /// Its number in its face.
    number: usize,
    quad: [Vec3; 4],
    bounds: Bounds,
}

/// What is kept from one pair of faces to the next, so that nothing is allocated for each.
#[derive(Default)]
pub struct Scratch {
    children: Vec<Child>,
}

impl Skin<'_> {
    /// Pairs of faces that cross, or a face twice that crosses itself, with at least one that is active.
    pub fn crossings(&mut self, is_active: &IdVec<FaceId, bool>) -> Vec<[FaceId; 2]> {
        let boxes = &self.boxes;
        self.tree.get_or_insert_with(|| Tree::new(boxes));
        let Some(tree) = &self.tree else { return Vec::new() };
        tree.pairs(is_active, |f, g, scratch| self.cross(f, g, scratch))
    }

    /// Whether the children of two faces cross, or of one.
    pub fn cross(&self, f: FaceId, g: FaceId, scratch: &mut Scratch) -> bool {
        if f == g {
            return self.patches[f].spread < ONE_SIDED && self.children_cross(f, g, true, scratch);
        }
        if self.touch(f, g) {
            let axis = (self.patches[f].normal + self.patches[g].normal).normalize_or_zero();
            return !self.is_one_sided(f, g, axis)
                && !self.are_parted(f, g, axis)
                && !self.are_parted(g, f, axis)
                && self.children_cross(f, g, true, scratch);
        }
        !self.is_apart(f, g)
            && !self.is_apart(g, f)
            && !self.are_beside(f, g)
            && self.children_cross(f, g, false, scratch)
    }

    /// Whether two faces have a vertex in common.
    pub(super) fn touch(&self, f: FaceId, g: FaceId) -> bool {
        let faces = &self.level.topology.faces;
        let (a, b) = (faces.vertices_of(f), faces.vertices_of(g));
        if let (Ok(a), Ok(b)) = (<&[VertexId; 4]>::try_from(a), <&[VertexId; 4]>::try_from(b)) {
            // All at once is faster than to stop at the first.
            return a.iter().fold(false, |any, v| b.iter().fold(any, |any, w| any | (v == w)));
        }
        a.iter().any(|v| b.contains(v))
    }

    /// Whether quads that touch cannot cross, as they look to one side. Of the narrow triangles where a seam ends, one may
    /// pass another all the same.
    fn is_one_sided(&self, f: FaceId, g: FaceId, axis: Vec3) -> bool {
        if [f, g].iter().any(|&face| self.level.topology.faces.valence(face) != 4) {
            return false;
        }
        let (a, b) = (&self.patches[f], &self.patches[g]);
        let is_even = a.spread.min(b.spread) > 0.9 && a.normal.dot(axis) > 0.6;
        is_even || [f, g].iter().all(|&face| self.normals(face).iter().all(|n| n.dot(axis) > ONE_SIDED))
    }

    /// Whether a plane along `axis`, through an edge of `f` at what it has in common with `g`, parts the two.
    fn are_parted(&self, f: FaceId, g: FaceId, axis: Vec3) -> bool {
        let faces = &self.level.topology.faces;
        let (of_f, of_g) = (faces.vertices_of(f), faces.vertices_of(g));
        let (own, other) = (self.samples(f), self.samples(g));
        let next = |i: usize| if i + 1 == of_f.len() { 0 } else { i + 1 };
        let is_common = |i: usize| of_g.contains(&of_f[i]);
        (0..of_f.len()).any(|i| {
            let common = [is_common(i), is_common(next(i))];
            if common == [false; 2] {
                return false;
            }
            let (from, middle, to) = (own[2 * i], own[2 * i + 1], own[2 * next(i)]);
            let normal = axis.cross(to - from);
            let height = |p: Vec3| (p - from).dot(normal);
            let is_end = |p: Vec3| p == from || p == to || (p == middle && common == [true; 2]);
            // The middle of an edge that both have is beside the plane; what is nearer than it may cross.
            let least = if common == [true; 2] { height(middle).abs() } else { 0.0 };
            other.iter().all(|&p| height(p) < -least || is_end(p))
                && own.iter().all(|&p| height(p) >= least || is_end(p))
        })
    }

    /// Whether a plane across the normal of `f` parts two faces.
    fn is_apart(&self, f: FaceId, g: FaceId) -> bool {
        let patch = &self.patches[f];
        are_apart(patch.heights, heights(self.samples(g), patch.normal))
    }

    /// Whether a plane across the line between their centres parts two faces.
    fn are_beside(&self, f: FaceId, g: FaceId) -> bool {
        let (a, b) = (self.samples(f), self.samples(g));
        let axis = b[b.len() - 1] - a[a.len() - 1];
        are_apart(heights(a, axis), heights(b, axis))
    }

    /// `joined` tells whether they may have vertices in common.
    fn children_cross(&self, f: FaceId, g: FaceId, joined: bool, scratch: &mut Scratch) -> bool {
        let common = self.boxes[f].common(&self.boxes[g]);
        let near = |face: FaceId| {
            let children = quads(self.samples(face)).enumerate();
            let children = children.map(|(number, quad)| Child { number, quad, bounds: Bounds::of(&quad) });
            children.filter(|child| child.bounds.meets(&common))
        };
        scratch.children.clear();
        scratch.children.extend(near(g));
        near(f).any(|a| {
            // A child's own two triangles have an edge in common.
            let others =
                scratch.children.iter().filter(|b| (f != g || b.number > a.number) && b.bounds.meets(&a.bounds));
            others.into_iter().any(|b| {
                let middles = b.quad[0] + b.quad[2] - a.quad[0] - a.quad[2];
                let mut axes = [self.normals(f)[a.number], self.normals(g)[b.number], middles].into_iter();
                !axes.any(|axis| are_apart(heights(&a.quad, axis), heights(&b.quad, axis)))
                    && self.triangles_cross((f, &a), (g, b), joined)
            })
        })
    }

    /// Whether the triangles of two children cross, given with their faces.
    fn triangles_cross(&self, (f, a): (FaceId, &Child), (g, b): (FaceId, &Child), joined: bool) -> bool {
        // Triangles that have a vertex in common do not count.
        let mut same = [[false; 4]; 4];
        if joined {
            let (a, b) = (self.quad_vertices(f, a.number), self.quad_vertices(g, b.number));
            same = a.map(|v| b.map(|w| v == w));
        }
        let are_joined = |x: &[usize; 3], y: &[usize; 3]| x.iter().any(|&k| y.iter().any(|&l| same[k][l]));
        let (first, second) = (self.cuts(f, a.number), self.cuts(g, b.number));
        let (a, b) = (a.quad.map(|p| p.as_dvec3()), b.quad.map(|p| p.as_dvec3()));
        let pierces = |x: &[usize; 3], y: &[usize; 3]| !are_joined(x, y) && pierce(&x.map(|k| a[k]), &y.map(|k| b[k]));
        first.iter().any(|x| second.iter().any(|y| pierces(x, y)))
    }

    /// The two triangles of a child, by places in its quad, cut as the refined mesh has it.
    fn cuts(&self, face: FaceId, child: usize) -> [[usize; 3]; 2] {
        let is_odd = self.level.topology.faces.valence(face) == 4 && child % 2 == 1;
        if is_odd { [[1, 2, 3], [1, 3, 0]] } else { [[0, 1, 2], [0, 2, 3]] }
    }

    /// The vertices of a child, in the order of its quad.
    fn quad_vertices(&self, face: FaceId, child: usize) -> [VertexId; 4] {
        let t = &self.level.topology;
        let corners = t.faces.range(face);
        let corner = CornerId::new(corners.start + child);
        let prev = CornerId::new(if child == 0 { corners.end - 1 } else { corner.index() - 1 });
        let middle = |c: CornerId| self.numbering.of_edge(t.corner_edge[c]);
        let own = self.numbering.of_vertex(t.faces.vertex(corner));
        [own, middle(corner), self.numbering.of_face(face), middle(prev)]
    }
}

fn are_apart((a, b): (f32, f32), (c, d): (f32, f32)) -> bool {
    b < c || d < a
}

/// Whether triangles without a common vertex pass through each other.
fn pierce(a: &[DVec3; 3], b: &[DVec3; 3]) -> bool {
    let of_b = sides(a, b);
    if is_one_side(&of_b) {
        return false;
    }
    let of_a = sides(b, a);
    !is_one_side(&of_a) && (edges_pierce(a, &of_b, b) || edges_pierce(b, &of_a, a))
}

/// How far the corners of `a` are before the plane of `b`, times its area.
fn sides(a: &[DVec3; 3], &[p, q, r]: &[DVec3; 3]) -> [f64; 3] {
    let normal = (q - p).cross(r - p);
    a.map(|x| (x - p).dot(normal))
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
