//! Provenance of each vertex of the simulation mesh as primvars: a face of the garment, and coordinates in it.

use super::correspondence::Correspondence;
use crate::sim::Baseline;
use tailor_mesh::connectivity::{CornerId, IdVec};
use tailor_mesh::garment::{Interpolation, Meaning, Primvar, PrimvarRole, Values};
use tailor_mesh::subdivide::Numbering;

/// The face of the garment under each vertex.
pub const SOURCE_FACE: &str = "tailor:sourceFace";
/// Coordinates in that face, in the frame of [`corner_coordinates`].
pub const SOURCE_COORDS: &str = "tailor:sourceCoords";

/// [`SOURCE_FACE`] and [`SOURCE_COORDS`].
pub(super) fn primvars(map: &Correspondence<'_>) -> [Primvar; 2] {
    let baseline = &map.product.baseline;
    let fine = fine_coordinates(baseline);
    let faces = map.locations.iter().map(|at| baseline.source_face[at.face].index() as i32).collect();
    let coordinates = map.locations.iter().flat_map(|at| {
        let corner = |k: usize| fine[baseline.level_corner[CornerId::new(3 * at.face.index() + k)]];
        let [a, b, c] = [0, 1, 2].map(corner);
        [0, 1].map(|i| a[i] * at.weights.x + b[i] * at.weights.y + c[i] * at.weights.z)
    });
    let primvar = |name: &str, components, values| Primvar {
        name: name.into(),
        meaning: Meaning::Plain,
        half: false,
        interpolation: Interpolation::Vertex,
        components,
        element_size: 1,
        values,
        indices: None,
        role: PrimvarRole::Primvar,
    };
    [primvar(SOURCE_FACE, 1, Values::I32(faces)), primvar(SOURCE_COORDS, 2, Values::F32(coordinates.collect()))]
}

/// Coordinates of corner `k` in a face of `n` corners: those of a triangle are (0, 0), (1, 0), (0, 1), those of a quad
/// the corners of the unit square, others lie evenly on the unit circle.
pub fn corner_coordinates(n: usize, k: usize) -> [f32; 2] {
    match n {
        3 => [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]][k],
        4 => [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]][k],
        _ => {
            let (sin, cos) = (k as f32 / n as f32 * std::f32::consts::TAU).sin_cos();
            [cos, sin]
        }
    }
}

/// The coordinates of each corner of the finest level, by midpoints of edges and centroids of faces.
fn fine_coordinates(baseline: &Baseline) -> IdVec<CornerId, [f32; 2]> {
    let source = &baseline.manifold.corner_source;
    let cage = &baseline.manifold.level.topology.faces;
    let mut coordinates: IdVec<CornerId, [f32; 2]> = IdVec::with_capacity(cage.corners().len());
    for face in cage.ids() {
        // Faces of reversed winding list the garment's corners backwards.
        let first = cage.corners_of(face).map(|c| source[c].index()).min().expect("a face has corners");
        let n = cage.valence(face);
        coordinates.extend(cage.corners_of(face).map(|c| corner_coordinates(n, source[c].index() - first)));
    }
    for (parent, child) in baseline.parents().zip(&baseline.levels) {
        let (t, numbering) = (&parent.topology, Numbering::new(parent));
        let faces = &child.topology.faces;
        let of_child = |corner: CornerId| {
            let face = numbering.parent_face(&t.faces, faces.face_of(corner));
            let vertex = faces.vertex(corner);
            let corners = || t.faces.corners_of(face);
            let midpoint = |c: CornerId| {
                let (a, b) = (coordinates[c], coordinates[t.faces.next(c)]);
                [0, 1].map(|i| 0.5 * (a[i] + b[i]))
            };
            let at_vertex = corners().find(|&c| t.faces.vertex(c) == vertex).map(|c| coordinates[c]);
            let on_edge = || corners().find(|&c| numbering.of_edge(t.corner_edge[c]) == vertex).map(midpoint);
            let n = t.faces.valence(face) as f32;
            let centroid = || [0, 1].map(|i| corners().map(|c| coordinates[c][i]).sum::<f32>() / n);
            at_vertex.or_else(on_edge).unwrap_or_else(centroid)
        };
        coordinates = faces.corners().ids().map(of_child).collect();
    }
    coordinates
}
