//! Values of vertices: interpolated at the vertex's location, or taken from the nearest vertex.

use super::Sites;
use super::rows::{at_places, parts};
use crate::garment::joints::{self, Influences};
use crate::garment::{Garment, Interpolation, Primvar, Values};
use crate::mesh::{CornerId, VertexId};
use crate::sim::{Location, SimProduct};
use crate::subdivide::{Real, Stencils, taken};
use rayon::prelude::*;

/// A vertex or varying primvar on the simulation mesh.
pub(super) fn carry(primvar: &Primvar, product: &SimProduct, sites: &Sites<'_>) -> Primvar {
    let values = match &primvar.values {
        Values::F32(v) if primvar.is_mixed() => Values::F32(interpolated(primvar, v, product, sites)),
        Values::F64(v) if primvar.is_mixed() => Values::F64(interpolated(primvar, v, product, sites)),
        _ => {
            let nearest = nearest_sources(product, primvar.interpolation == Interpolation::Varying);
            let sources = sites.vertices.iter().map(|&at| nearest[heaviest(product, at).index()].index());
            return taken(primvar, sources.collect::<Vec<_>>().into_iter());
        }
    };
    Primvar { values, indices: None, ..primvar.clone() }
}

fn interpolated<T: Real>(primvar: &Primvar, source: &[T], product: &SimProduct, sites: &Sites<'_>) -> Vec<T> {
    let width = primvar.width();
    let baseline = &product.baseline;
    let fine = baseline.refine_rows(primvar, source);
    let row = |v: VertexId| &fine[baseline.level_vertex[v].index() * width..][..width];
    at_places(sites.vertices.len(), primvar, |i| {
        let at = &sites.vertices[VertexId::new(i)];
        let corners = baseline.topology.faces.vertices_of(at.face);
        parts(at, |k| row(corners[k]))
    })
}

/// The vertices of the finest level around a location, with their weights.
fn around(product: &SimProduct, at: Location) -> impl Iterator<Item = (VertexId, f32)> + Clone + '_ {
    let faces = &product.baseline.topology.faces;
    faces
        .corners_of(at.face)
        .zip(at.weights.to_array())
        .map(|(c, w)| (product.baseline.level_vertex[faces.vertex(c)], w))
}

fn heaviest(product: &SimProduct, at: Location) -> VertexId {
    let k = at.weights.max_position();
    let faces = &product.baseline.topology.faces;
    product.baseline.level_vertex[faces.vertex(CornerId::new(at.face.index() * 3 + k))]
}

/// The garment's vertex that weighs most at each vertex of the finest level.
fn nearest_sources(product: &SimProduct, linear: bool) -> Vec<VertexId> {
    let baseline = &product.baseline;
    let mut nearest: Vec<VertexId> = baseline.manifold.vertex_source.to_vec();
    for parent in baseline.parents() {
        let stencils = if linear { parent.level.varying_stencils() } else { parent.level.vertex_stencils() };
        let rows = (0..stencils.rows()).into_par_iter();
        nearest = rows.map(|r| stencils.heaviest(r).map_or(VertexId::new(0), |v| nearest[v.index()])).collect();
    }
    nearest
}

/// The skinning of the simulation mesh: influences merged by joint at each vertex's location.
pub(super) fn carry_influences(garment: &Garment, product: &SimProduct, sites: &Sites<'_>) -> Vec<Primvar> {
    let Some((indices, weights)) = joints::pair(garment) else { return Vec::new() };
    let source = joints::influences(indices, weights);
    let baseline = &product.baseline;
    let mut fine: Vec<Influences> = baseline.manifold.vertex_source.iter().map(|v| source[v.index()].clone()).collect();
    for parent in baseline.parents() {
        let stencils = parent.level.vertex_stencils();
        let rows = (0..stencils.rows()).into_par_iter();
        fine = rows.map(|r| joints::blend(stencils.merged(r).iter().map(|&(v, w)| (&fine[v.index()], w)))).collect();
    }
    let at = |at: &Location| joints::blend(around(product, *at).map(|(v, w)| (&fine[v.index()], w)));
    let blended: Vec<Influences> = sites.vertices.par_iter().map(at).collect();
    joints::to_primvars(&blended, indices, weights).into()
}
