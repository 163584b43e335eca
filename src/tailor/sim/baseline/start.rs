//! The mesh that remeshing starts from: the faces of the level whose edges are nearest to their targets.

use crate::sim::surface::lengths::{Lengths, SPLIT_RATIO};
use crate::sim::surface::triangulation::{RefinedSurface, Triangulation};
use glam::Vec3;
use tailor_mesh::connectivity::{CornerId, FaceId, Faces, IdVec, VertexId};
use tailor_mesh::subdivide::Level;

/// The level that remeshing starts from, and the surface it lies on.
pub struct StartMesh<'a> {
    /// The levels from the cage on; the surface is the last one in triangles.
    pub levels: &'a [&'a Level],
    /// The index of the start's level.
    pub level: usize,
    /// The triangulated surface.
    pub surface: RefinedSurface<'a>,
}

impl StartMesh<'_> {
    /// The triangles of the level's faces that `keep` accepts, by corners of `finest`. A face whose diagonals are long enough
    /// to be split gets a vertex in its centre instead.
    pub fn triangles(&self, finest: &Triangulation, keep: impl Fn(FaceId) -> bool) -> Vec<[CornerId; 3]> {
        let faces = &self.levels[self.levels.len() - 1].topology.faces;
        let mut own = IdVec::<CornerId, Option<CornerId>>::filled(None, faces.corners().len());
        for (triangle_corner, &c) in finest.corners.enumerated() {
            own[c].get_or_insert(triangle_corner);
        }
        // Faces of all levels have the same holes, so each kept corner is in a triangle.
        let triangle_corner = |from: usize, c: CornerId| {
            let finest = self.levels[from..self.levels.len() - 1].iter().fold(c, |c, parent| parent.child_of(c));
            own[finest].unwrap_or_else(|| unreachable!("{finest:?} is in a triangle"))
        };
        let level = self.levels[self.level];
        let at = |c: CornerId| triangle_corner(self.level, c);
        let coarse = Triangulation::new(&level.topology, self.surface.points, keep);
        let mut triangles = Vec::with_capacity(2 * coarse.faces.len());
        let mut rest = coarse.corners.as_slice();
        for same in coarse.faces.chunk_by(|a, b| a == b) {
            let (fan, others) = rest.split_at(3 * same.len());
            rest = others;
            let rim: Vec<CornerId> = fan[..2].iter().chain(fan.iter().skip(2).step_by(3)).copied().collect();
            let vertex = |c: CornerId| level.topology.faces.vertex(c);
            let is_long = rim[2..rim.len() - 1].iter().any(|&c| self.is_long(vertex(rim[0]), vertex(c)));
            let centre = level.centre_of(rim[0]).filter(|_| is_long && self.level + 1 < self.levels.len());
            let ring = centre.map(|centre| {
                let centre = triangle_corner(self.level + 1, centre);
                let edges = rim.iter().zip(rim.iter().cycle().skip(1));
                edges.map(|(&a, &b)| [at(a), at(b), centre]).collect::<Vec<_>>()
            });
            match ring.filter(|ring| self.are_aligned(finest, faces, ring)) {
                Some(ring) => triangles.extend(ring),
                None => triangles.extend(fan.chunks_exact(3).map(|t| [at(t[0]), at(t[1]), at(t[2])])),
            }
        }
        triangles
    }

    /// Whether the edge between two vertices would be split.
    fn is_long(&self, a: VertexId, b: VertexId) -> bool {
        let most = SPLIT_RATIO * 0.5 * (self.surface.target[a] + self.surface.target[b]);
        self.surface.points[a].distance_squared(self.surface.points[b]) > most * most
    }

    /// Whether triangles have the same orientation, in space and in UV.
    fn are_aligned(&self, finest: &Triangulation, faces: &Faces, triangles: &[[CornerId; 3]]) -> bool {
        let normal = |t: &[CornerId; 3]| {
            let [a, b, c] = t.map(|c| self.surface.points[faces.vertex(finest.corners[c])]);
            (b - a).cross(c - a)
        };
        let area = |t: &[CornerId; 3]| {
            let [a, b, c] = t.map(|c| self.surface.uvs[c]);
            (b - a).perp_dot(c - a)
        };
        let (all, layout): (Vec3, f32) = (triangles.iter().map(normal).sum(), triangles.iter().map(area).sum());
        triangles.iter().all(|t| normal(t).dot(all) > 0.0 && (layout == 0.0 || area(t) * layout > 0.0))
    }
}

/// The level whose mean edge is nearest to the mean target, as a ratio: remeshing from there takes the fewest edits.
pub fn nearest_level(levels: &[&Level], points: &IdVec<VertexId, Vec3>, lengths: Lengths<'_>) -> usize {
    let target = f64::from((lengths.min * lengths.max).sqrt());
    let off = |level: &usize| {
        let edges = &levels[*level].topology.edges;
        let sum: f64 = edges.iter().map(|&[a, b]| f64::from(points[a].distance(points[b]))).sum();
        (sum / edges.len().max(1) as f64 / target).ln().abs()
    };
    let ratios = (0..levels.len()).map(|level| (off(&level), level));
    ratios.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0, |(_, level)| level)
}
