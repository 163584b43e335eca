//! Where each vertex of the simulation mesh comes from, as primvars: a face of the garment, and coordinates in it.

use super::Sites;
use crate::garment::{Interpolation, Mixing, Primvar, PrimvarRole, Values};
use crate::mesh::{CornerId, IdVec};
use crate::sim::SimProduct;
use crate::subdivide::Numbering;

/// The face of the garment under each vertex.
pub const SOURCE_FACE: &str = "tailor:sourceFace";
/// The place in that face: see [`corner_coordinates`] for where its corners are.
pub const SOURCE_COORDS: &str = "tailor:sourceCoords";

/// The two primvars.
pub(super) fn primvars(product: &SimProduct, sites: &Sites<'_>) -> [Primvar; 2] {
    let baseline = &product.baseline;
    let fine = fine_coordinates(product);
    let faces = sites.vertices.iter().map(|at| baseline.source_face[at.face].index() as i32).collect();
    let coordinates = sites.vertices.iter().flat_map(|at| {
        let corner = |k: usize| fine[baseline.level_corner[CornerId::new(3 * at.face.index() + k)]];
        let [a, b, c] = [0, 1, 2].map(corner);
        [0, 1].map(|i| a[i] * at.weights.x + b[i] * at.weights.y + c[i] * at.weights.z)
    });
    let primvar = |name: &str, type_name: &str, components, mixing, values| Primvar {
        name: name.into(),
        role: PrimvarRole::Primvar,
        type_name: type_name.into(),
        interpolation: Interpolation::Vertex,
        components,
        element_size: 1,
        mixing,
        values,
        indices: None,
    };
    [
        primvar(SOURCE_FACE, "int[]", 1, Mixing::Discrete, Values::I32(faces)),
        primvar(SOURCE_COORDS, "float2[]", 2, Mixing::Linear, Values::F32(coordinates.collect())),
    ]
}

/// Where corner `k` of a face of `n` corners is in the face's coordinates: a triangle's at (0, 0), (1, 0), (0, 1), a
/// quad's at those of the unit square, others' evenly round the unit circle.
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

/// The coordinates of each corner of the finest level: children halve the edges of their parents.
fn fine_coordinates(product: &SimProduct) -> IdVec<CornerId, [f32; 2]> {
    let baseline = &product.baseline;
    let source = &baseline.manifold.corner_source;
    let cage = &baseline.manifold.refiner.level.topology.faces;
    let mut coordinates: IdVec<CornerId, [f32; 2]> = IdVec::with_capacity(cage.corners().len());
    for face in cage.ids() {
        // Turned faces run backwards through the corners of the garment's.
        let first = cage.corners_of(face).map(|c| source[c].index()).min().unwrap_or(0);
        let n = cage.valence(face);
        coordinates.extend(cage.corners_of(face).map(|c| corner_coordinates(n, source[c].index() - first)));
    }
    for (parent, child) in baseline.parents().zip(&baseline.levels) {
        let (t, numbering) = (&parent.level.topology, Numbering::new(&parent.level));
        let faces = &child.level.topology.faces;
        let of_child = |corner: CornerId| {
            let face = numbering.parent_face(&t.faces, faces.face_of(corner));
            let vertex = faces.vertex(corner);
            let corners = || t.faces.corners_of(face);
            let middle = |c: CornerId| {
                let (a, b) = (coordinates[c], coordinates[t.faces.next(c)]);
                [0, 1].map(|i| 0.5 * (a[i] + b[i]))
            };
            let at_vertex = corners().find(|&c| t.faces.vertex(c) == vertex).map(|c| coordinates[c]);
            let on_edge = || corners().find(|&c| numbering.of_edge(t.corner_edge[c]) == vertex).map(middle);
            let n = t.faces.valence(face) as f32;
            let centre = || [0, 1].map(|i| corners().map(|c| coordinates[c][i]).sum::<f32>() / n);
            at_vertex.or_else(on_edge).unwrap_or_else(centre)
        };
        coordinates = faces.corners().ids().map(of_child).collect();
    }
    coordinates
}
