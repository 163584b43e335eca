//! Uniform primvars: the area-weighted mean of numbers, the mode of other values.

use crate::transfer::correspondence::Correspondence;
use rayon::prelude::*;
use std::sync::Arc;
use tailor_mesh::connectivity::FaceId;
use tailor_mesh::garment::{Primvar, Values};
use tailor_mesh::subdivide::{Real, blend_into, scale_to_unit_length};

/// Rows of a primvar with their weights.
type RowWeights = Vec<(usize, f32)>;

/// A uniform primvar on the simulation mesh. A value that covers all of a face is kept bit for bit.
pub(in crate::transfer) fn carry_primvar(primvar: &Primvar, map: &Correspondence<'_>) -> Primvar {
    let carried = UniformTransfer { primvar, map };
    let count = map.coverage.sources.rows();
    let single = |weights: &mut RowWeights, face| carried.single_row(FaceId::new(face), weights);
    let rows: Option<Vec<usize>> = (0..count).into_par_iter().map_init(Vec::new, single).collect();
    match (rows, &primvar.values) {
        (None, Values::F32(v)) => carried.means(Values::F32, v, count),
        (None, Values::F64(v)) => carried.means(Values::F64, v, count),
        (rows, values) => {
            let rows = rows.expect("values that are never mixed have a row for each face").into_iter();
            match &primvar.indices {
                Some(_) => Primvar { indices: Some(Arc::new(rows.map(|r| r as u32).collect())), ..primvar.clone() },
                None => Primvar { values: values.gather(primvar.width(), rows), ..primvar.clone() },
            }
        }
    }
}

struct UniformTransfer<'a> {
    primvar: &'a Primvar,
    map: &'a Correspondence<'a>,
}

impl UniformTransfer<'_> {
    /// The row that a face takes; none where it takes the mean of several, which `weights` then holds.
    fn single_row(&self, face: FaceId, weights: &mut RowWeights) -> Option<usize> {
        let primvar = self.primvar;
        let (values, width) = (&primvar.values, primvar.width());
        weights.clear();
        for covered in self.map.coverage.sources.row(face) {
            let row = primvar.row(covered.face.index());
            let same = |other: usize| other == row || values.same_rows(width, other, row);
            match weights.iter_mut().find(|r| same(r.0)) {
                Some(own) => own.1 += covered.area,
                None => weights.push((row, covered.area)),
            }
        }
        match weights.as_slice() {
            [] => Some(primvar.row(self.map.source_under(face).index())),
            [(row, _)] => Some(*row),
            _ if primvar.is_mixed() => {
                let sum: f32 = weights.iter().map(|r| r.1).sum();
                weights.iter_mut().for_each(|r| r.1 /= sum);
                None
            }
            // The first of equals, in the order of the garment's faces.
            [first, rest @ ..] => Some(rest.iter().fold(*first, |best, r| if r.1 > best.1 { *r } else { best }).0),
        }
    }

    fn means<T: Real>(&self, wrap: impl Fn(Vec<T>) -> Values, source: &[T], count: usize) -> Primvar {
        let (primvar, width) = (self.primvar, self.primvar.width().max(1));
        let row = |row: usize| &source[row * width..][..width];
        let mut means = vec![T::from_f64(0.0); count * width];
        means.par_chunks_mut(width).enumerate().for_each_init(Vec::new, |weights, (face, mean)| {
            match self.single_row(FaceId::new(face), weights) {
                Some(single) => mean.copy_from_slice(row(single)),
                None => {
                    blend_into(&weights.iter().map(|&(r, weight)| (row(r), weight)), primvar, mean);
                    scale_to_unit_length(mean, primvar.components, primvar.mixing());
                }
            }
        });
        Primvar { values: wrap(means), indices: None, ..primvar.clone() }
    }
}
