//! Face-varying primvars: the constraint UVs of the remeshing, other values from the corners' locations, each
//! triangle within one shell.

mod cuts;
mod field;
mod flips;
mod shells;
mod sources;

use super::correspondence::Correspondence;
use cuts::ChannelCuts;
use field::FaceVaryingField;
use rayon::prelude::*;
use shells::ShellValues;
use std::sync::Arc;
use tailor_mesh::connectivity::{CornerId, FaceId, IdVec, Topology, VertexId};
use tailor_mesh::error::{Warning, counted};
use tailor_mesh::garment::{Elements, Interpolation, Mesh, Primvar, Values};
use tailor_mesh::subdivide::{Real, gathered};

/// A face-varying primvar on the simulation mesh. It becomes a vertex primvar where that changes no value.
///
/// The primvar `uv_set` stays on corners: a later run needs a layout there.
pub(super) fn carry(
    garment: &Mesh,
    primvar: &Primvar,
    map: &Correspondence<'_>,
    uv_set: &str,
) -> (Primvar, Option<Warning>) {
    let is_uv_set = primvar.name == uv_set;
    if is_uv_set && map.product.baseline.has_uvs {
        return (constraint_uvs(primvar, map), None);
    }
    let (carried, cut_off) = match &primvar.values {
        Values::F32(v) if primvar.is_mixed() => carry_mixed(garment, primvar, map, v, Values::F32),
        Values::F64(v) if primvar.is_mixed() => carry_mixed(garment, primvar, map, v, Values::F64),
        _ => {
            let source = |i| map.product.baseline.source_corner(map.triangle_under(FaceId::new(i))).index();
            let sources: Vec<usize> = (0..map.product.triangles.len()).into_par_iter().map(source).collect();
            (gathered(primvar, sources.iter().flat_map(|&c| [c; 3])), Vec::new())
        }
    };
    let warning = (!cut_off.is_empty()).then(|| cut_off_warning(&cut_off, primvar, map));
    (if is_uv_set { carried } else { as_vertex(carried, &map.mesh.topology) }, warning)
}

fn cut_off_warning(triangles: &[FaceId], primvar: &Primvar, map: &Correspondence<'_>) -> Warning {
    let triangle_words = counted(triangles.len(), "triangle", "triangles");
    let problem = format!("{triangle_words} would flip in the UV shells, and got UV islands apart from them");
    let faces = triangles.iter().map(|&triangle| map.product.baseline.source_face[map.triangle_under(triangle)]);
    Warning::new(tailor_mesh::codes::NOT_CARRIED, format!("primvars:{}", primvar.name), problem)
        .at(Elements::Faces(faces.collect()))
        .remedy("Add edge sets along the cuts of the layout to sim.constraints, or lower sim.maxEdgeLength")
}

fn constraint_uvs(primvar: &Primvar, map: &Correspondence<'_>) -> Primvar {
    let uvs: Vec<f32> = map.product.places.iter().flat_map(|p| p.uv.to_array()).collect();
    let same = |a: CornerId, b: CornerId| uvs[2 * a.index()..][..2] == uvs[2 * b.index()..][..2];
    let rows = shared_rows(map, true, same);
    indexed(primvar, &Values::F32(uvs), rows)
}

/// A primvar whose values `source` are mixed, and the triangles that are cut off from their shells.
fn carry_mixed<T: Real>(
    garment: &Mesh,
    primvar: &Primvar,
    map: &Correspondence<'_>,
    source: &[T],
    wrap: impl Fn(Vec<T>) -> Values,
) -> (Primvar, Vec<FaceId>) {
    let field = FaceVaryingField::new(garment, primvar, &map.product.baseline, source);
    let (values, cut_off) = match field.barrier() {
        Some(barrier) => ShellValues::new(&field, &ChannelCuts::new(map, barrier)).resolved(),
        None => (field.at_locations(map.product.places.len(), |c| map.product.places[c].location), Vec::new()),
    };
    let rows = shared_rows(map, false, |a, b| field.same(&values, a, b));
    (indexed(primvar, &wrap(values), rows), cut_off)
}

/// The primvar on vertices if the corners of each vertex have the same value bit for bit; else unchanged.
fn as_vertex(primvar: Primvar, t: &Topology) -> Primvar {
    let corners_of = |v: VertexId| t.vertex_corners.row(v);
    let row = |c: CornerId| primvar.row(c.index());
    let same = |a: usize, b: usize| a == b || primvar.values.same_rows(primvar.width(), a, b);
    let is_one = |v| corners_of(v).first().is_some_and(|&own| corners_of(v).iter().all(|&c| same(row(c), row(own))));
    let vertices = (0..t.vertex_count()).map(VertexId::new);
    if !vertices.clone().all(is_one) {
        return primvar;
    }
    let rows = vertices.map(|v| row(corners_of(v)[0]));
    let (values, indices) = match &primvar.indices {
        Some(_) if !primvar.is_mixed() => (primvar.values.clone(), Some(Arc::new(rows.map(|r| r as u32).collect()))),
        _ => (primvar.values.gather(primvar.width(), rows), None),
    };
    Primvar { interpolation: Interpolation::Vertex, values, indices, ..primvar }
}

/// The first corner of each value that corners of a vertex share, and the value of each corner.
///
/// Corners share a value unless `same` denies it or, with `keep_seams`, a seam of the constraint UVs is between them.
fn shared_rows(
    map: &Correspondence<'_>,
    keep_seams: bool,
    same: impl Fn(CornerId, CornerId) -> bool,
) -> (Vec<usize>, Vec<u32>) {
    const UNSET: u32 = u32::MAX;
    let (mesh, faces) = (map.mesh, &map.mesh.topology.faces);
    let mut indices = IdVec::filled(UNSET, faces.corners().len());
    let (mut rows, mut reached) = (Vec::with_capacity(map.locations.len()), Vec::new());
    for seed in faces.corners().ids() {
        if indices[seed] != UNSET {
            continue;
        }
        let own = rows.len() as u32;
        rows.push(seed.index());
        indices[seed] = own;
        reached.push(seed);
        while let Some(corner) = reached.pop() {
            // The neighbours around the vertex, across the outgoing and the incoming half-edge.
            let incoming = faces.prev(corner);
            let before = mesh.twin[corner].map(|twin| (corner, faces.next(twin)));
            let after = mesh.twin[incoming].map(|twin| (incoming, twin));
            for (half, other) in before.into_iter().chain(after) {
                let is_cut = || keep_seams && mesh.is_seam[mesh.topology.corner_edge[half]];
                // Comparison with the kept value stops small differences from adding up around a vertex.
                if indices[other] == UNSET && !is_cut() && same(seed, other) {
                    indices[other] = own;
                    reached.push(other);
                }
            }
        }
    }
    (rows, indices.into_vec())
}

/// A primvar with some rows of `values`, and the row of each corner.
fn indexed(primvar: &Primvar, values: &Values, (rows, indices): (Vec<usize>, Vec<u32>)) -> Primvar {
    let values = values.gather(primvar.width(), rows.into_iter());
    Primvar { values, indices: Some(Arc::new(indices)), ..primvar.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tailor_mesh::connectivity::Faces;

    /// Two triangles over four vertices.
    fn two() -> Topology {
        Topology::new(Faces::triangles([0, 1, 2, 2, 1, 3].map(VertexId::new).to_vec()), 4)
    }

    fn bits(primvar: &Primvar, row: usize) -> u32 {
        match &primvar.values {
            Values::F32(v) => v[primvar.row(row)].to_bits(),
            _ => panic!("floats stay floats"),
        }
    }

    #[test]
    fn values_on_vertices_are_those_of_all_corners_bit_for_bit() {
        let (t, of_vertex) = (two(), [0.1f32, -0.0, f32::MIN_POSITIVE, f32::NAN]);
        let corners: Vec<f32> = t.faces.corners().iter().map(|v| of_vertex[v.index()]).collect();
        for given in
            [Primvar::of_corners(corners, None), Primvar::of_corners(of_vertex.to_vec(), Some(vec![0, 1, 2, 2, 1, 3]))]
        {
            let moved = as_vertex(given.clone(), &t);
            assert_eq!((moved.interpolation, moved.elements()), (Interpolation::Vertex, 4));
            for (corner, vertex) in t.faces.corners().enumerated() {
                assert_eq!(bits(&moved, vertex.index()), bits(&given, corner.index()));
            }
        }
    }

    #[test]
    fn a_corner_that_differs_by_one_bit_keeps_all_on_corners() {
        let t = two();
        for (corner, other) in [(3, 2.0f32.next_up()), (4, -0.0)] {
            let mut values = vec![1.0, 0.0, 2.0, 2.0, 0.0, 3.0];
            values[corner] = other;
            let given = Primvar::of_corners(values, None);
            assert_eq!(as_vertex(given.clone(), &t), given);
        }
    }
}
