//! Rows of a primvar, mixed at many places.

use crate::garment::Primvar;
use crate::sim::Location;
use crate::subdivide::{Real, mix_into};
use rayon::prelude::*;

/// Places that are mixed in one go.
const CHUNK: usize = 1024;

/// The rows at a triangle's corners, with their weights.
pub(super) type Parts<'a, T> = [(&'a [T], f32); 3];

/// One row for each of `count` places, by the primvar's way of mixing; directions are not yet of unit length.
pub(super) fn at_places<'a, T: Real + 'a>(
    count: usize,
    primvar: &Primvar,
    parts: impl Fn(usize) -> Parts<'a, T> + Sync,
) -> Vec<T> {
    let width = primvar.width().max(1);
    let mut rows = vec![T::from_f64(0.0); count * width];
    rows.par_chunks_mut(CHUNK * width).enumerate().for_each(|(chunk, rows)| {
        for (i, row) in rows.chunks_mut(width).enumerate() {
            mix_into(&parts(CHUNK * chunk + i).iter().copied(), primvar, row);
        }
    });
    rows
}

/// The three rows of a triangle at a location.
pub(super) fn parts<'a, T>(at: &Location, row: impl Fn(usize) -> &'a [T]) -> Parts<'a, T> {
    [0, 1, 2].map(|k| (row(k), at.weights[k]))
}
