//! Values of corners: the constraint UVs as they were made, other sets where their cuts are edges of the mesh.

use super::Sites;
use crate::error::{Warning, Warnings};
use crate::garment::{Garment, Mixing, Primvar, Values};
use crate::mesh::{CornerId, IdVec, VertexId};
use crate::sim::SimProduct;
use crate::subdivide::{Real, Refiner, Stencils, mix, taken};
use std::collections::HashMap;

/// A face-varying primvar on the simulation mesh; none, with a warning, where its cuts are no edges of the mesh.
pub(super) fn carry(
    garment: &Garment,
    primvar: &Primvar,
    product: &SimProduct,
    sites: &Sites,
    uv_set: Option<&Primvar>,
    warnings: &mut Warnings,
) -> Option<Primvar> {
    if uv_set.is_some_and(|uv| uv.name == primvar.name) {
        let flat = product.places.iter().flat_map(|p| p.uv.to_array()).collect();
        return Some(indexed(primvar, Values::F32(flat), product));
    }
    if primvar.mixing == Mixing::Discrete {
        let corners = product.places.iter().enumerate().map(|(i, _)| {
            let face = sites.faces[crate::mesh::FaceId::new(i / 3)];
            product.baseline.source_corner(face).index()
        });
        return Some(taken(primvar, corners.collect::<Vec<_>>().into_iter()));
    }
    let fine = Fine::new(garment, primvar, product);
    if fine.cuts_outside_chains > 0 {
        warnings.push(Warning::NotCarried {
            what: format!("primvars:{} on the simulation mesh", primvar.name),
            why: format!(
                "{} of its cut edges are no constraints, so triangles would lie across them; name an edge subset of \
                 them in tailor:sim:constraints",
                fine.cuts_outside_chains
            ),
        });
        return None;
    }
    let values = match &primvar.values {
        Values::F32(v) => Values::F32(fine.evaluate(v, primvar, product)),
        Values::F64(v) => Values::F64(fine.evaluate(v, primvar, product)),
        _ => return None,
    };
    Some(indexed(primvar, values, product))
}

/// A face-varying channel refined to the baseline.
struct Fine {
    levels: Vec<Refiner>,
    rows: Vec<u32>,
    cuts_outside_chains: usize,
}

impl Fine {
    fn new(garment: &Garment, primvar: &Primvar, product: &SimProduct) -> Self {
        let baseline = &product.baseline;
        let mut cage = baseline.manifold.refiner.clone();
        let own = primvar.corner_rows(&garment.faces, garment.points.len());
        let rows = cage.add_channel(garment, |c| own[baseline.manifold.corner_source[c]] as usize);
        let is_cut = |e: &crate::mesh::EdgeId| cage.channels[0].is_cut(*e);
        let edges = cage.level.topology.edges.ids();
        let cuts_outside_chains = edges.filter(|e| is_cut(e) && !baseline.constrained.contains(e)).count();
        let mut levels = vec![cage];
        for _ in 0..baseline.levels.len() {
            let parent = levels.last().map(Refiner::derive);
            levels.extend(parent.map(crate::subdivide::Derivation::into_child));
        }
        Self { levels, rows, cuts_outside_chains }
    }

    /// The values of each corner of the simulation mesh.
    fn evaluate<T: Real>(&self, source: &[T], primvar: &Primvar, product: &SimProduct) -> Vec<T> {
        let width = primvar.width();
        let mut values: Vec<T> =
            self.rows.iter().flat_map(|&r| source[r as usize * width..][..width].iter().copied()).collect();
        for parent in &self.levels[..self.levels.len() - 1] {
            values = parent.derive().channels[0].apply_rows(&values, width);
        }
        let finest = &self.levels[self.levels.len() - 1].channels[0];
        let at = |place: &crate::sim::Place| {
            let first = place.location.face.index() * 3;
            let parts = place.location.weights.to_array();
            let rows = parts.into_iter().enumerate().map(|(k, weight)| {
                let corner = product.baseline.level_corner[CornerId::new(first + k)];
                (&values[finest.corner_value[corner].index() * width..][..width], weight)
            });
            mix(rows.collect::<Vec<_>>().into_iter(), primvar)
        };
        product.places.iter().flat_map(at).collect()
    }
}

/// A primvar from flat corner values, indexed so that corners of one vertex with one value share it.
fn indexed(primvar: &Primvar, values: Values, product: &SimProduct) -> Primvar {
    let width = primvar.width();
    let vertices: IdVec<CornerId, VertexId> = product.triangles.iter().flatten().copied().collect();
    let mut first: HashMap<VertexId, Vec<(usize, u32)>> = HashMap::with_capacity(product.points.len());
    let mut rows = Vec::new();
    let indices = vertices.enumerated().map(|(corner, &vertex)| {
        let known = first.entry(vertex).or_default();
        match known.iter().find(|(c, _)| values.same_rows(width, *c, corner.index())) {
            Some(&(_, row)) => row,
            None => {
                rows.push(corner.index());
                known.push((corner.index(), rows.len() as u32 - 1));
                rows.len() as u32 - 1
            }
        }
    });
    let indices: Vec<u32> = indices.collect();
    Primvar { values: values.gather(width, rows.into_iter()), indices: Some(indices), ..primvar.clone() }
}
