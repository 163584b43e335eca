//! Values of vertices: interpolated at the vertex's location, or taken from the nearest vertex.

use super::Sites;
use super::rows::{at_places, parts};
use crate::garment::joints::{self, Influences};
use crate::garment::{Garment, Interpolation, Mixing, Primvar, Values};
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

/// Numbers of one value up to which a primvar is carried together with others: wider ones gain nothing, and take memory.
const MAX_TOGETHER: usize = 16;

/// Whether a primvar is carried together with others of its kind.
pub(super) fn is_together(garment: &Garment, primvar: &Primvar) -> bool {
    matches!(primvar.interpolation, Interpolation::Vertex | Interpolation::Varying)
        && matches!(primvar.values, Values::F32(_))
        && matches!(primvar.mixing, Mixing::Linear | Mixing::Direction)
        && (1..=MAX_TOGETHER).contains(&primvar.width())
        && !joints::is_influence(garment, primvar)
        && !primvar.is_normals()
}

/// Primvars that are carried together, as the weights of subdivision are the same for all.
pub(super) fn carry_together(garment: &Garment, product: &SimProduct, sites: &Sites<'_>) -> Vec<Primvar> {
    let kinds = [Interpolation::Vertex, Interpolation::Varying];
    let carried = kinds.into_par_iter().map(|kind| {
        let is_own = |p: &&Primvar| p.interpolation == kind && is_together(garment, p);
        let own: Vec<&Primvar> = garment.primvars.iter().filter(is_own).collect();
        let Some(joined) = joined(&own, garment.points.len()) else { return Vec::new() };
        apart(&own, &carry(&joined, product, sites))
    });
    carried.flatten().collect()
}

/// One primvar with the values of several side by side.
fn joined(primvars: &[&Primvar], count: usize) -> Option<Primvar> {
    let width = primvars.iter().map(|p| p.width()).sum();
    let mut values = Vec::with_capacity(count * width);
    for vertex in 0..count {
        for primvar in primvars {
            let Values::F32(own) = &primvar.values else { continue };
            values.extend_from_slice(&own[primvar.row(vertex) * primvar.width()..][..primvar.width()]);
        }
    }
    let like =
        Primvar { element_size: 1, components: width, values: Values::F32(values), ..(*primvars.first()?).clone() };
    Some(Primvar { indices: None, mixing: Mixing::Linear, ..like })
}

/// The primvars whose values one has side by side.
fn apart(primvars: &[&Primvar], joined: &Primvar) -> Vec<Primvar> {
    let Values::F32(values) = &joined.values else { return Vec::new() };
    let mut at = 0;
    let own = |primvar: &&Primvar| {
        let range = at..at + primvar.width();
        at = range.end;
        let own = values.chunks_exact(joined.components).flat_map(|row| &row[range.clone()]).copied().collect();
        Primvar { values: Values::F32(own), indices: None, ..(*primvar).clone() }
    };
    primvars.iter().map(own).collect()
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
