//! What projections ask of the baseline's triangles, in one place for each.

use super::Baseline;
use crate::mesh::edit;
use crate::mesh::{CornerId, FaceId, IdVec, Topology, VertexId};
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// A triangle of the baseline, in one line of the cache: a projection looks at many, which lie apart.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Facet {
    /// Positions of the corners. \[stage units\]
    pub points: [Vec3; 3],
    /// The opposite half-edges, where a projection may cross: not those on chains and at borders.
    pub open_twin: [Option<CornerId>; 3],
    /// Unit normal; zero where there is no area.
    pub normal: Vec3,
    /// +1 or -1: the sense in which the triangle's shell lies in UV space.
    pub sense: f32,
}

/// The facets of triangles; `uvs` are the constraint UVs of their corners, if there are any.
pub(crate) fn facets(
    topology: &Topology,
    points: &IdVec<VertexId, Vec3>,
    barrier: &IdVec<CornerId, bool>,
    uvs: Option<&IdVec<CornerId, Vec2>>,
) -> IdVec<FaceId, Facet> {
    let facet = |f: usize| {
        let corners = [0, 1, 2].map(|k| CornerId::new(3 * f + k));
        let [a, b, c] = corners.map(|c| points[topology.faces.vertex(c)]);
        let open_twin = corners.map(|c| topology.twin(c).filter(|_| !barrier[c]));
        Facet { points: [a, b, c], open_twin, normal: (b - a).cross(c - a).normalize_or_zero(), sense: 1.0 }
    };
    let mut facets: IdVec<FaceId, Facet> =
        (0..topology.faces.len()).into_par_iter().map(facet).collect::<Vec<_>>().into();
    let Some(uvs) = uvs else { return facets };
    for shell in shells(topology, uvs) {
        let area: f64 = shell.iter().map(|&f| f64::from(uv_area(uvs, f))).sum();
        let sense = if area < 0.0 { -1.0 } else { 1.0 };
        shell.iter().for_each(|&f| facets[f].sense = sense);
    }
    facets
}

/// The triangles of each shell: joined across edges where the UVs of both sides agree.
fn shells<'a>(t: &'a Topology, uvs: &'a IdVec<CornerId, Vec2>) -> impl Iterator<Item = Vec<FaceId>> + use<'a> {
    let mut seen = IdVec::<FaceId, bool>::filled(false, t.faces.len());
    t.faces.ids().filter_map(move |seed| {
        if std::mem::replace(&mut seen[seed], true) {
            return None;
        }
        let mut shell = vec![seed];
        let mut at = 0;
        while let Some(&face) = shell.get(at) {
            at += 1;
            for corner in t.faces.corners_of(face) {
                let Some(twin) = t.twin(corner) else { continue };
                let same = uvs[corner] == uvs[t.faces.next(twin)] && uvs[t.faces.next(corner)] == uvs[twin];
                let other = t.faces.face_of(twin);
                if same && !std::mem::replace(&mut seen[other], true) {
                    shell.push(other);
                }
            }
        }
        Some(shell)
    })
}

fn uv_area(uvs: &IdVec<CornerId, Vec2>, face: FaceId) -> f32 {
    let [a, b, c] = [0, 1, 2].map(|k| uvs[CornerId::new(face.index() * 3 + k)]);
    0.5 * (b - a).perp_dot(c - a)
}

impl Baseline {
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
