//! Where a UV set is cut.

use super::{Interpolation, Primvar, Values};
use crate::mesh::{CornerId, EdgeId, FaceId, IdVec, Topology, VertexId};
use glam::DVec2;

/// The values of a UV set at the corners of a mesh.
pub struct UvSeams<'a> {
    primvar: &'a Primvar,
    rows: IdVec<CornerId, u32>,
}

/// UVs are smaller. Squares of larger ones are not finite in single precision.
const LARGEST_UV: f32 = 1e15;

impl Primvar {
    /// Whether it can be a UV set with seams.
    pub fn is_uv_set(&self) -> bool {
        let is_small = |values: &Vec<f32>| values.iter().all(|value| value.abs() < LARGEST_UV);
        self.interpolation == Interpolation::FaceVarying
            && self.width() == 2
            && matches!(&self.values, Values::F32(values) if is_small(values))
    }
}

impl<'a> UvSeams<'a> {
    /// The seams of a UV set.
    pub fn new(primvar: &'a Primvar, t: &Topology) -> Self {
        Self { primvar, rows: primvar.corner_rows(&t.faces, t.vertex_count()) }
    }

    /// Whether faces at an edge have other UVs there.
    pub fn is_cut(&self, t: &Topology, edge: EdgeId) -> bool {
        let first_end = t.edges[edge][0];
        let rows = |&corner: &CornerId| self.rows_from(t, corner, first_end);
        match t.edge_corners.row(edge) {
            [first, rest @ ..] => rest.iter().any(|corner| rows(corner) != rows(first)),
            [] => false,
        }
    }

    /// The rows at the ends of a half-edge, that of the end `from` first.
    fn rows_from(&self, t: &Topology, corner: CornerId, from: VertexId) -> [u32; 2] {
        let [a, b] = [corner, t.faces.next(corner)].map(|corner| self.rows[corner]);
        if t.faces.vertex(corner) == from { [a, b] } else { [b, a] }
    }

    /// The UVs of a face.
    pub fn uvs_of(&self, t: &Topology, face: FaceId) -> Vec<DVec2> {
        let Values::F32(values) = &self.primvar.values else { return Vec::new() };
        let uv = |corner: CornerId| {
            let row = 2 * self.rows[corner] as usize;
            DVec2::new(f64::from(values[row]), f64::from(values[row + 1]))
        };
        t.faces.corners_of(face).map(uv).collect()
    }
}
