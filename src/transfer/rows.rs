//! Rows of a primvar, mixed at many places.

use crate::garment::{Mixing, Primvar};
use crate::sim::Location;
use crate::subdivide::{Real, mix};
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
            mix_into(parts(CHUNK * chunk + i).into_iter(), primvar, row);
        }
    });
    rows
}

/// The mean of rows, as [`mix`] makes it, without memory of its own.
pub(super) fn mix_into<'a, T: Real + 'a>(
    parts: impl Iterator<Item = (&'a [T], f32)> + Clone,
    primvar: &Primvar,
    row: &mut [T],
) {
    if primvar.mixing == Mixing::Rotation {
        row.copy_from_slice(&mix(parts, primvar));
        return;
    }
    for (k, value) in row.iter_mut().enumerate() {
        let sum = parts.clone().fold(0.0, |sum, (part, weight)| sum + f64::from(weight) * part[k].to_f64());
        *value = T::from_f64(sum);
    }
}

/// The three rows of a triangle at a location.
pub(super) fn parts<'a, T>(at: &Location, row: impl Fn(usize) -> &'a [T]) -> Parts<'a, T> {
    [0, 1, 2].map(|k| (row(k), at.weights[k]))
}
