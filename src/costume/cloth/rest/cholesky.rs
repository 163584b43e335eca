//! Sparse Cholesky factors of a net of springs in the plane.
//!
//! Nested dissection (George 1973, *Nested Dissection of a Regular Finite Element Mesh*) orders the points, so that the factors of a
//! mesh of n points have O(n log n) entries. The factorization is the up-looking one of Davis 2006, *Direct Methods for Sparse
//! Linear Systems*, section 4.7.

use glam::DVec2;

/// Points of a part that is not cut further. Larger parts fill the factors: by a tenth at 32.
const SMALLEST_PART: usize = 4;
/// In place of a point: the root of the elimination tree, or no row yet.
const NONE: usize = usize::MAX;

/// A spring: its two ends and its weight, which is positive.
pub type Spring = (usize, usize, f64);

/// The factor L of the matrix L Lᵀ, by columns; the first entry of each is its diagonal.
pub struct Cholesky {
    /// The point of each row.
    order: Vec<usize>,
    /// First entry of each column, and the end of the last.
    starts: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<f64>,
}

impl Cholesky {
    /// Factors the weighted Laplacian of `springs`, with point 0 held by a weight of 1. `points` are their places, near which
    /// points that share a spring lie. None if a group of points hangs on nothing, or a weight is not finite.
    pub fn new(points: &[DVec2], springs: &[Spring]) -> Option<Self> {
        let order = nested_dissection(points, springs);
        let matrix = Matrix::new(&order, springs);
        let parents = matrix.elimination_tree();
        let mut factor = Self { starts: matrix.column_starts(&parents), order, rows: Vec::new(), values: Vec::new() };
        let count = factor.starts[factor.order.len()];
        factor.rows.resize(count, 0);
        factor.values.resize(count, 0.0);
        factor.fill(&matrix, &parents).then_some(factor)
    }

    /// Computes the entries, a row at a time. False if the matrix is not positive definite.
    fn fill(&mut self, matrix: &Matrix, parents: &[usize]) -> bool {
        let count = self.order.len();
        let (mut ends, mut row) = (self.starts.clone(), vec![0.0; count]);
        let mut reach = Reach::new(count);
        for k in 0..count {
            let mut diagonal = matrix.diagonal[k];
            matrix.before[k].iter().for_each(|&(i, value)| row[i] += value);
            for &i in reach.of_row(k, matrix, parents) {
                let entry = row[i] / self.values[self.starts[i]];
                row[i] = 0.0;
                let column = self.starts[i] + 1..ends[i];
                for (&below, value) in self.rows[column.clone()].iter().zip(&self.values[column]) {
                    row[below] -= value * entry;
                }
                diagonal -= entry * entry;
                (self.rows[ends[i]], self.values[ends[i]]) = (k, entry);
                ends[i] += 1;
            }
            if !(diagonal > 0.0 && diagonal.is_finite()) {
                return false;
            }
            (self.rows[ends[k]], self.values[ends[k]]) = (k, diagonal.sqrt());
            ends[k] += 1;
        }
        true
    }

    /// The points whose springs pull by `right`. Columns with the same rows, as along a cut, are taken two at a time.
    pub fn solve(&self, right: &[DVec2]) -> Vec<DVec2> {
        let mut x: Vec<DVec2> = self.order.iter().map(|&i| right[i]).collect();
        let mut k = 0;
        while k < x.len() {
            k += if self.is_pair(k) { self.forward_pair(k, &mut x) } else { self.forward(k, &mut x) };
        }
        while k > 0 {
            k -= if k > 1 && self.is_pair(k - 2) { self.back_pair(k - 2, &mut x) } else { self.back(k - 1, &mut x) };
        }
        let mut solved = vec![DVec2::ZERO; x.len()];
        self.order.iter().zip(x).for_each(|(&i, x)| solved[i] = x);
        solved
    }

    /// Whether column `k` has an entry in the next row, and else the rows of the next column.
    fn is_pair(&self, k: usize) -> bool {
        let (own, next) = (self.starts[k], self.starts[k + 1]);
        next - own > 1 && self.rows[own + 1] == k + 1 && self.starts[k + 2] - next == next - own - 1
    }

    fn forward(&self, k: usize, x: &mut [DVec2]) -> usize {
        let (diagonal, below) = self.column(k);
        x[k] /= diagonal;
        let own = x[k];
        below.for_each(|(row, value)| x[row] -= value * own);
        1
    }

    fn forward_pair(&self, k: usize, x: &mut [DVec2]) -> usize {
        let ((diagonal, below), (next_diagonal, below_next)) = (self.column(k), self.column(k + 1));
        let own = x[k] / diagonal;
        let next = (x[k + 1] - self.values[self.starts[k] + 1] * own) / next_diagonal;
        (x[k], x[k + 1]) = (own, next);
        below.skip(1).zip(below_next).for_each(|((row, a), (_, b))| x[row] -= a * own + b * next);
        2
    }

    fn back(&self, k: usize, x: &mut [DVec2]) -> usize {
        let (diagonal, below) = self.column(k);
        x[k] = below.fold(x[k], |sum, (row, value)| sum - value * x[row]) / diagonal;
        1
    }

    fn back_pair(&self, k: usize, x: &mut [DVec2]) -> usize {
        let ((diagonal, below), (next_diagonal, below_next)) = (self.column(k), self.column(k + 1));
        let (own, next) = below
            .skip(1)
            .zip(below_next)
            .fold((x[k], x[k + 1]), |(own, next), ((row, a), (_, b))| (own - a * x[row], next - b * x[row]));
        x[k + 1] = next / next_diagonal;
        x[k] = (own - self.values[self.starts[k] + 1] * x[k + 1]) / diagonal;
        2
    }

    /// The diagonal of a column, and the entries below it with their rows.
    fn column(&self, k: usize) -> (f64, impl Iterator<Item = (usize, f64)>) {
        let below = self.starts[k] + 1..self.starts[k + 1];
        let entries = self.rows[below.clone()].iter().copied().zip(self.values[below].iter().copied());
        (self.values[self.starts[k]], entries)
    }
}

/// The matrix, with its rows in the order of elimination.
struct Matrix {
    diagonal: Vec<f64>,
    /// Entries of each row before the diagonal. One of two springs between the same points stands twice.
    before: Vec<Vec<(usize, f64)>>,
}

impl Matrix {
    fn new(order: &[usize], springs: &[Spring]) -> Self {
        let mut rows = vec![0; order.len()];
        order.iter().enumerate().for_each(|(row, &point)| rows[point] = row);
        let (mut diagonal, mut before) = (vec![0.0; order.len()], vec![Vec::new(); order.len()]);
        for &(a, b, weight) in springs {
            let (a, b) = (rows[a], rows[b]);
            diagonal[a] += weight;
            diagonal[b] += weight;
            before[a.max(b)].push((a.min(b), -weight));
        }
        rows.first().into_iter().for_each(|&row| diagonal[row] += 1.0);
        Self { diagonal, before }
    }

    /// The parent of each row: the first row below the diagonal of its column of L.
    fn elimination_tree(&self) -> Vec<usize> {
        let (mut parents, mut ancestors) = (vec![NONE; self.before.len()], vec![NONE; self.before.len()]);
        for (k, entries) in self.before.iter().enumerate() {
            for &(entry, _) in entries {
                let mut i = entry;
                while i != NONE && i < k {
                    let next = std::mem::replace(&mut ancestors[i], k);
                    if next == NONE {
                        parents[i] = k;
                    }
                    i = next;
                }
            }
        }
        parents
    }

    /// Where the columns of L start in a list of its entries.
    fn column_starts(&self, parents: &[usize]) -> Vec<usize> {
        let mut counts = vec![1; self.before.len()];
        let mut reach = Reach::new(self.before.len());
        for k in 0..self.before.len() {
            reach.of_row(k, self, parents).iter().for_each(|&i| counts[i] += 1);
        }
        let sums = counts.iter().scan(0, |sum, count| {
            *sum += count;
            Some(*sum)
        });
        std::iter::once(0).chain(sums).collect()
    }
}

/// Finds the columns of L with an entry in a row.
struct Reach {
    /// The row in which each column was met last.
    seen: Vec<usize>,
    columns: Vec<usize>,
    path: Vec<usize>,
}

impl Reach {
    fn new(count: usize) -> Self {
        Self { seen: vec![NONE; count], columns: Vec::new(), path: Vec::new() }
    }

    /// The columns, each before its parent: the paths in the elimination tree from the entries of row `k`.
    fn of_row(&mut self, k: usize, matrix: &Matrix, parents: &[usize]) -> &[usize] {
        self.columns.clear();
        self.seen[k] = k;
        for &(entry, _) in &matrix.before[k] {
            let mut i = entry;
            while self.seen[i] != k {
                self.seen[i] = k;
                self.path.push(i);
                i = parents[i];
            }
            // A path ends at columns that are known already, so that it goes before them.
            self.columns.extend(self.path.drain(..).rev());
        }
        self.columns.reverse();
        &self.columns
    }
}

/// The order of elimination: parts on both sides of a cut first, then the points along the cut.
fn nested_dissection(points: &[DVec2], springs: &[Spring]) -> Vec<usize> {
    let mut neighbors = vec![Vec::new(); points.len()];
    for &(a, b, _) in springs {
        neighbors[a].push(b);
        neighbors[b].push(a);
    }
    let mut order = Vec::with_capacity(points.len());
    let mut part_of = vec![0; points.len()];
    dissect((0..points.len()).collect(), points, &neighbors, &mut part_of, &mut order);
    order
}

/// Appends a part. `part_of` numbers the parts as the nodes of a binary heap: part n is cut into parts 2n + 1 and 2n + 2.
fn dissect(
    mut part: Vec<usize>,
    points: &[DVec2],
    neighbors: &[Vec<usize>],
    part_of: &mut [usize],
    order: &mut Vec<usize>,
) {
    if part.len() <= SMALLEST_PART {
        order.extend(part);
        return;
    }
    let least = part.iter().fold(DVec2::INFINITY, |least, &i| least.min(points[i]));
    let most = part.iter().fold(DVec2::NEG_INFINITY, |most, &i| most.max(points[i]));
    let axis = if (most - least).x >= (most - least).y { 0 } else { 1 };
    part.sort_by(|&a, &b| points[a][axis].total_cmp(&points[b][axis]).then(a.cmp(&b)));
    let far = part.split_off(part.len() / 2);
    let number = 1 + 2 * part_of[far[0]];
    part.iter().for_each(|&i| part_of[i] = number);
    far.iter().for_each(|&i| part_of[i] = number + 1);
    let (cut, near): (Vec<usize>, Vec<usize>) =
        part.into_iter().partition(|&i| neighbors[i].iter().any(|&j| part_of[j] == number + 1));
    dissect(near, points, neighbors, part_of, order);
    dissect(far, points, neighbors, part_of, order);
    order.extend(cut);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of springs with weights of many sizes.
    fn grid(n: usize) -> (Vec<DVec2>, Vec<Spring>) {
        let points = (0..n * n).map(|i| DVec2::new((i % n) as f64, (i / n) as f64)).collect();
        let weight = |i: usize| 0.1 + (i * 7919 % 101) as f64;
        let right = (0..n * n).filter(|i| i % n + 1 < n).map(|i| (i, i + 1, weight(i)));
        let up = (0..n * (n - 1)).map(|i| (i, i + n, weight(i + 3)));
        (points, right.chain(up).collect())
    }

    #[test]
    fn a_solution_balances_the_springs() {
        let (points, springs) = grid(23);
        let right: Vec<DVec2> = (0..points.len()).map(|i| DVec2::new((i % 5) as f64, -((i % 7) as f64))).collect();
        let x = Cholesky::new(&points, &springs).expect("a net in one piece").solve(&right);
        let mut rest = right;
        rest[0] -= x[0];
        for (a, b, weight) in springs {
            let pull = weight * (x[a] - x[b]);
            rest[a] -= pull;
            rest[b] += pull;
        }
        let most = rest.iter().map(|r| r.length()).fold(0.0, f64::max);
        assert!(most < 1e-9, "{most}");
    }

    #[test]
    fn factors_of_a_mesh_are_sparse() {
        let entries = |n: usize| {
            let (points, springs) = grid(n);
            Cholesky::new(&points, &springs).expect("a net in one piece").values.len() as f64
        };
        // O(n log n) for four times the points: 4 times, and a little; a band matrix has 8 times.
        let growth = entries(96) / entries(48);
        assert!(growth < 5.5, "{growth}");
    }

    #[test]
    fn loose_points_and_bad_weights_have_no_factor() {
        let points = [DVec2::ZERO, DVec2::X, DVec2::Y];
        assert!(Cholesky::new(&points, &[(0, 1, 1.0)]).is_none());
        assert!(Cholesky::new(&points, &[(0, 1, 1.0), (1, 2, f64::NAN)]).is_none());
        assert!(Cholesky::new(&points, &[(0, 1, 1.0), (1, 2, f64::INFINITY)]).is_none());
        assert!(Cholesky::new(&[], &[]).is_some());
    }
}
