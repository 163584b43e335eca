//! The triangles of a level's faces, and those that remeshing starts from.

use crate::mesh::{CornerId, FaceId, Faces, IdVec, Topology, VertexId};
use crate::sim::passes::split::SPLIT_RATIO;
use crate::subdivide::Refiner;
use glam::{Vec2, Vec3};
use std::collections::BTreeSet;

/// The corners of a face from which it can be cut in a fan, the one with the shortest diagonals first.
fn apexes<'a>(
    faces: &'a Faces,
    points: &'a IdVec<VertexId, Vec3>,
    face: FaceId,
) -> impl Iterator<Item = usize> + use<'a> {
    let n = faces.valence(face);
    let vertices = faces.vertices_of(face);
    let longest = move |apex: &usize| {
        let p = points[vertices[*apex]];
        (2..n - 1).map(|k| p.distance_squared(points[vertices[(apex + k) % n]])).fold(0.0f32, f32::max)
    };
    let best = (1..n).fold(0, |best, k| if longest(&k) < longest(&best) { k } else { best });
    std::iter::once(best).chain((0..n).filter(move |&k| k != best))
}

/// The diagonals of a face that is cut in a fan, each with its lower vertex first.
fn diagonals(faces: &Faces, face: FaceId, apex: usize) -> impl Iterator<Item = [VertexId; 2]> + use<'_> {
    let (n, vertices) = (faces.valence(face), faces.vertices_of(face));
    (2..n - 1).map(move |k| {
        let (a, b) = (vertices[apex], vertices[(apex + k) % n]);
        [a.min(b), a.max(b)]
    })
}

fn diagonals_are_new(faces: &Faces, face: FaceId, apex: usize, taken: &BTreeSet<[VertexId; 2]>) -> bool {
    diagonals(faces, face, apex).all(|d| !taken.contains(&d))
}

/// The triangles of a level's faces.
pub(crate) struct Triangulation {
    /// The level's corner behind each corner of the triangles.
    pub corners: IdVec<CornerId, CornerId>,
    /// The level's face behind each triangle.
    pub faces: IdVec<FaceId, FaceId>,
}

impl Triangulation {
    /// Splits quads at their shorter diagonal, and others in a fan from the corner with the shortest diagonals; another
    /// one where two vertices would be joined twice, for such a mesh cannot be edited.
    pub fn new(topology: &Topology, points: &IdVec<VertexId, Vec3>, keep: impl Fn(FaceId) -> bool) -> Self {
        let faces = &topology.faces;
        let kept: Vec<FaceId> = faces.ids().filter(|&f| keep(f)).collect();
        let mut apexes: Vec<usize> = kept.iter().map(|&f| apexes(faces, points, f).next().unwrap_or(0)).collect();
        let mut diagonals: Vec<[VertexId; 2]> =
            kept.iter().zip(&apexes).flat_map(|(&f, &apex)| diagonals(faces, f, apex)).collect();
        diagonals.sort_unstable();
        let joined_twice = diagonals.windows(2).any(|p| p[0] == p[1])
            || diagonals.iter().any(|&[a, b]| topology.find_edge(a, b).is_some());
        if joined_twice {
            let mut taken: BTreeSet<[VertexId; 2]> =
                topology.edges.iter().map(|&[a, b]| [a.min(b), a.max(b)]).collect();
            for (&face, apex) in kept.iter().zip(&mut apexes) {
                let is_new = |&k: &usize| diagonals_are_new(faces, face, k, &taken);
                *apex = self::apexes(faces, points, face).find(is_new).unwrap_or(*apex);
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
}

/// What the start of remeshing is chosen by.
pub(crate) struct StartMesh<'a> {
    /// The levels from the cage on; the last is the one in triangles.
    pub levels: &'a [&'a Refiner],
    /// The level that remeshing starts from.
    pub level: usize,
    /// Positions. \[stage units\]
    pub points: &'a IdVec<VertexId, Vec3>,
    /// Constraint UVs of the triangles' corners.
    pub uvs: &'a IdVec<CornerId, Vec2>,
    /// Target length at each vertex. \[stage units\]
    pub target: &'a IdVec<VertexId, f32>,
}

impl StartMesh<'_> {
    /// The triangles of the level's faces that `keep` tells, by corners of `finest`. A face whose diagonals would be split
    /// first of all gets a vertex in its centre instead.
    pub fn triangles(&self, finest: &Triangulation, keep: impl Fn(FaceId) -> bool) -> Vec<[CornerId; 3]> {
        let faces = &self.levels[self.levels.len() - 1].level.topology.faces;
        let mut own = IdVec::<CornerId, Option<CornerId>>::filled(None, faces.corners().len());
        for (triangle_corner, &c) in finest.corners.enumerated() {
            own[c].get_or_insert(triangle_corner);
        }
        let own = |from: usize, c: CornerId| {
            own[self.levels[from..self.levels.len() - 1].iter().fold(c, |c, parent| parent.child_of(c))]
        };
        let level = self.levels[self.level];
        let vertex = |c: CornerId| level.level.topology.faces.vertex(c);
        let coarse = Triangulation::new(&level.level.topology, self.points, keep);
        let mut triangles = Vec::with_capacity(2 * coarse.faces.len());
        let mut rest = coarse.corners.as_slice();
        for same in coarse.faces.chunk_by(|a, b| a == b) {
            let (fan, others) = rest.split_at(3 * same.len());
            rest = others;
            let rim: Vec<CornerId> = fan[..2].iter().chain(fan.iter().skip(2).step_by(3)).copied().collect();
            let is_long = rim[2..rim.len() - 1].iter().any(|&c| self.is_long(vertex(rim[0]), vertex(c)));
            let centre = level.centre_of(rim[0]).filter(|_| is_long && self.level + 1 < self.levels.len());
            let centre = centre.and_then(|c| own(self.level + 1, c));
            let at = |c: CornerId| own(self.level, c);
            let around = centre.and_then(|centre| {
                let ring = rim.iter().zip(rim.iter().cycle().skip(1));
                let ring: Option<Vec<_>> = ring.map(|(&a, &b)| Some([at(a)?, at(b)?, centre])).collect();
                ring.filter(|ring| self.lie_alike(finest, faces, ring))
            });
            match around {
                Some(ring) => triangles.extend(ring),
                None => triangles.extend(fan.chunks_exact(3).filter_map(|t| Some([at(t[0])?, at(t[1])?, at(t[2])?]))),
            }
        }
        triangles
    }

    /// Whether the edge between two vertices would be split.
    fn is_long(&self, a: VertexId, b: VertexId) -> bool {
        let most = SPLIT_RATIO * 0.5 * (self.target[a] + self.target[b]);
        self.points[a].distance_squared(self.points[b]) > most * most
    }

    /// Whether triangles face the same way, in space and in UV.
    fn lie_alike(&self, finest: &Triangulation, faces: &Faces, triangles: &[[CornerId; 3]]) -> bool {
        let normal = |t: &[CornerId; 3]| {
            let [a, b, c] = t.map(|c| self.points[faces.vertex(finest.corners[c])]);
            (b - a).cross(c - a)
        };
        let area = |t: &[CornerId; 3]| {
            let [a, b, c] = t.map(|c| self.uvs[c]);
            (b - a).perp_dot(c - a)
        };
        let (all, layout): (Vec3, f32) = (triangles.iter().map(normal).sum(), triangles.iter().map(area).sum());
        triangles.iter().all(|t| normal(t).dot(all) > 0.0 && (layout == 0.0 || area(t) * layout > 0.0))
    }
}
