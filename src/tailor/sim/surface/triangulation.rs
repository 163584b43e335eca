//! The triangles of a level's faces.

use glam::{Vec2, Vec3};
use std::collections::BTreeSet;
use tailor_mesh::connectivity::{CornerId, FaceId, Faces, IdVec, Topology, ValueId, VertexId};
use tailor_mesh::subdivide::Channel;

/// The corner of a face from which a fan has the shortest diagonals.
pub fn best_apex(faces: &Faces, points: &IdVec<VertexId, Vec3>, face: FaceId) -> usize {
    let (n, vertices) = (faces.valence(face), faces.vertices_of(face));
    let longest = |apex: usize| {
        let p = points[vertices[apex]];
        (2..n - 1).map(|k| p.distance_squared(points[vertices[(apex + k) % n]])).fold(0.0f32, f32::max)
    };
    (1..n).fold(0, |best, k| if longest(k) < longest(best) { k } else { best })
}

/// The corners of a face of `n` from which it can be cut in a fan, the best one first.
fn apexes(n: usize, best: usize) -> impl Iterator<Item = usize> {
    std::iter::once(best).chain((0..n).filter(move |&k| k != best))
}

/// The diagonals of a face that is cut in a fan from corner `apex`, each with its lower vertex first.
fn diagonals(faces: &Faces, face: FaceId, apex: usize) -> impl Iterator<Item = [VertexId; 2]> + use<'_> {
    let (n, vertices) = (faces.valence(face), faces.vertices_of(face));
    (2..n - 1).map(move |k| {
        let (a, b) = (vertices[apex], vertices[(apex + k) % n]);
        [a.min(b), a.max(b)]
    })
}

/// A triangulated surface with target lengths.
#[derive(Clone, Copy)]
pub struct RefinedSurface<'a> {
    /// The triangles.
    pub topology: &'a Topology,
    /// Positions. \[mesh units\]
    pub points: &'a IdVec<VertexId, Vec3>,
    /// Target edge lengths. \[mesh units\]
    pub target: &'a IdVec<VertexId, f32>,
    /// Constraint UVs.
    pub uvs: &'a IdVec<CornerId, Vec2>,
}

/// The triangles of a level's faces.
pub struct Triangulation {
    /// The level's corner behind each corner of the triangles.
    pub corners: IdVec<CornerId, CornerId>,
    /// The level's face behind each triangle.
    pub faces: IdVec<FaceId, FaceId>,
}

impl Triangulation {
    /// Splits quads at their shorter diagonal, and others in a fan from the corner with the shortest diagonals. Where that
    /// would connect two vertices twice, which no edit allows, another corner is taken.
    pub fn new(topology: &Topology, points: &IdVec<VertexId, Vec3>, keep: impl Fn(FaceId) -> bool) -> Self {
        Self::from_apexes(topology, keep, |face| best_apex(&topology.faces, points, face))
    }

    /// As [`Triangulation::new`], with the corner that each fan starts from.
    pub fn from_apexes(topology: &Topology, keep: impl Fn(FaceId) -> bool, apex: impl Fn(FaceId) -> usize) -> Self {
        let faces = &topology.faces;
        let kept: Vec<FaceId> = faces.ids().filter(|&f| keep(f)).collect();
        let mut apexes: Vec<usize> = kept.iter().map(|&f| apex(f)).collect();
        let mut diagonals: Vec<[VertexId; 2]> =
            kept.iter().zip(&apexes).flat_map(|(&f, &apex)| diagonals(faces, f, apex)).collect();
        diagonals.sort_unstable();
        let are_connected_twice = diagonals.windows(2).any(|p| p[0] == p[1])
            || diagonals.iter().any(|&[a, b]| topology.find_edge(a, b).is_some());
        if are_connected_twice {
            let mut taken: BTreeSet<_> = topology.edges.iter().map(|&[a, b]| [a.min(b), a.max(b)]).collect();
            for (&face, apex) in kept.iter().zip(&mut apexes) {
                let is_new = |&k: &usize| self::diagonals(faces, face, k).all(|d| !taken.contains(&d));
                *apex = self::apexes(faces.valence(face), *apex).find(is_new).unwrap_or(*apex);
                taken.extend(self::diagonals(faces, face, *apex));
            }
        }
        let mut all = Self { corners: IdVec::new(), faces: IdVec::new() };
        for (&face, apex) in kept.iter().zip(apexes) {
            let n = faces.valence(face);
            let at = |k: usize| CornerId::new(faces.range(face).start + k % n);
            for k in 1..n - 1 {
                all.corners.extend([at(apex), at(apex + k), at(apex + k + 1)]);
                all.faces.push(face);
            }
        }
        all
    }

    /// The level's vertices at the triangles' corners.
    pub fn vertices(&self, faces: &Faces) -> Vec<VertexId> {
        self.corners.iter().map(|&c| faces.vertex(c)).collect()
    }
    /// The UVs at the triangles' corners: those of the level's channel with values `uvs`, or zero without a channel.
    pub fn uvs(&self, channel: Option<&Channel>, uvs: &[[f32; 2]]) -> IdVec<CornerId, Vec2> {
        let uv = |c: CornerId| channel.map_or(Vec2::ZERO, |channel| uvs[channel.corner_value[c].index()].into());
        self.corners.iter().map(|&c| uv(c)).collect()
    }

    /// The value of a channel at each corner.
    pub fn values(&self, channel: &Channel) -> IdVec<CornerId, ValueId> {
        self.corners.iter().map(|&c| channel.corner_value[c]).collect()
    }
}
