//! Where a UV set is cut.

use super::{Interpolation, Primvar, Values};
use crate::connectivity::{CornerId, Csr, EdgeId, FaceId, Faces, IdVec, Topology, VertexId};
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
        self.interpolation == Interpolation::FaceVarying && self.has_uvs()
    }

    /// Whether its values can be UVs.
    pub fn has_uvs(&self) -> bool {
        let is_small = |values: &Vec<f32>| values.iter().all(|value| value.abs() < LARGEST_UV);
        self.width() == 2 && matches!(&self.values, Values::F32(values) if is_small(values))
    }
}

/// Least share of a shell's area that is mirrored on purpose, as a half that lies on the other. Less is a fault of the UVs.
const MIRRORED: f64 = 0.1;

impl Primvar {
    /// The row at each corner, as [`Primvar::joined_rows`]. Where a shell is folded so that a part of it is mirrored, the rows of
    /// this part are other ones, with the values of [`Primvar::rows`] rows before.
    pub fn shell_rows(&self, faces: &Faces, vertices: usize) -> IdVec<CornerId, u32> {
        let mut rows = self.joined_rows(faces, vertices);
        for face in self.mirrored(faces, &rows) {
            faces.corners_of(face).for_each(|corner| rows[corner] += self.rows() as u32);
        }
        rows
    }

    /// The UV of a row of [`Primvar::shell_rows`].
    pub fn uv(&self, row: u32) -> DVec2 {
        let at = 2 * (row as usize % self.rows().max(1));
        match &self.values {
            Values::F32(values) => DVec2::new(f64::from(values[at]), f64::from(values[at + 1])),
            _ => DVec2::ZERO,
        }
    }

    /// The faces of the smaller part of each folded shell.
    fn mirrored(&self, faces: &Faces, rows: &IdVec<CornerId, u32>) -> Vec<FaceId> {
        let areas: IdVec<FaceId, f64> = faces.ids().map(|face| self.uv_area(faces, rows, face)).collect();
        let [has_negative, has_positive] =
            [f64::is_sign_negative, f64::is_sign_positive].map(|is| areas.iter().any(|a| *a != 0.0 && is(*a)));
        if !has_negative || !has_positive {
            return Vec::new();
        }
        let shells = shells(faces, rows);
        let is_down = |face: FaceId| (areas[face] < 0.0) != shells[face].is_turned;
        let mut sides = IdVec::<FaceId, [f64; 2]>::filled([0.0; 2], faces.len());
        for face in faces.ids() {
            sides[shells[face].first][usize::from(is_down(face))] += areas[face].abs();
        }
        let is_mirrored = |&face: &FaceId| {
            let [up, down] = sides[shells[face].first];
            let is_folded = up.min(down) >= MIRRORED * (up + down);
            is_folded && areas[face] != 0.0 && is_down(face) == (down <= up)
        };
        faces.ids().filter(is_mirrored).collect()
    }

    /// The signed area of a face in UVs.
    fn uv_area(&self, faces: &Faces, rows: &IdVec<CornerId, u32>, face: FaceId) -> f64 {
        let uv = |corner: CornerId| self.uv(rows[corner]);
        faces.corners_of(face).map(|corner| 0.5 * uv(corner).perp_dot(uv(faces.next(corner)))).sum()
    }
}

/// Where a face is in a UV shell.
#[derive(Clone, Copy)]
struct InShell {
    /// The first face of the shell.
    first: FaceId,
    /// Whether the face is wound against that one.
    is_turned: bool,
}

/// The shells: faces that share an edge with the same rows at its ends.
fn shells(faces: &Faces, rows: &IdVec<CornerId, u32>) -> IdVec<FaceId, InShell> {
    let end = |corner: CornerId| (faces.vertex(corner), rows[corner]);
    let edge = |corner: CornerId| {
        let (a, b) = (end(corner), end(faces.next(corner)));
        (a.min(b), a.max(b), faces.face_of(corner), a < b)
    };
    let mut edges: Vec<_> = faces.corners().ids().map(edge).collect();
    edges.sort_unstable();
    let same = edges.array_windows().filter(|[a, b]| (a.0, a.1) == (b.0, b.1));
    // Faces of one winding run along their edge in opposite directions.
    let pairs = same.flat_map(|[a, b]| [(a.2, (b.2, a.3 == b.3)), (b.2, (a.2, a.3 == b.3))]);
    let beside = Csr::group(faces.len(), pairs.collect::<Vec<_>>().into_iter(), (FaceId::new(0), false));
    let mut found = IdVec::<FaceId, Option<InShell>>::filled(None, faces.len());
    for first in faces.ids() {
        let mut open = vec![(first, false)];
        while let Some((face, is_turned)) = open.pop() {
            if found[face].is_none() {
                found[face] = Some(InShell { first, is_turned });
                open.extend(beside.row(face).iter().map(|&(other, turns)| (other, is_turned != turns)));
            }
        }
    }
    found.iter().map(|face| face.expect("each face is in a shell")).collect()
}

impl<'a> UvSeams<'a> {
    /// The seams of a UV set.
    pub fn new(primvar: &'a Primvar, t: &Topology) -> Self {
        Self { primvar, rows: primvar.shell_rows(&t.faces, t.vertex_count()) }
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
        t.faces.corners_of(face).map(|corner| self.primvar.uv(self.rows[corner])).collect()
    }
}
