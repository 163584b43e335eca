//! A spline that takes places to others.

use glam::DVec3;

/// Pairs of points of which a spline is made at most: its system is dense.
pub const MOST_PAIRS: usize = 1000;

/// A thin-plate spline in space: an affine map and a sum of distances to its centres (Duchon 1977, *Splines minimizing
/// rotation-invariant semi-norms in Sobolev spaces*).
pub struct ThinPlate {
    centres: Vec<DVec3>,
    weights: Vec<DVec3>,
    /// Of a constant and of the coordinates.
    affine: [DVec3; 4],
}

impl ThinPlate {
    /// The spline that takes the first place of each pair to the second one; or what is wrong with the pairs.
    pub fn new(pairs: &[[DVec3; 2]]) -> Result<Self, String> {
        let count = pairs.len();
        if !(4..=MOST_PAIRS).contains(&count) {
            return Err(format!("there are {count} pairs of points"));
        }
        let size = pairs.iter().map(|pair| pair[0].distance(pairs[0][0])).fold(0.0, f64::max);
        let linear = |p: DVec3| [size, p.x, p.y, p.z];
        let row = |i: usize| {
            let mut row = vec![0.0; count + 4];
            if i < count {
                (0..count).for_each(|j| row[j] = pairs[i][0].distance(pairs[j][0]));
                row[count..].copy_from_slice(&linear(pairs[i][0]));
            } else {
                (0..count).for_each(|j| row[j] = linear(pairs[j][0])[i - count]);
            }
            row
        };
        let right = pairs.iter().map(|pair| pair[1]).chain([DVec3::ZERO; 4]).collect();
        let solved = eliminated((0..count + 4).map(row).collect(), right, 1e-9 * size);
        let solved = solved.ok_or("the pairs of points are in one plane, or one is there twice")?;
        let affine = [solved[count] * size, solved[count + 1], solved[count + 2], solved[count + 3]];
        Ok(Self { centres: pairs.iter().map(|pair| pair[0]).collect(), weights: solved[..count].to_vec(), affine })
    }

    pub fn at(&self, p: DVec3) -> DVec3 {
        let [origin, x, y, z] = self.affine;
        let bent = self.centres.iter().zip(&self.weights).map(|(centre, weight)| *weight * centre.distance(p));
        origin + x * p.x + y * p.y + z * p.z + bent.sum::<DVec3>()
    }
}

/// The solution of a linear system by elimination with row pivots; none where a pivot is not larger than `least`.
fn eliminated(mut rows: Vec<Vec<f64>>, mut right: Vec<DVec3>, least: f64) -> Option<Vec<DVec3>> {
    let count = rows.len();
    for k in 0..count {
        let pivot = (k..count).max_by(|&a, &b| rows[a][k].abs().total_cmp(&rows[b][k].abs()))?;
        rows.swap(k, pivot);
        right.swap(k, pivot);
        if rows[k][k].is_nan() || rows[k][k].abs() <= least {
            return None;
        }
        let (above, below) = rows.split_at_mut(k + 1);
        let (own, value) = (&above[k], right[k]);
        for (row, right) in below.iter_mut().zip(&mut right[k + 1..]) {
            let share = row[k] / own[k];
            row[k..].iter_mut().zip(&own[k..]).for_each(|(entry, own)| *entry -= share * own);
            *right -= share * value;
        }
    }
    for k in (0..count).rev() {
        let known: DVec3 = (k + 1..count).map(|j| rows[k][j] * right[j]).sum();
        right[k] = (right[k] - known) / rows[k][k];
    }
    Some(right)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spline_meets_its_pairs_and_keeps_affine_maps() {
        let place = |i: usize| DVec3::new((i * 7 % 5) as f64, (i * 3 % 7) as f64, (i * 5 % 3) as f64);
        let moved = |p: DVec3| DVec3::new(2.0 * p.x + 1.0, p.z - p.y, 0.5 * p.y);
        let mut pairs: Vec<[DVec3; 2]> = (0..20).map(|i| [place(i), moved(place(i))]).collect();
        let spline = ThinPlate::new(&pairs).expect("places that are not in a plane");
        let elsewhere = DVec3::new(3.3, -8.0, 1.2);
        assert!(spline.at(elsewhere).distance(moved(elsewhere)) < 1e-9);
        pairs[4][1] += DVec3::new(0.3, -0.2, 1.0);
        let spline = ThinPlate::new(&pairs).expect("places that are not in a plane");
        assert!(pairs.iter().all(|[from, to]| spline.at(*from).distance(*to) < 1e-9));
    }

    #[test]
    fn pairs_that_say_too_little_are_refused() {
        let flat: Vec<[DVec3; 2]> = (0..9).map(|i| [DVec3::new((i % 3) as f64, (i / 3) as f64, 2.0); 2]).collect();
        assert!(ThinPlate::new(&flat).is_err() && ThinPlate::new(&flat[..3]).is_err());
    }
}
