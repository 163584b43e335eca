//! Panels with given triangles: as rigid as possible, with exact lengths along their seams.
//!
//! Local and global steps alternate (Liu, Zhang, Xu, Gotsman and Gortler 2008, *A Local/Global Approach to Mesh Parameterization*):
//! each triangle takes the rotation of its wanted shape that fits best, each seam edge its direction, then one linear system
//! gives the points. Its matrix is constant and factored once. Seam edges are constraints, by the alternating direction method of
//! multipliers (Boyd, Parikh, Chu, Peleato and Eckstein 2011). Each step goes beyond its solution by the Chebyshev weights of Wang
//! 2015, *A Chebyshev Semi-Iterative Approach for Accelerating Projective and Position-Based Dynamics*. A last pass moves the ends of
//! seam edges alone until their lengths are right (Müller, Heidelberger, Hennix and Ratcliff 2007, *Position Based Dynamics*).

use super::cholesky::Cholesky;
use glam::DVec2;
use std::cmp::Ordering;

/// Most local and global steps.
const STEPS: usize = 150;
/// Motion of every point in a step at which the steps end. \[mean edge lengths\]
const STILL: f64 = 1e-3;
/// The share of its distance from the solution that a step without acceleration leaves, of which the Chebyshev weights are made.
const SPECTRAL_RADIUS: f64 = 0.9;
/// Steps without acceleration, in which triangles find their rotations.
const PLAIN_STEPS: usize = 3;
/// Weight of a seam edge, where that of a triangle's edge is about 1.
const SEAM_WEIGHT: f64 = 20.0;
/// Least weight of a triangle's edge, which keeps the system positive.
const LEAST_WEIGHT: f64 = 0.05;
/// Passes over the seam edges at the end, at most.
const SEAM_PASSES: usize = 2000;
/// Difference of a seam edge from its length at which the passes end. \[share\]
const SEAM_TOLERANCE: f64 = 1e-4;

/// A panel to flatten.
pub struct Panel {
    /// Points to start from.
    pub points: Vec<DVec2>,
    /// The triangles, counter-clockwise.
    pub triangles: Vec<[usize; 3]>,
    /// Wanted edges of each triangle, from corner k to the next.
    pub edges: Vec<[DVec2; 3]>,
    /// Edges with an exact length.
    pub seams: Vec<Seam>,
}

/// An edge with an exact length.
pub struct Seam {
    pub ends: [usize; 2],
    pub length: f64,
}

/// The points of a flat panel, about where they start from.
pub fn flatten(panel: &Panel) -> Vec<DVec2> {
    let mut points = panel.points.clone();
    let weights: Vec<[f64; 3]> = panel.edges.iter().map(cotangents).collect();
    // A system that cannot be factored leaves the points as they are, which the figures then tell.
    if let Some(system) = system(panel, &weights) {
        let mut pulls = vec![DVec2::ZERO; panel.seams.len()];
        let edge =
            panel.edges.iter().flatten().map(|e| e.length()).sum::<f64>() / (3 * panel.edges.len()).max(1) as f64;
        let (mut before, mut beyond) = (points.clone(), 1.0);
        for step in 0..STEPS {
            let wanted = wanted_seams(panel, &points, &mut pulls);
            let right = right_side(panel, &weights, &points, &wanted);
            let solved = system.solve(&right);
            beyond = chebyshev_weight(step, beyond);
            let mut motion: f64 = 0.0;
            for ((point, solved), before) in points.iter_mut().zip(solved).zip(&mut before) {
                let next = *before + beyond * (solved - *before);
                motion = motion.max(next.distance_squared(*point));
                *before = std::mem::replace(point, next);
            }
            if motion.sqrt() <= STILL * edge {
                break;
            }
        }
    }
    fit_seams(panel, &mut points);
    points
}

/// How far a step goes towards its solution from where the step before it began.
fn chebyshev_weight(step: usize, last: f64) -> f64 {
    const SQUARED: f64 = SPECTRAL_RADIUS * SPECTRAL_RADIUS;
    match step.cmp(&PLAIN_STEPS) {
        Ordering::Less => 1.0,
        Ordering::Equal => 2.0 / (2.0 - SQUARED),
        Ordering::Greater => 4.0 / (4.0 - SQUARED * last),
    }
}

/// Half the cotangents of the angles opposite a triangle's edges.
fn cotangents(edges: &[DVec2; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| {
        let (a, b) = (edges[(k + 2) % 3], -edges[(k + 1) % 3]);
        let cotangent = 0.5 * a.dot(b) / a.perp_dot(b).abs().max(f64::MIN_POSITIVE);
        cotangent.clamp(LEAST_WEIGHT, 1.0 / LEAST_WEIGHT)
    })
}

fn system(panel: &Panel, weights: &[[f64; 3]]) -> Option<Cholesky> {
    let of_triangle = |(triangle, weights): (&[usize; 3], &[f64; 3])| {
        [0, 1, 2].map(|k| (triangle[k], triangle[(k + 1) % 3], weights[k]))
    };
    let sides = panel.triangles.iter().zip(weights).flat_map(of_triangle);
    let seams = panel.seams.iter().map(|seam| (seam.ends[0], seam.ends[1], SEAM_WEIGHT));
    // One point is held, since lengths say nothing of the place.
    Cholesky::new(&panel.points, &sides.chain(seams).collect::<Vec<_>>())
}

/// Vectors that the seam edges are drawn to. `pulls` sums what they still miss, so that in the end they miss nothing.
fn wanted_seams(panel: &Panel, points: &[DVec2], pulls: &mut [DVec2]) -> Vec<DVec2> {
    let wanted = |(seam, pull): (&Seam, &mut DVec2)| {
        let own = points[seam.ends[1]] - points[seam.ends[0]];
        let exact = (own + *pull).normalize_or_zero() * seam.length;
        *pull += own - exact;
        exact - *pull
    };
    panel.seams.iter().zip(pulls).map(wanted).collect()
}

fn right_side(panel: &Panel, weights: &[[f64; 3]], points: &[DVec2], wanted: &[DVec2]) -> Vec<DVec2> {
    let mut right = vec![DVec2::ZERO; points.len()];
    let mut spring = |i: usize, j: usize, edge: DVec2| {
        right[i] -= edge;
        right[j] += edge;
    };
    for ((triangle, edges), weights) in panel.triangles.iter().zip(&panel.edges).zip(weights) {
        let mut turn = DVec2::ZERO;
        for k in 0..3 {
            let own = points[triangle[(k + 1) % 3]] - points[triangle[k]];
            turn += weights[k] * DVec2::new(own.dot(edges[k]), edges[k].perp_dot(own));
        }
        let turn = turn.try_normalize().unwrap_or(DVec2::X);
        for k in 0..3 {
            spring(triangle[k], triangle[(k + 1) % 3], weights[k] * turn.rotate(edges[k]));
        }
    }
    for (seam, &edge) in panel.seams.iter().zip(wanted) {
        spring(seam.ends[0], seam.ends[1], SEAM_WEIGHT * edge);
    }
    right[0] += panel.points[0];
    right
}

/// Moves the ends of seam edges until their lengths are right.
fn fit_seams(panel: &Panel, points: &mut [DVec2]) {
    for _ in 0..SEAM_PASSES {
        let mut most: f64 = 0.0;
        for &Seam { ends: [i, j], length } in &panel.seams {
            let along = points[j] - points[i];
            let own = along.length();
            if own > 0.0 {
                most = most.max((own - length).abs() / length);
                let move_by = along * (0.5 * (length - own) / own);
                points[i] -= move_by;
                points[j] += move_by;
            }
        }
        if most <= SEAM_TOLERANCE {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panel_takes_the_lengths_that_are_asked() {
        // A square of two triangles, started from a sheared one.
        let points = [[0.0, 0.0], [1.2, 0.1], [1.5, 0.9], [0.3, 1.1]].map(DVec2::from).to_vec();
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(DVec2::from);
        let triangles = vec![[0, 1, 2], [0, 2, 3]];
        let edges = triangles.iter().map(|t: &[usize; 3]| [0, 1, 2].map(|k| square[t[(k + 1) % 3]] - square[t[k]]));
        let seams = vec![Seam { ends: [0, 1], length: 1.02 }];
        let flat = flatten(&Panel { points, edges: edges.collect(), triangles, seams });
        assert!((flat[0].distance(flat[1]) - 1.02).abs() < 1e-3);
        for [i, j] in [[1, 2], [2, 3], [3, 0]] {
            assert!((flat[i].distance(flat[j]) - 1.0).abs() < 0.03, "{flat:?}");
        }
        assert!((flat[1] - flat[0]).perp_dot(flat[2] - flat[0]) > 0.0);
    }
}
