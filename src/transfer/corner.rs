//! Values of corners: the constraint UVs as they were made, other sets where their cuts are edges of the mesh.

use super::Sites;
use crate::error::{Warning, Warnings};
use crate::garment::{Garment, Mixing, Primvar, Values};
use crate::mesh::{CornerId, IdVec};
use crate::sim::SimProduct;
use crate::subdivide::{Real, Refiner, Stencils, mix, taken};

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
        return Some(indexed(primvar, &Values::F32(flat), sites, true));
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
    Some(indexed(primvar, &values, sites, false))
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

/// A primvar from flat corner values, indexed so that corners share a value where neither a difference nor, for the
/// constraint UVs, a seam is between them.
fn indexed(primvar: &Primvar, values: &Values, sites: &Sites, keep_seams: bool) -> Primvar {
    let t = &sites.topology;
    let width = primvar.width();
    let same = |a: CornerId, b: CornerId| values.same_rows(width, a.index(), b.index());
    let mut row: IdVec<CornerId, Option<u32>> = IdVec::filled(None, t.faces.corners().len());
    let mut rows = Vec::new();
    for seed in t.faces.corners().ids() {
        if row[seed].is_some() {
            continue;
        }
        let own = rows.len() as u32;
        rows.push(seed.index());
        row[seed] = Some(own);
        let mut reached = vec![seed];
        while let Some(corner) = reached.pop() {
            // The neighbours around the vertex: across the edge that leaves and across the one that arrives.
            let before = t.twin(corner).map(|twin| (t.corner_edge[corner], t.faces.next(twin)));
            let arriving = t.faces.prev(corner);
            let after = t.twin(arriving).map(|twin| (t.corner_edge[arriving], twin));
            for (edge, other) in before.into_iter().chain(after) {
                let is_cut = keep_seams && sites.is_seam[edge];
                if !is_cut && row[other].is_none() && same(corner, other) {
                    row[other] = Some(own);
                    reached.push(other);
                }
            }
        }
    }
    let indices = row.iter().map(|r| r.unwrap_or(0)).collect();
    Primvar { values: values.gather(width, rows.into_iter()), indices: Some(indices), ..primvar.clone() }
}
