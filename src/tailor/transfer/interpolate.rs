//! Rows of a primvar, interpolated within triangles.

use crate::sim::BaselinePoint;
use rayon::prelude::*;
use tailor_mesh::garment::Primvar;
use tailor_mesh::subdivide::{Real, blend_into};

/// Rows that one task interpolates.
const CHUNK: usize = 1024;

/// The rows at a triangle's corners, with their weights.
pub(super) type WeightedRows<'a, T> = [(&'a [T], f32); 3];

/// `count` rows of [`Primvar::width`] numbers, by the primvar's way of mixing. Directions are not yet of unit length.
pub(super) fn interpolate<'a, T: Real + 'a>(
    count: usize,
    primvar: &Primvar,
    rows_of: impl Fn(usize) -> WeightedRows<'a, T> + Sync,
) -> Vec<T> {
    let width = primvar.width().max(1);
    let mut rows = vec![T::from_f64(0.0); count * width];
    rows.par_chunks_mut(CHUNK * width).enumerate().for_each(|(chunk, rows)| {
        for (i, row) in rows.chunks_mut(width).enumerate() {
            blend_into(&rows_of(CHUNK * chunk + i).iter().copied(), primvar, row);
        }
    });
    rows
}

/// The rows of a triangle's corners, weighted as at a location.
pub(super) fn weighted<'a, T>(at: &BaselinePoint, row: impl Fn(usize) -> &'a [T]) -> WeightedRows<'a, T> {
    [0, 1, 2].map(|k| (row(k), at.weights[k]))
}
