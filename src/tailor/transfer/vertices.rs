//! Values of vertices: numbers interpolated at each vertex's location, other values from the nearest of the points there.

use super::correspondence::Correspondence;
use super::interpolate::{interpolate, weighted};
use crate::sim::{Baseline, BaselinePoint};
use rayon::prelude::*;
use tailor_mesh::connectivity::{CornerId, VertexId};
use tailor_mesh::garment::joints::{self, Influences};
use tailor_mesh::garment::{Mesh, Primvar, Values};
use tailor_mesh::subdivide::{Real, Stencils, gathered};

/// A vertex or varying primvar on the simulation mesh.
pub(super) fn carry(garment: &Mesh, primvar: &Primvar, map: &Correspondence<'_>) -> Primvar {
    let values = match &primvar.values {
        Values::F32(v) if primvar.is_mixed() => Values::F32(interpolated(primvar, v, map)),
        Values::F64(v) if primvar.is_mixed() => Values::F64(interpolated(primvar, v, map)),
        _ => return gathered(primvar, nearest_rows(garment, map).into_iter()),
    };
    Primvar { values, indices: None, ..primvar.clone() }
}

fn interpolated<T: Real>(primvar: &Primvar, source: &[T], map: &Correspondence<'_>) -> Vec<T> {
    let (baseline, width) = (&map.product.baseline, primvar.width());
    let fine = baseline.refine_rows(primvar, source);
    interpolate(map.locations.len(), primvar, |i| {
        let at = &map.locations[VertexId::new(i)];
        let vertex = |k| level_vertex(baseline, CornerId::new(3 * at.face.index() + k));
        weighted(at, |k| &fine[vertex(k).index() * width..][..width])
    })
}

/// The vertex of the finest level at a corner of the baseline.
fn level_vertex(baseline: &Baseline, corner: CornerId) -> VertexId {
    baseline.level_vertex[baseline.topology.faces.vertex(corner)]
}

/// The row of the garment's point that is nearest to each vertex, of those of the face that it is on; the first of equals.
fn nearest_rows(garment: &Mesh, map: &Correspondence<'_>) -> Vec<usize> {
    let (baseline, points) = (&map.product.baseline, &map.product.points);
    let rows = map.locations.enumerated().map(move |(vertex, at)| {
        let corners = garment.faces.vertices_of(baseline.source_face[at.face]).iter();
        let distance = |v: &VertexId| garment.points[*v].distance_squared(points[vertex]);
        corners.min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("a face has corners").index()
    });
    rows.collect()
}

/// The joint influences of the simulation mesh, merged by joint at each vertex's location.
pub(super) fn carry_influences(garment: &Mesh, map: &Correspondence<'_>) -> Vec<Primvar> {
    let Some((indices, weights)) = joints::pair(garment) else { return Vec::new() };
    let source = joints::influences(indices, weights);
    let baseline = &map.product.baseline;
    let mut fine: Vec<Influences> = baseline.manifold.vertex_source.iter().map(|v| source[v.index()].clone()).collect();
    for parent in baseline.parents() {
        let stencils = parent.vertex_stencils();
        let rows = (0..stencils.rows()).into_par_iter();
        fine = rows.map(|r| joints::blend(stencils.merged(r).iter().map(|&(v, w)| (&fine[v.index()], w)))).collect();
    }
    let blended = |at: &BaselinePoint| {
        let corners = baseline.topology.faces.corners_of(at.face).zip(at.weights.to_array());
        joints::blend(corners.map(|(c, w)| (&fine[level_vertex(baseline, c).index()], w)))
    };
    let blended: Vec<Influences> = map.locations.par_iter().map(blended).collect();
    joints::to_primvars(&blended, indices, weights).into()
}
