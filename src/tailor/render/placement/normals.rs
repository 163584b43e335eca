//! Normals of a cage's limit surface, as directions of heights: the *most normal* normal points to the outer side of all
//! faces around a vertex, even at sharp folds, where the mean of the face normals may not.
//!
//! References: Aubry and Löhner 2008, On the 'most normal' normal; Badoiu and Clarkson 2003 (its iteration).

use glam::Vec3;
use rayon::prelude::*;
use tailor_mesh::connectivity::{CornerId, FaceId, IdVec, Topology, VertexId};
use tailor_mesh::garment::Orientation;
use tailor_mesh::subdivide::{Level, Table, carried_points};

/// Cosine between a normal and those of its corners below which the normal is improved.
const MIN_COSINE: f32 = 0.3;
/// Length of a mean of normals below which they cancel, so that there is no normal.
const MIN_MEAN_LENGTH: f32 = 0.05;
/// Sine of the angle at a corner up to which its edges count as collinear.
const COLLINEAR_SINE: f32 = 0.3;
/// Most steps to the most normal normal. Fewer leave it off the bisector of a sharp fold, where layers then intersect.
const MOST_NORMAL_STEPS: usize = 80;

/// The normals of a limit surface.
pub struct OuterNormals {
    /// Outer normals. Corners of a vertex share one, unless a sharp edge separates them.
    normals: IdVec<CornerId, Vec3>,
    /// Outer normals of the cage's corners.
    cage_normals: Vec<Vec3>,
}

impl OuterNormals {
    /// The normals of a cage with `points`, by the limit masks `rows` of all its vertices.
    pub fn new(
        level: &Level,
        orientation: Orientation,
        rows: &Table<VertexId>,
        points: &IdVec<VertexId, Vec3>,
    ) -> Self {
        let positions = carried_points(&rows, points);
        let t = &level.topology;
        let (limit_normals, cage_normals) =
            rayon::join(|| corner_normals(t, &positions, orientation), || corner_normals(t, points, orientation));
        let mean = |vertex: usize| {
            let vertex = VertexId::new(vertex);
            let around = t.vertex_corners.row(vertex).iter().map(|c| limit_normals[c.index()]);
            (most_normal(around.clone().sum(), &around), has_sharp_edge(level, vertex))
        };
        let vertex_normals: Vec<(Vec3, bool)> = (0..positions.len()).into_par_iter().map(mean).collect();
        let normal = |(&own, vertex): (&Vec3, &VertexId)| {
            let (mean, is_sharp) = vertex_normals[vertex.index()];
            if is_sharp && own != Vec3::ZERO { own } else { mean }
        };
        let vertices = t.faces.corners().as_slice();
        let normals = limit_normals.par_iter().zip(vertices).map(normal).collect::<Vec<_>>().into();
        Self { normals, cage_normals }
    }

    /// Their memory. \[bytes\]
    pub fn bytes(&self) -> usize {
        size_of_val(self.normals.as_slice()) + size_of_val(self.cage_normals.as_slice())
    }

    /// The normal at the weighted mean of some corners. It is zero where there is none.
    pub fn normal(&self, corners: &[(CornerId, f32)]) -> Vec3 {
        let sum: Vec3 = corners.iter().map(|&(c, w)| w * self.normals[c]).sum();
        let all = corners.iter().map(|&(c, _)| self.normals[c]);
        let normal = if sum.length() < MIN_MEAN_LENGTH { Vec3::ZERO } else { most_normal(sum, &all) };
        // The limit of a narrow face may be flipped where the cage is not. The children of the cage must not intersect.
        let cage_normal = most_normal(normal, &corners.iter().map(|&(c, _)| self.cage_normals[c.index()]));
        if cage_normal == Vec3::ZERO { normal } else { cage_normal }
    }
}

/// Outer normals of all corners. Unit length gives a small face beside a fold the same weight as a large one.
fn corner_normals(t: &Topology, positions: &IdVec<VertexId, Vec3>, orientation: Orientation) -> Vec<Vec3> {
    let sign = if orientation == Orientation::LeftHanded { -1.0 } else { 1.0 };
    let of_face = |face: usize| {
        let face = FaceId::new(face);
        let vertices = t.faces.vertices_of(face);
        let centre = vertices.iter().map(|&v| positions[v]).sum::<Vec3>() / vertices.len() as f32;
        t.faces.corners_of(face).map(move |c| {
            let [at, next, prev] = [c, t.faces.next(c), t.faces.prev(c)].map(|c| positions[t.faces.vertex(c)]);
            let (after, before) = (next - at, prev - at);
            let (corner, inward) = (after.cross(before), (centre - at).cross(prev - next));
            // Collinear edges, as beside the end of a seam, give no normal or the opposite one.
            let least = COLLINEAR_SINE * COLLINEAR_SINE * after.length_squared() * before.length_squared();
            let is_clear = corner.length_squared() > least && corner.dot(inward) > 0.0;
            sign * (if is_clear { corner } else { inward }).normalize_or_zero()
        })
    };
    (0..t.faces.len()).into_par_iter().flat_map_iter(of_face).collect()
}

/// The most normal normal of some directions, starting from their `sum`. Each step turns it towards the direction with
/// the smallest cosine, by less than the step before. Zero directions, of corners without area, are ignored. The result
/// is zero unless its cosine with all others is positive; it is zero where folds to both sides meet.
fn most_normal(sum: Vec3, vectors: &(impl Iterator<Item = Vec3> + Clone)) -> Vec3 {
    let mut mean = sum.normalize_or_zero();
    let vectors = vectors.clone().filter(|v| *v != Vec3::ZERO);
    for step in 0..MOST_NORMAL_STEPS {
        let least = vectors.clone().min_by(|a, b| a.dot(mean).total_cmp(&b.dot(mean)));
        let Some(least) = least.filter(|least| least.dot(mean) < MIN_COSINE) else { return mean };
        mean = mean.lerp(least, 1.0 / (step + 2) as f32).normalize_or_zero();
    }
    if vectors.clone().all(|v| v.dot(mean) > 0.0) { mean } else { Vec3::ZERO }
}

/// True if an interior edge at a vertex stays sharp after one refinement.
fn has_sharp_edge(level: &Level, vertex: VertexId) -> bool {
    let t = &level.topology;
    let edges = t.vertex_corners.row(vertex).iter().map(|&c| t.corner_edge[c]);
    edges.into_iter().any(|e| !t.is_border(e) && level.edge_sharpness[e] > 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tailor_mesh::connectivity::Faces;
    use tailor_mesh::garment::{Mesh, Scheme, SubdivisionRules};
    use tailor_testing::cage::Cage;

    #[test]
    fn the_normal_of_a_sharp_fold_is_outside_of_both_sides() {
        // A fold by 160 degrees with more faces on one side.
        let (above, below) = (Vec3::new(0.17, 0.0, 0.985).normalize(), Vec3::new(0.17, 0.0, -0.985).normalize());
        let all = [above, above, above, above, below, below];
        let normal = most_normal(all.iter().sum(), &all.iter().copied());
        assert!(all.iter().all(|side| side.dot(normal) > 0.14), "{normal}");
        // Folds to both sides meet: no direction is outside of all faces.
        let (left, right) = (Vec3::new(0.3, 0.0, -0.95).normalize(), Vec3::new(-0.3, 0.0, -0.95).normalize());
        assert_eq!(most_normal(Vec3::Z + left + right, &[Vec3::Z, left, right].into_iter()), Vec3::ZERO);
        // Corners without area are ignored.
        let flat = [Vec3::Z, Vec3::ZERO, Vec3::new(0.0, 0.6, 0.8)];
        assert_eq!(most_normal(Vec3::Z, &flat.into_iter()), Vec3::Z);
        // The mean remains if it is outside of all faces.
        assert_eq!(most_normal(Vec3::Y, &[Vec3::Y, Vec3::new(0.6, 0.8, 0.0)].into_iter()), Vec3::Y);
    }

    #[test]
    fn normals_are_outside_of_the_cage_too() {
        let corners = [0, 1].map(|c| (CornerId::new(c), 0.5));
        let at = |limit: Vec3, cage_normals: Vec<Vec3>| {
            OuterNormals { normals: IdVec::filled(limit, 4), cage_normals }.normal(&corners)
        };
        let tilted = Vec3::new(0.9, 0.0, -0.4).normalize();
        let normal = at(tilted, vec![Vec3::Z; 4]);
        assert!(normal.dot(Vec3::Z) >= MIN_COSINE && normal.dot(tilted) > 0.0, "{normal}");
        assert_eq!(at(Vec3::Z, vec![tilted.with_z(0.4); 4]), Vec3::Z, "outside already");
        assert_eq!(at(Vec3::Z, vec![Vec3::X, -Vec3::X, Vec3::X, Vec3::X]), Vec3::Z, "the cage has no normal");
    }

    #[test]
    fn corners_with_collinear_edges_have_the_normals_of_their_faces() {
        // The end of a seam in a plane: a quad and a triangle beside a hexagon with a corner of about 180 degrees.
        for bulge in [-0.2f32, 1.0 / 6.0, 0.17, 0.4] {
            let points = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, -0.5], [0.0, 1.0], [1.0, 1.0 + bulge], [3.0, 1.5]];
            let points = points.into_iter().chain([[3.0, 3.0], [0.0, 3.0]]).map(|[x, y]| Vec3::new(x, y, 0.0));
            let faces: [&[usize]; 3] = [&[0, 1, 5, 4], &[1, 2, 5], &[2, 6, 7, 8, 4, 5]];
            let corners: Vec<VertexId> = faces.concat().into_iter().map(VertexId::new).collect();
            let faces = Faces::mixed(faces.map(<[usize]>::len), corners);
            let rules = SubdivisionRules { scheme: Scheme::Bilinear, ..SubdivisionRules::default() };
            let cage = Cage::new(Mesh { faces, points: points.collect(), rules, ..Mesh::default() });
            let rows = cage.level().limit_rows();
            let surface = OuterNormals::new(cage.level(), Orientation::RightHanded, &rows, &cage.garment().points);
            for (corner, normal) in surface.normals.enumerated() {
                assert!(normal.abs_diff_eq(Vec3::Z, 1e-6), "{bulge}: {corner:?} has the normal {normal}");
            }
        }
    }
}
