//! The baseline's triangles as projections read them.

use super::Baseline;
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use tailor_mesh::connectivity::edit;
use tailor_mesh::connectivity::{CornerId, FaceId, Groups, IdVec, Topology, ValueId, VertexId};

/// A triangle of the baseline in one cache line: a projection reads many, which are far apart in memory.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Facet {
    /// Positions of the corners. \[mesh units\]
    pub points: [Vec3; 3],
    /// The opposite half-edges where a projection may cross; none on chains and at borders.
    pub open_twin: [Option<CornerId>; 3],
    /// Unit normal; zero where there is no area.
    pub normal: Vec3,
    /// +1 or -1: the orientation of the triangle's shell in UV space; 0 where the layout is free, on flipped and small shells.
    pub sense: f32,
}

/// The constraint UVs of corners of triangles.
pub struct Layout<'a> {
    pub uvs: &'a IdVec<CornerId, Vec2>,
    /// Their values: those of the sides of a cut differ, also where their numbers are the same.
    pub values: IdVec<CornerId, ValueId>,
}

/// The facets of triangles; `layout` are their constraint UVs, if there are any.
pub fn facets(
    topology: &Topology,
    points: &IdVec<VertexId, Vec3>,
    barrier: &IdVec<CornerId, bool>,
    layout: Option<Layout<'_>>,
) -> IdVec<FaceId, Facet> {
    let facet = |f: usize| {
        let corners = [0, 1, 2].map(|k| CornerId::new(3 * f + k));
        let [a, b, c] = corners.map(|c| points[topology.faces.vertex(c)]);
        let open_twin = corners.map(|c| topology.twin(c).filter(|_| !barrier[c]));
        Facet { points: [a, b, c], open_twin, normal: (b - a).cross(c - a).normalize_or_zero(), sense: 1.0 }
    };
    let mut facets: IdVec<FaceId, Facet> =
        (0..topology.faces.len()).into_par_iter().map(facet).collect::<Vec<_>>().into();
    let Some(Layout { uvs, values }) = layout else { return facets };
    let mut shells = shells(topology, &values);
    let mut area = IdVec::<FaceId, f64>::filled(0.0, facets.len());
    facets.ids().for_each(|f| area[shells.first(f)] += f64::from(uv_area(uvs, f)));
    facets.ids().for_each(|f| facets[f].sense = if area[shells.first(f)] < 0.0 { -1.0 } else { 1.0 });
    facets
}

/// The UV shells: triangles joined across edges where both sides have the same values.
fn shells(t: &Topology, values: &IdVec<CornerId, ValueId>) -> Groups<FaceId> {
    let mut shells = Groups::new(t.faces.len());
    for corner in t.faces.corners().ids() {
        let Some(twin) = t.twin(corner) else { continue };
        if values[corner] == values[t.faces.next(twin)] && values[t.faces.next(corner)] == values[twin] {
            shells.join(t.faces.face_of(corner), t.faces.face_of(twin));
        }
    }
    shells
}

/// Frees the layout where UVs are flipped or degenerate: no triangle could be upright there, so remeshing that asks for it
/// would neither collapse nor stop to split. Returns the flipped triangles; those around them on the same shell are free too.
pub fn free_flipped(t: &Topology, uvs: &IdVec<CornerId, Vec2>, facets: &mut IdVec<FaceId, Facet>) -> Vec<FaceId> {
    let flipped: Vec<FaceId> = facets.ids().filter(|&f| uv_area(uvs, f) * facets[f].sense <= 0.0).collect();
    for corner in flipped.iter().flat_map(|&f| t.faces.corners_of(f)) {
        let around = t.vertex_corners.row(t.faces.vertex(corner)).iter();
        around.filter(|&&c| uvs[c] == uvs[corner]).for_each(|&c| facets[edit::face(c)].sense = 0.0);
    }
    flipped
}

fn uv_area(uvs: &IdVec<CornerId, Vec2>, face: FaceId) -> f32 {
    let [a, b, c] = [0, 1, 2].map(|k| uvs[CornerId::new(face.index() * 3 + k)]);
    0.5 * (b - a).perp_dot(c - a)
}

impl Baseline {
    /// Gives the vertices other positions.
    pub fn move_to(&mut self, points: IdVec<VertexId, Vec3>) {
        self.points = points;
        for (face, facet) in self.facets.ids().zip(self.facets.iter_mut()) {
            let [a, b, c] = [0, 1, 2].map(|k| self.points[self.topology.faces.vertices_of(face)[k]]);
            (facet.points, facet.normal) = ([a, b, c], (b - a).cross(c - a).normalize_or_zero());
        }
    }

    /// The opposite half-edge, where a projection may cross.
    #[inline]
    pub fn open_twin(&self, corner: CornerId) -> Option<CornerId> {
        self.facets[edit::face(corner)].open_twin[corner.index() % 3]
    }

    /// Signed area of a triangle in UV space.
    pub fn uv_area(&self, face: FaceId) -> f32 {
        uv_area(&self.uvs, face)
    }
}
