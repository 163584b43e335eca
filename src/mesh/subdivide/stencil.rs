//! Sparse linear maps from the values of one mesh to those of a finer mesh.

use crate::connectivity::Id;
use rayon::prelude::*;

/// Rows that one task applies: few enough to balance the load, enough to outweigh the cost of a task.
const ROWS_PER_TASK: usize = 4096;
/// Rows of a table that one task builds; building costs more than applying.
const ROWS_PER_BLOCK: usize = 256;

/// One row for each child value: the parent values and weights whose sum it is.
///
/// Implementations may compute rows on demand. For regular meshes this costs less than reading a table.
pub trait Stencils: Sync {
    /// The handle of a parent value.
    type Source: Id;

    /// Number of child values.
    fn rows(&self) -> usize;

    /// Passes the sources and weights of a row to `sink`; a source may repeat.
    fn row(&self, row: usize, sink: &mut impl FnMut(Self::Source, f32));

    /// The child values, `N` numbers each, summed in single precision.
    fn apply<const N: usize>(&self, parents: &[[f32; N]]) -> Vec<[f32; N]> {
        let mut children = vec![[0.0f32; N]; self.rows()];
        children.par_chunks_mut(ROWS_PER_TASK).enumerate().for_each(|(task, children)| {
            for (i, child) in children.iter_mut().enumerate() {
                let mut sum = [0.0f32; N];
                self.row(task * ROWS_PER_TASK + i, &mut |source, weight| {
                    let parent = &parents[source.index()];
                    (0..N).for_each(|k| sum[k] += weight * parent[k]);
                });
                *child = sum;
            }
        });
        children
    }

    /// The child values, `width` numbers each, summed in double precision. `parents` holds `width` numbers for each
    /// source.
    fn apply_rows<T: Real>(&self, parents: &[T], width: usize) -> Vec<T> {
        match width {
            0 => Vec::new(),
            1 => self.apply_tuples::<T, 1>(parents),
            2 => self.apply_tuples::<T, 2>(parents),
            3 => self.apply_tuples::<T, 3>(parents),
            4 => self.apply_tuples::<T, 4>(parents),
            _ => self.apply_wide(parents, width),
        }
    }

    /// [`Stencils::apply_rows`] for a constant width, with sums in registers.
    fn apply_tuples<T: Real, const N: usize>(&self, parents: &[T]) -> Vec<T> {
        let (parents, _) = parents.as_chunks::<N>();
        let mut children = vec![T::from_f64(0.0); self.rows() * N];
        children.par_chunks_mut(ROWS_PER_TASK * N).enumerate().for_each(|(task, children)| {
            for (i, child) in children.as_chunks_mut::<N>().0.iter_mut().enumerate() {
                let mut sum = [0.0f64; N];
                self.row(task * ROWS_PER_TASK + i, &mut |source, weight| {
                    let (parent, weight) = (&parents[source.index()], f64::from(weight));
                    (0..N).for_each(|k| sum[k] += weight * parent[k].to_f64());
                });
                *child = sum.map(T::from_f64);
            }
        });
        children
    }

    /// [`Stencils::apply_rows`] for any width.
    fn apply_wide<T: Real>(&self, parents: &[T], width: usize) -> Vec<T> {
        let mut children = vec![T::from_f64(0.0); self.rows() * width];
        children.par_chunks_mut(ROWS_PER_TASK * width).enumerate().for_each(|(task, children)| {
            let mut sum = vec![0.0f64; width];
            for (i, child) in children.chunks_exact_mut(width).enumerate() {
                sum.fill(0.0);
                self.row(task * ROWS_PER_TASK + i, &mut |source, weight| {
                    let parent = &parents[source.index() * width..(source.index() + 1) * width];
                    sum.iter_mut().zip(parent).for_each(|(sum, p)| *sum += f64::from(weight) * p.to_f64());
                });
                child.iter_mut().zip(&sum).for_each(|(c, &s)| *c = T::from_f64(s));
            }
        });
        children
    }

    /// The distinct sources of a row with their total weights, in order of first appearance.
    fn merged(&self, row: usize) -> Vec<(Self::Source, f32)> {
        let mut merged: Vec<(Self::Source, f32)> = Vec::with_capacity(16);
        self.row(row, &mut |source, weight| match merged.iter_mut().find(|(s, _)| *s == source) {
            Some((_, sum)) => *sum += weight,
            None => merged.push((source, weight)),
        });
        merged
    }

    /// The source with the largest total weight in a row, the lowest of equals; `None` for an empty row.
    fn heaviest(&self, row: usize) -> Option<Self::Source> {
        let heavier = |a: &(Self::Source, f32), b: &(Self::Source, f32)| b.1 > a.1 || b.1 == a.1 && b.0 < a.0;
        self.merged(row).into_iter().reduce(|a, b| if heavier(&a, &b) { b } else { a }).map(|(s, _)| s)
    }
}

/// Stored stencil rows.
#[derive(Clone, Debug)]
pub struct Table<I> {
    offsets: Vec<u32>,
    entries: Vec<(I, f32)>,
}

/// An empty table.
impl<I> Default for Table<I> {
    fn default() -> Self {
        Self { offsets: vec![0], entries: Vec::new() }
    }
}

impl<I: Copy> Table<I> {
    /// Adds a row.
    pub fn push(&mut self, row: impl IntoIterator<Item = (I, f32)>) {
        self.entries.extend(row);
        self.offsets.push(self.entries.len() as u32);
    }

    /// An empty table with capacity for `rows` rows of `sources` sources in total.
    pub fn with_capacity(rows: usize, sources: usize) -> Self {
        let mut offsets = Vec::with_capacity(rows + 1);
        offsets.push(0);
        Self { offsets, entries: Vec::with_capacity(sources) }
    }

    /// Adds a source to the row that the next [`Table::push`] completes.
    pub fn extend_row(&mut self, source: I, weight: f32) {
        self.entries.push((source, weight));
    }

    /// Adds to the weight of a source in the last row and returns the index of its entry. `entry` is a guess of that
    /// index; a wrong guess appends a new entry.
    pub fn add(&mut self, source: I, weight: f32, entry: u32) -> u32
    where
        I: PartialEq,
    {
        let start = self.offsets.len().checked_sub(2).map_or(0, |last| self.offsets[last]);
        match self.entries.get_mut(entry as usize) {
            Some((known, sum)) if entry >= start && *known == source => {
                *sum += weight;
                entry
            }
            _ => {
                self.entries.push((source, weight));
                let end = self.entries.len() as u32;
                if let Some(last) = self.offsets.last_mut() {
                    *last = end;
                }
                end - 1
            }
        }
    }

    /// Builds a table in parallel: `add` appends the rows of one item.
    ///
    /// Tasks reuse a `scratch` value. Its state must not affect the rows, since the split into tasks varies.
    pub fn of<T: Send, S>(
        items: impl IndexedParallelIterator<Item = T>,
        scratch: impl Fn() -> S + Sync + Send,
        add: impl Fn(&mut Self, &mut S, T) + Sync + Send,
    ) -> Self
    where
        I: Send,
    {
        let of_block = |scratch: &mut S, block: Vec<T>| {
            let mut table = Self::default();
            block.into_iter().for_each(|item| add(&mut table, scratch, item));
            table
        };
        Self::joined(&items.chunks(ROWS_PER_BLOCK).map_init(scratch, of_block).collect::<Vec<_>>())
    }

    /// The rows of all `tables`, in order.
    pub fn joined(tables: &[Self]) -> Self {
        let mut joined = Self::default();
        joined.entries.reserve(tables.iter().map(|table| table.entries.len()).sum());
        joined.offsets.reserve(tables.iter().map(Self::len).sum());
        for table in tables {
            let start = joined.entries.len() as u32;
            joined.entries.extend_from_slice(&table.entries);
            joined.offsets.extend(table.offsets[1..].iter().map(|offset| start + offset));
        }
        joined
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.offsets.len() - 1
    }

    /// `true` if there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The sources and weights of a row.
    #[inline]
    pub fn at(&self, row: usize) -> &[(I, f32)] {
        &self.entries[self.offsets[row] as usize..self.offsets[row + 1] as usize]
    }
}

impl<I: Id> Stencils for &Table<I> {
    type Source = I;

    fn rows(&self) -> usize {
        self.len()
    }

    fn row(&self, row: usize, sink: &mut impl FnMut(I, f32)) {
        self.at(row).iter().for_each(|&(source, weight)| sink(source, weight));
    }
}

/// A floating-point number of either precision.
pub trait Real: Copy + Send + Sync {
    /// Converts to double precision.
    fn to_f64(self) -> f64;
    /// Converts from double precision.
    fn from_f64(value: f64) -> Self;
}

impl Real for f32 {
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    fn from_f64(value: f64) -> Self {
        value as f32
    }
}

impl Real for f64 {
    fn to_f64(self) -> f64 {
        self
    }
    fn from_f64(value: f64) -> Self {
        value
    }
}
