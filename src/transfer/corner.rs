//! Values of corners: the constraint UVs as they were made, other sets region by region.

use super::Sites;
use crate::garment::{Garment, Primvar, Values};
use crate::mesh::{CornerId, FaceId, IdVec};
use crate::sim::{Location, SimProduct};
use crate::subdivide::{Channel, Real, Refiner, mix, mix_rows, taken};
use rayon::prelude::*;

/// A face-varying primvar on the simulation mesh.
pub(super) fn carry(
    garment: &Garment,
    primvar: &Primvar,
    product: &SimProduct,
    sites: &Sites,
    uv_set: Option<&Primvar>,
) -> Primvar {
    if uv_set.is_some_and(|uv| uv.name == primvar.name) {
        let flat = product.places.iter().flat_map(|p| p.uv.to_array()).collect();
        return indexed(primvar, &Values::F32(flat), sites, true);
    }
    if !primvar.is_mixed() {
        let corners = product.places.iter().enumerate().map(|(i, _)| {
            let face = sites.faces[FaceId::new(i / 3)];
            product.baseline.source_corner(face).index()
        });
        return taken(primvar, corners.collect::<Vec<_>>().into_iter());
    }
    let fine = Fine::new(garment, primvar, product);
    let places = fine.places(product, sites);
    let values = match &primvar.values {
        Values::F32(v) => Values::F32(fine.evaluate(v, primvar, product, &places)),
        Values::F64(v) => Values::F64(fine.evaluate(v, primvar, product, &places)),
        // Only real values are mixed, see above.
        discrete => discrete.clone(),
    };
    indexed(primvar, &values, sites, false)
}

/// A face-varying channel refined to the baseline.
struct Fine {
    levels: Vec<Refiner>,
    rows: Vec<u32>,
}

impl Fine {
    fn new(garment: &Garment, primvar: &Primvar, product: &SimProduct) -> Self {
        let baseline = &product.baseline;
        let mut cage = baseline.manifold.refiner.clone();
        let own = primvar.corner_rows(&garment.faces, garment.points.len());
        let rows = cage.add_channel(garment, |c| own[baseline.manifold.corner_source[c]] as usize);
        let mut levels = vec![cage];
        for _ in 0..baseline.levels.len() {
            let parent = levels.last().map(Refiner::derive);
            levels.extend(parent.map(crate::subdivide::Derivation::into_child));
        }
        Self { levels, rows }
    }

    fn finest(&self) -> &Channel {
        &self.levels[self.levels.len() - 1].channels[0]
    }

    /// Where each corner of the simulation mesh takes its value. Where a cut of this channel is no edge of the mesh, a
    /// triangle belongs to the region under its centre, and its corners stay on that.
    fn places(&self, product: &SimProduct, sites: &Sites) -> Vec<Location> {
        let baseline = &product.baseline;
        let value = |c: CornerId| self.finest().corner_value[baseline.level_corner[c]];
        let t = &baseline.topology;
        let is_cut = |c: CornerId| {
            let Some(twin) = t.twin(c) else { return false };
            value(c) != value(t.faces.next(twin)) || value(t.faces.next(c)) != value(twin)
        };
        let cut: IdVec<CornerId, bool> = t.faces.corners().ids().map(is_cut).collect();
        let own_cuts = cut.enumerated().any(|(c, &cut)| cut && !baseline.barrier[c]);
        if !own_cuts {
            return product.places.iter().map(|p| p.location).collect();
        }
        let barrier: IdVec<CornerId, bool> =
            cut.iter().zip(baseline.barrier.iter()).map(|(&cut, &barrier)| cut || barrier).collect();
        let corners = product.triangles.par_iter().enumerate().flat_map_iter(|(i, triangle)| {
            let centre = sites.faces[FaceId::new(i)];
            let barrier = &barrier;
            triangle.iter().map(move |&v| baseline.closest_within(centre, product.points[v], barrier).location)
        });
        corners.collect()
    }

    /// The values of each corner of the simulation mesh.
    fn evaluate<T: Real>(&self, source: &[T], primvar: &Primvar, product: &SimProduct, places: &[Location]) -> Vec<T> {
        let width = primvar.width();
        let mut values: Vec<T> =
            self.rows.iter().flat_map(|&r| source[r as usize * width..][..width].iter().copied()).collect();
        for parent in &self.levels[..self.levels.len() - 1] {
            values = mix_rows(&parent.derive().channels[0], &values, primvar);
        }
        let finest = self.finest();
        let at = |place: &Location| {
            let first = place.face.index() * 3;
            let parts = place.weights.to_array();
            let rows = parts.into_iter().enumerate().map(|(k, weight)| {
                let corner = product.baseline.level_corner[CornerId::new(first + k)];
                (&values[finest.corner_value[corner].index() * width..][..width], weight)
            });
            mix(rows.collect::<Vec<_>>().into_iter(), primvar)
        };
        places.iter().flat_map(at).collect()
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
