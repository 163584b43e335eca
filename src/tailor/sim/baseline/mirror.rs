//! The two sides of a garment with a plane of symmetry: one is remeshed, and the other takes its triangles.

use crate::sets::Symmetry;
use crate::sim::constraints::cage_edges::half_edge;
use crate::sim::constraints::chain::ChainKind;
use crate::sim::surface::manifold::Manifold;
use crate::sim::surface::triangulation::best_apex;
use glam::Vec3;
use std::collections::{BTreeMap, BTreeSet};
use tailor_mesh::connectivity::{CornerId, EdgeId, FaceId, Groups, IdVec, Topology, VertexId};
use tailor_mesh::garment::Mesh;
use tailor_mesh::subdivide::{Level, Numbering, child_values};

/// A piece that reaches less far from the plane than this has triangles of its own: its half would be drawn to the plane.
/// \[longest target lengths\]
const LEAST: f32 = 1.5;

/// What becomes of a face.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Hole,
    /// It has no twin, or is part of a piece that lies across the plane.
    Alone,
    Remeshed,
    /// It takes the triangles of its twin.
    Copied,
}

/// A piece between edges on the plane.
struct Piece {
    faces: Vec<FaceId>,
    /// The piece that all faces have their twins in.
    twin: Option<FaceId>,
    is_at_plane: bool,
    /// The largest distance of a vertex from its twin. \[mesh units\]
    width: f32,
}

impl Piece {
    /// Whether it may be one of two halves that reach at least so far from the plane.
    fn may_be_half(&self, least: f32) -> bool {
        !self.is_at_plane || self.width > 2.0 * least
    }
}

/// The sides of a garment. There are none if it is not to be symmetric.
#[derive(Default)]
pub struct Mirror {
    /// The twin of each vertex of the finest level; itself on the plane.
    vertex: IdVec<VertexId, Option<VertexId>>,
    /// The side of each face of each level.
    sides: Vec<IdVec<FaceId, Side>>,
    /// The twin of each corner of the baseline's triangles, where they are copied.
    corner: IdVec<CornerId, Option<CornerId>>,
    /// The faces of the garment that are remeshed for themselves.
    alone: BTreeSet<FaceId>,
}

impl Mirror {
    /// The sides of a garment on all `levels` of its cage. `cage_faces` has the face behind each of their faces; `points` are those of
    /// the finest, and `longest` is the longest target length.
    pub fn new(
        garment: &Mesh,
        manifold: &Manifold,
        levels: &[&Level],
        cage_faces: &[IdVec<FaceId, FaceId>],
        is_hole: &IdVec<FaceId, bool>,
        (points, longest): (&IdVec<VertexId, Vec3>, f32),
    ) -> Self {
        let t = &manifold.level.topology;
        let Some(symmetry) = Symmetry::of(garment, t, |v| manifold.vertex_source[v]) else {
            return Self::none(t.faces.ids().filter(|&face| !is_hole[face]));
        };
        let mut mirror = Self {
            vertex: (0..t.vertex_count()).map(|v| symmetry.vertex(VertexId::new(v))).collect(),
            sides: vec![is_hole.iter().map(|&hole| if hole { Side::Hole } else { Side::Alone }).collect()],
            ..Self::default()
        };
        // Faces across the plane are refined once, so that edges are on it.
        let depth = levels.len().min(2) - 1;
        levels[..depth].iter().for_each(|parent| mirror.refine(parent));
        mirror.choose_sides(&levels[depth].topology, points, LEAST * longest);
        let alone = mirror.sides[depth].enumerated().filter(|(_, side)| **side == Side::Alone);
        mirror.alone = alone.map(|(face, _)| cage_faces[depth][face]).collect();
        if !mirror.sides[depth].contains(&Side::Copied) {
            return Self::none(mirror.alone.into_iter());
        }
        levels[depth..levels.len() - 1].iter().for_each(|parent| mirror.refine(parent));
        mirror
    }

    /// No sides: all faces are remeshed for themselves.
    fn none(faces: impl Iterator<Item = FaceId>) -> Self {
        Self { alone: faces.collect(), ..Self::default() }
    }

    /// Of each two pieces that are twins, the later one is copied. All other faces lose their twins.
    fn choose_sides(&mut self, t: &Topology, surface: &IdVec<VertexId, Vec3>, least: f32) {
        let Some(mut sides) = self.sides.pop() else { return };
        let pieces = self.pieces(t, |face| sides[face] != Side::Hole, surface);
        let twin_of = |piece: FaceId| pieces.get(&piece)?.twin.filter(|_| pieces[&piece].may_be_half(least));
        let mut is_paired = IdVec::<VertexId, bool>::filled(false, t.vertex_count());
        for (&first, piece) in &pieces {
            let Some(twin) = twin_of(first).filter(|&twin| twin != first && twin_of(twin) == Some(first)) else {
                continue;
            };
            for &face in &piece.faces {
                sides[face] = if twin < first { Side::Copied } else { Side::Remeshed };
                t.faces.vertices_of(face).iter().for_each(|&v| is_paired[v] = true);
            }
        }
        for (v, twin) in self.vertex.ids().zip(self.vertex.iter_mut()) {
            *twin = twin.filter(|_| is_paired[v]);
        }
        self.sides.push(sides);
    }

    /// The pieces between edges on the plane, by their first faces.
    fn pieces(
        &self,
        t: &Topology,
        is_solid: impl Fn(FaceId) -> bool,
        surface: &IdVec<VertexId, Vec3>,
    ) -> BTreeMap<FaceId, Piece> {
        let mut groups = Groups::<FaceId>::new(t.faces.len());
        for corner in t.faces.corners().ids().filter(|&corner| !self.is_on_plane(t.faces.half_edge(corner))) {
            let faces = t.twin(corner).map(|twin| [corner, twin].map(|c| t.faces.face_of(c)));
            if let Some([own, other]) = faces.filter(|faces| faces.iter().all(|&face| is_solid(face))) {
                groups.join(own, other);
            }
        }
        let mut pieces = BTreeMap::<FaceId, Piece>::new();
        for face in t.faces.ids().filter(|&face| is_solid(face)) {
            let twin = self.face(t, face).filter(|&twin| is_solid(twin)).map(|twin| groups.first(twin));
            let new = || Piece { faces: Vec::new(), twin, is_at_plane: false, width: 0.0 };
            let piece = pieces.entry(groups.first(face)).or_insert_with(new);
            piece.twin = piece.twin.filter(|_| piece.twin == twin);
            piece.faces.push(face);
            for &v in t.faces.vertices_of(face) {
                let twin = self.vertex[v].unwrap_or(v);
                piece.is_at_plane |= twin == v;
                piece.width = piece.width.max(surface[v].distance(surface[twin]));
            }
        }
        pieces
    }

    /// Goes to the next level.
    fn refine(&mut self, parent: &Level) {
        let (t, numbering) = (&parent.topology, Numbering::new(parent));
        let of_edge = |edge| self.edge(t, edge).map(|edge| numbering.of_edge(edge));
        let of_face = |face| self.face(t, face).map(|face| numbering.of_face(face));
        self.vertex = child_values(parent, &self.vertex, of_face, of_edge);
        if let Some(parents) = self.sides.last() {
            let children = t.faces.ids().flat_map(|face| numbering.of_face_within(&t.faces, face).map(move |_| face));
            self.sides.push(children.map(|face| parents[face]).collect());
        }
    }

    /// Whether nothing is copied.
    pub fn is_empty(&self) -> bool {
        self.sides.is_empty()
    }

    /// Whether a face of a level takes the triangles of its twin.
    pub fn is_copied(&self, level: usize, face: FaceId) -> bool {
        self.sides.get(level).is_some_and(|sides| sides[face] == Side::Copied)
    }

    /// The faces of the garment that are remeshed for themselves.
    pub fn alone(&self) -> &BTreeSet<FaceId> {
        &self.alone
    }

    /// The twin of a vertex.
    pub fn vertex(&self, v: VertexId) -> Option<VertexId> {
        self.vertex.as_slice().get(v.index()).copied().flatten()
    }

    /// The twin of a corner of the baseline, if its triangle is copied.
    pub fn corner(&self, corner: CornerId) -> Option<CornerId> {
        self.corner[corner]
    }

    /// The corner from which a face of the finest level is cut in a fan: the best one, and in copied faces that of the twin.
    pub fn apex(&self, t: &Topology, points: &IdVec<VertexId, Vec3>, face: FaceId) -> usize {
        let faces = &t.faces;
        let of_twin = || {
            let twin = self.face(t, face)?;
            let apex = CornerId::new(faces.range(twin).start + best_apex(faces, points, twin));
            self.across(t, apex)?.index().checked_sub(faces.range(face).start).filter(|&k| k < faces.valence(face))
        };
        let copied = self.is_copied(self.sides.len().saturating_sub(1), face).then(of_twin).flatten();
        copied.unwrap_or_else(|| best_apex(faces, points, face))
    }

    /// Makes the constrained edges of a level symmetric, and adds those on the plane.
    pub fn constrain(&self, level: usize, t: &Topology, kinds: &mut BTreeMap<EdgeId, ChainKind>) {
        let is_between = |edge: EdgeId, side: Side| {
            t.edge_corners.row(edge).iter().all(|&corner| self.sides[level][t.faces.face_of(corner)] == side)
        };
        // Of feature lines, those of the side that is remeshed count.
        kinds.retain(|&edge, kind| *kind != ChainKind::FEATURE || !is_between(edge, Side::Copied));
        for (edge, kind) in kinds.clone() {
            if let Some(twin) = self.edge(t, edge) {
                let other = if kind == ChainKind::FEATURE { kind } else { ChainKind::default() };
                kinds.entry(twin).or_insert(other);
            }
        }
        for edge in t.edges.ids().filter(|&edge| self.is_on_plane(t.edges[edge]) && !is_between(edge, Side::Hole)) {
            kinds.entry(edge).or_default();
        }
        let own = kinds.clone();
        for (&edge, kind) in kinds.iter_mut().filter(|(_, kind)| **kind != ChainKind::FEATURE) {
            let twin = self.edge(t, edge).and_then(|edge| own.get(&edge));
            kind.twin = twin.map(|twin| Box::new(ChainKind { twin: None, ..twin.clone() }));
        }
    }

    /// Gives both sides the shorter of their lengths.
    pub fn shorten(&self, target: &mut IdVec<VertexId, f32>) {
        let own = target.clone();
        for (v, twin) in self.vertex.enumerated() {
            target[v] = twin.map_or(own[v], |twin| own[v].min(own[twin]));
        }
    }

    /// Finds the twins of the corners of triangles; `level_face` has the face of the finest level behind each. If the sides are not
    /// cut in the same triangles, nothing is copied.
    pub fn pair(&mut self, t: &Topology, level_face: &IdVec<FaceId, FaceId>, source: &IdVec<FaceId, FaceId>) {
        let finest = &self.sides[self.sides.len() - 1];
        let is_remeshed = |c: CornerId| finest[level_face[t.faces.face_of(c)]] == Side::Remeshed;
        let across = |c| is_remeshed(c).then(|| self.across(t, c)).flatten();
        let corner: IdVec<CornerId, Option<CornerId>> = t.faces.corners().ids().map(across).collect();
        let copied = level_face.iter().filter(|&&face| finest[face] == Side::Copied).count();
        if corner.iter().flatten().count() == 3 * copied {
            self.corner = corner;
        } else {
            *self = Self::none(source.iter().copied());
        }
    }

    /// Whether a path of vertices is on the plane.
    pub fn is_on_plane(&self, path: impl IntoIterator<Item = VertexId>) -> bool {
        path.into_iter().all(|v| self.vertex[v] == Some(v))
    }

    fn edge(&self, t: &Topology, edge: EdgeId) -> Option<EdgeId> {
        let [a, b] = t.edges[edge].map(|v| self.vertex[v]);
        t.find_edge(a?, b?)
    }

    fn face(&self, t: &Topology, face: FaceId) -> Option<FaceId> {
        self.across(t, t.faces.corners_of(face).next()?).map(|corner| t.faces.face_of(corner))
    }

    /// The twin of a corner of the level with this topology.
    fn across(&self, t: &Topology, corner: CornerId) -> Option<CornerId> {
        let [a, b] = t.faces.half_edge(corner).map(|v| self.vertex[v]);
        // Faces go around the other way there.
        half_edge(t, b?, a?).map(|half| t.faces.next(half))
    }
}
