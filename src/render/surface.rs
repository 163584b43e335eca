//! The limit surface of a cage.
//!
//! Reference: Boubekeur and Alexa 2008 (places between vertices from the tangent planes there).

use crate::garment::{Orientation, Scheme};
use crate::mesh::{CornerId, FaceId, IdVec, Topology, VertexId};
use crate::subdivide::{Level, Table, carried_points};
use glam::Vec3;
use rayon::prelude::*;

/// Part of the step to the tangent planes that gives a surface of even curvature its true height.
const PHONG_SHARE: f32 = 0.5;
/// Least cosine between the normal at a vertex and those of the faces there. Where a sharp fold has a smaller one, the
/// normal turns.
const SEEN: f32 = 0.3;
/// Length of the mean of normals below which they look opposite ways, so that there is none.
const OPPOSITE: f32 = 0.05;
/// Sine of the angle at a corner up to which its edges count as straight on.
const STRAIGHT: f32 = 0.3;
/// Most turns of a normal. Fewer leave it off the middle of a sharp fold, where one layer then passes the other.
const TURNS: usize = 80;

/// A limit surface: positions at the cage's vertices, and the normal that each corner sees there.
pub struct Surface {
    /// Limit positions.
    pub places: IdVec<VertexId, Vec3>,
    /// Normals to the front; all corners of a vertex have one, unless the surface has a fold there.
    pub normals: IdVec<CornerId, Vec3>,
    /// Where the corners of the cage look.
    of_cage: Vec<Vec3>,
    is_flat: bool,
}

impl Surface {
    /// The limit surface of a cage whose points are `points`, where `rows` are the limit rows of all its vertices.
    pub fn new(
        level: &Level,
        orientation: Orientation,
        rows: &Table<VertexId>,
        points: &IdVec<VertexId, Vec3>,
    ) -> Self {
        let places = carried_points(&rows, points);
        let t = &level.topology;
        let (own, of_cage) =
            rayon::join(|| corner_normals(t, &places, orientation), || corner_normals(t, points, orientation));
        // One for each vertex, unless the surface has a fold there.
        let mean = |vertex: usize| {
            let vertex = VertexId::new(vertex);
            let around = t.vertex_corners.row(vertex).iter().map(|c| own[c.index()]);
            (seen_by_all(around.clone().sum(), &around), has_fold(level, vertex))
        };
        let means: Vec<(Vec3, bool)> = (0..places.len()).into_par_iter().map(mean).collect();
        let normal = |(&own, vertex): (&Vec3, &VertexId)| {
            let (mean, is_folded) = means[vertex.index()];
            if is_folded && own != Vec3::ZERO { own } else { mean }
        };
        let vertices = t.faces.corners().as_slice();
        let normals = own.par_iter().zip(vertices).map(normal).collect::<Vec<_>>().into();
        let is_flat = matches!(level.scheme, Scheme::Bilinear | Scheme::None);
        Self { places, normals, of_cage, is_flat }
    }

    /// The place on the surface that corners with their weights stand for, and the normal there.
    pub fn at(&self, t: &Topology, seen: &[(CornerId, f32)]) -> (Vec3, Vec3) {
        let place: Vec3 = seen.iter().map(|&(c, w)| w * self.places[t.faces.vertex(c)]).sum();
        let sum: Vec3 = seen.iter().map(|&(c, w)| w * self.normals[c]).sum();
        let all = seen.iter().map(|&(c, _)| self.normals[c]);
        let normal = if sum.length() < OPPOSITE { Vec3::ZERO } else { seen_by_all(sum, &all) };
        // Where the limit of a narrow face is turned over, the cage, whose children must not cross, is not.
        let of_cage = seen_by_all(normal, &seen.iter().map(|&(c, _)| self.of_cage[c.index()]));
        let normal = if of_cage == Vec3::ZERO { normal } else { of_cage };
        if self.is_flat {
            return (place, normal);
        }
        let lift = |&(c, w): &(CornerId, f32)| {
            let n = self.normals[c];
            w * (place - self.places[t.faces.vertex(c)]).dot(n) * n
        };
        (place - PHONG_SHARE * seen.iter().map(lift).sum::<Vec3>(), normal)
    }
}

/// Where each corner looks: all of a length, so that a large face beside a fold does not hide the small ones on its other
/// side.
fn corner_normals(t: &Topology, places: &IdVec<VertexId, Vec3>, orientation: Orientation) -> Vec<Vec3> {
    let sign = if orientation == Orientation::LeftHanded { -1.0 } else { 1.0 };
    let of_face = |face: usize| {
        let face = FaceId::new(face);
        let vertices = t.faces.vertices_of(face);
        let centre = vertices.iter().map(|&v| places[v]).sum::<Vec3>() / vertices.len() as f32;
        t.faces.corners_of(face).map(move |c| {
            let [at, next, prev] = [c, t.faces.next(c), t.faces.prev(c)].map(|c| places[t.faces.vertex(c)]);
            let (after, before) = (next - at, prev - at);
            let (corner, inward) = (after.cross(before), (centre - at).cross(prev - next));
            // Where the edges go on straight, as beside the end of a seam, they say nothing, or the opposite.
            let least = STRAIGHT * STRAIGHT * after.length_squared() * before.length_squared();
            let is_clear = corner.length_squared() > least && corner.dot(inward) > 0.0;
            sign * (if is_clear { corner } else { inward }).normalize_or_zero()
        })
    };
    (0..t.faces.len()).into_par_iter().flat_map_iter(of_face).collect()
}

/// The direction of a sum of directions, turned towards those that would see it from behind by ever smaller steps, to the
/// centre of all (Badoiu and Clarkson 2003); none where there is always one, as where a fold goes over into one to the
/// other side. Those that are zero, of corners without area, see it anyhow.
fn seen_by_all(sum: Vec3, vectors: &(impl Iterator<Item = Vec3> + Clone)) -> Vec3 {
    let mut mean = sum.normalize_or_zero();
    let vectors = vectors.clone().filter(|v| *v != Vec3::ZERO);
    for turn in 0..TURNS {
        let least = vectors.clone().min_by(|a, b| a.dot(mean).total_cmp(&b.dot(mean)));
        let Some(least) = least.filter(|least| least.dot(mean) < SEEN) else { return mean };
        mean = mean.lerp(least, 1.0 / (turn + 2) as f32).normalize_or_zero();
    }
    if vectors.clone().all(|v| v.dot(mean) > 0.0) { mean } else { Vec3::ZERO }
}

/// Whether inner edges at a vertex stay sharp.
fn has_fold(level: &Level, vertex: VertexId) -> bool {
    let t = &level.topology;
    let edges = t.vertex_corners.row(vertex).iter().map(|&c| t.corner_edge[c]);
    edges.into_iter().any(|e| !t.is_border(e) && level.edge_sharpness[e] > 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::garment::{Garment, SubdivisionRules};
    use crate::mesh::Faces;
    use crate::subdivide::Cage;

    #[test]
    fn the_normal_of_a_sharp_fold_is_seen_from_both_sides() {
        // Two sides of a fold by 160 degrees, more faces on one than on the other.
        let (front, back) = (Vec3::new(0.17, 0.0, 0.985).normalize(), Vec3::new(0.17, 0.0, -0.985).normalize());
        let all = [front, front, front, front, back, back];
        let normal = seen_by_all(all.iter().sum(), &all.iter().copied());
        assert!(all.iter().all(|side| side.dot(normal) > 0.14), "{normal}");
        // None where a fold goes over into one to the other side: nothing is seen by all.
        let (left, right) = (Vec3::new(0.3, 0.0, -0.95).normalize(), Vec3::new(-0.3, 0.0, -0.95).normalize());
        assert_eq!(seen_by_all(Vec3::Z + left + right, &[Vec3::Z, left, right].into_iter()), Vec3::ZERO);
        // Corners without area have no say.
        let flat = [Vec3::Z, Vec3::ZERO, Vec3::new(0.0, 0.6, 0.8)];
        assert_eq!(seen_by_all(Vec3::Z, &flat.into_iter()), Vec3::Z);
        // Not turned where all see the mean.
        assert_eq!(seen_by_all(Vec3::Y, &[Vec3::Y, Vec3::new(0.6, 0.8, 0.0)].into_iter()), Vec3::Y);
    }

    #[test]
    fn normals_are_seen_by_the_cage_where_it_looks_to_one_side() {
        let t = Topology::new(Faces::quads((0..4).map(VertexId::new).collect::<Vec<_>>()), 4);
        let corners = [0, 1].map(|c| (CornerId::new(c), 0.5));
        let at = |limit: Vec3, of_cage: Vec<Vec3>| {
            let (places, normals) = (IdVec::filled(Vec3::ZERO, 4), IdVec::filled(limit, 4));
            Surface { places, normals, of_cage, is_flat: false }.at(&t, &corners).1
        };
        let tilted = Vec3::new(0.9, 0.0, -0.4).normalize();
        let normal = at(tilted, vec![Vec3::Z; 4]);
        assert!(normal.dot(Vec3::Z) >= SEEN && normal.dot(tilted) > 0.0, "{normal}");
        assert_eq!(at(Vec3::Z, vec![tilted.with_z(0.4); 4]), Vec3::Z, "seen as it is");
        assert_eq!(at(Vec3::Z, vec![Vec3::X, -Vec3::X, Vec3::X, Vec3::X]), Vec3::Z, "seen by all from no side");
    }

    #[test]
    fn corners_that_are_straight_or_more_look_as_their_faces_do() {
        // A seam's end in a plane: a quad and a triangle beside a hexagon, at whose corner the angle is less or more than
        // straight, or nearly so.
        for bulge in [-0.2f32, 1.0 / 6.0, 0.17, 0.4] {
            let points = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, -0.5], [0.0, 1.0], [1.0, 1.0 + bulge], [3.0, 1.5]];
            let points = points.into_iter().chain([[3.0, 3.0], [0.0, 3.0]]).map(|[x, y]| Vec3::new(x, y, 0.0));
            let faces: [&[usize]; 3] = [&[0, 1, 5, 4], &[1, 2, 5], &[2, 6, 7, 8, 4, 5]];
            let corners: Vec<VertexId> = faces.concat().into_iter().map(VertexId::new).collect();
            let faces = Faces::mixed(faces.map(<[usize]>::len), corners);
            let rules = SubdivisionRules { scheme: Scheme::Bilinear, ..SubdivisionRules::default() };
            let cage = Cage::new(Garment { faces, points: points.collect(), rules, ..Garment::default() });
            let rows = cage.level().limit_rows();
            let surface = Surface::new(cage.level(), Orientation::RightHanded, &rows, &cage.garment().points);
            for (corner, normal) in surface.normals.enumerated() {
                assert!(normal.abs_diff_eq(Vec3::Z, 1e-6), "{bulge}: {corner:?} looks along {normal}");
            }
        }
    }
}
