//! How a body stretches around each point that is bound to it.
//!
//! A body may grow around a limb and not along it. The stretch is that of the affine map that takes the body around a place best to
//! its other shape, less its rotation.

use super::bodies::Bodies;
use super::rigid::{outer, rotation};
use glam::{DMat3, DQuat, DVec3};
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use tailor::contact::{WorkLimit, each_once};
use tailor_mesh::meter;

/// How far around a place the body counts, as a share of the diagonal of its box: about all around an arm.
const REACH: f64 = 0.05;
/// Share of a similarity in the map, for directions in which the body says little.
const SIMILARITY: f64 = 0.02;
/// Vertices around a place at most, the nearest ones.
const MOST_AROUND: usize = 4096;

/// Body vertices around places, with their weights.
pub struct Surroundings {
    of: Vec<Vec<(usize, f64)>>,
    /// The surroundings of each place.
    places: Vec<usize>,
}

impl Surroundings {
    /// The surroundings of vertices of a body, along its edges: an arm beside a hip does not count for it. Incomplete
    /// beyond the bound of `work`.
    pub fn new(bodies: &Bodies, places: &[usize], work: &WorkLimit) -> Self {
        let (points, mut neighbours) = (&bodies.from, vec![Vec::new(); bodies.from.len()]);
        for &[a, b] in &bodies.edges {
            let length = points[a].distance(points[b]);
            neighbours[a].push((b, length));
            neighbours[b].push((a, length));
        }
        let least = REACH * bodies.size();
        let area = |own: &Vec<(usize, f64)>| own.iter().map(|n| n.1 * n.1).sum::<f64>() / own.len().max(1) as f64;
        let areas: Vec<f64> = neighbours.iter().map(area).collect();
        // A vertex counts for the area around it, less where it is farther away.
        let around = |&place: &usize| {
            // On a coarse body the neighbours count at least.
            let longest = neighbours[place].iter().map(|n| n.1).fold(0.0, f64::max);
            let reach = least.max(2.0 * longest);
            let weigh = |(v, distance): (usize, f64)| (v, areas[v] * (1.0 - (distance / reach).powi(2)));
            within(&neighbours, place, reach, work).into_iter().map(weigh).collect()
        };
        let vertices = each_once(places.to_vec());
        let places = places.iter().map(|place| vertices.partition_point(|v| v < place)).collect();
        Self { of: vertices.par_iter().map(around).collect(), places }
    }

    /// The stretch around each place from one shape to another, in the space of the first.
    pub fn stretches(&self, from: &[DVec3], to: &[DVec3]) -> Vec<DMat3> {
        let of: Vec<DMat3> = self.of.par_iter().map(|around| stretch(around, from, to)).collect();
        self.places.iter().map(|&place| of[place]).collect()
    }
}

/// The vertices within a reach of one along edges, with their distances (Dijkstra 1959).
fn within(neighbours: &[Vec<(usize, f64)>], place: usize, reach: f64, work: &WorkLimit) -> Vec<(usize, f64)> {
    meter::check();
    let (mut found, mut best) = (Vec::new(), BTreeMap::from([(place, 0.0)]));
    // The bits of distances, which are not negative, sort as the distances do.
    let mut queue = BinaryHeap::from([Reverse((0u64, place))]);
    while let Some(Reverse((bits, v))) = queue.pop() {
        let distance = f64::from_bits(bits);
        if distance > best[&v] {
            continue;
        }
        found.push((v, distance));
        if found.len() == MOST_AROUND || !work.take(neighbours[v].len()) {
            break;
        }
        for &(w, length) in &neighbours[v] {
            let further = distance + length;
            if further < reach && best.get(&w).is_none_or(|&least| further < least) {
                best.insert(w, further);
                queue.push(Reverse((further.to_bits(), w)));
            }
        }
    }
    found
}

/// The stretch of the affine map of weighted points.
fn stretch(around: &[(usize, f64)], from: &[DVec3], to: &[DVec3]) -> DMat3 {
    let total: f64 = around.iter().map(|a| a.1).sum();
    let mean = |points: &[DVec3]| around.iter().map(|&(v, w)| w * points[v]).sum::<DVec3>() / total;
    let [a, b] = [mean(from), mean(to)];
    let (mut own, mut cross, mut size) = (DMat3::ZERO, DMat3::ZERO, 0.0);
    for &(v, w) in around {
        let (p, q) = (from[v] - a, to[v] - b);
        own += outer(p, p) * w;
        cross += outer(q, p) * w;
        size += w * q.length_squared();
    }
    let spread = own.x_axis.x + own.y_axis.y + own.z_axis.z;
    if spread.is_nan() || spread <= 0.0 {
        return DMat3::IDENTITY;
    }
    let turn = DMat3::from_quat(rotation(&cross, DQuat::IDENTITY));
    let (share, scale) = (SIMILARITY * spread, (size / spread).sqrt());
    let map = (cross + turn * (share * scale)) * (own + DMat3::from_diagonal(DVec3::splat(share))).inverse();
    let turn = DMat3::from_quat(rotation(&map, DQuat::IDENTITY));
    let stretch = turn.transpose() * map;
    (stretch + stretch.transpose()) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tube of vertices about the y axis, with its edges.
    fn tube(radius: f64, height: f64) -> (Vec<DVec3>, Vec<[usize; 2]>) {
        let at = |i: usize| {
            let (sin, cos) = (std::f64::consts::TAU * (i % 12) as f64 / 12.0).sin_cos();
            DVec3::new(radius * sin, height * (i / 12) as f64 / 40.0, radius * cos)
        };
        let around = (0..480).map(|i| [i, 12 * (i / 12) + (i + 1) % 12]);
        ((0..480).map(at).collect(), around.chain((0..468).map(|i| [i, i + 12])).collect())
    }

    /// Bodies of edges, with triangles as far as their size needs some.
    fn bodies(edges: Vec<[usize; 2]>, from: Vec<DVec3>, to: Vec<DVec3>) -> Bodies {
        let triangles = (2..480).map(|i| [i - 2, i - 1, i]).collect();
        Bodies { triangles, edges, from, to, ..Bodies::default() }
    }

    #[test]
    fn a_limb_that_grows_around_and_not_along_stretches_so() {
        let ((from, edges), (to, _)) = (tube(0.5, 20.0), tube(0.8, 20.0));
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 1.0, 0.0).normalize(), 1.0);
        let to: Vec<DVec3> = to.into_iter().map(|p| turn * p + DVec3::X).collect();
        let bodies = bodies(edges, from, to);
        let [stretch] =
            Surroundings::new(&bodies, &[246], &WorkLimit::default()).stretches(&bodies.from, &bodies.to)[..]
        else {
            panic!("one place has one stretch")
        };
        for (direction, wanted) in [(DVec3::X, 1.6), (DVec3::Y, 1.0), (DVec3::Z, 1.6)] {
            let own = (stretch * direction).length();
            assert!((own - wanted).abs() < 0.06, "{own}, not {wanted} along {direction}");
        }
    }

    #[test]
    fn a_part_that_no_edge_joins_does_not_count() {
        let (mut from, mut edges) = tube(0.5, 20.0);
        let (others, of_others) = tube(0.5, 20.0);
        let mut to = from.clone();
        edges.extend(of_others.into_iter().map(|edge| edge.map(|v| v + 480)));
        to.extend(others.iter().map(|p| *p * 3.0));
        from.extend(others.into_iter().map(|p| p + 0.6 * DVec3::X));
        let bodies = bodies(edges, from, to);
        let stretch = Surroundings::new(&bodies, &[246], &WorkLimit::default()).stretches(&bodies.from, &bodies.to)[0];
        assert!((stretch - DMat3::IDENTITY).x_axis.length() < 1e-6, "{stretch}");
    }
}
