//! How a body moves and stretches around each point that is bound to it.
//!
//! A body may grow around a limb and not along it. The stretch is that of the affine map that takes the body around a place best to
//! its other shape, less its rotation. What hangs follows more of the body the farther away it is: a hem between two legs would
//! otherwise be torn by both.

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
/// How much farther the body counts around what hangs, by the square of how far it does: for a hem at the knee, the whole body
/// below the chest, and for a wide sleeve, the arm.
const REACH_BEYOND: f64 = 12.0;
/// Steps of that reach in each doubling.
const REACH_STEPS: f64 = 4.0;
/// Share of a similarity in the map, for directions in which the body says little.
const SIMILARITY: f64 = 0.02;
/// Vertices around a place, the nearest ones: as many as the work allows, and no more and no less than these.
const AROUND: [usize; 2] = [256, 4096];
/// Work for each of them, with which they all take half of it.
const WORK_AROUND: usize = 16;

/// A vertex, with its distance or weight.
type Near = (usize, f64);

/// Body vertices around places, with their weights.
pub struct Surroundings {
    of: Vec<Vec<Near>>,
    /// The surroundings of each place.
    places: Vec<usize>,
}

/// The affine map around a place.
#[derive(Clone, Copy)]
pub struct Frame {
    /// The middle of the surroundings in both shapes.
    middles: [DVec3; 2],
    map: DMat3,
    /// The map without its rotation.
    pub stretch: DMat3,
}

impl Frame {
    /// Where the map takes a point.
    pub fn carried(&self, point: DVec3) -> DVec3 {
        self.middles[1] + self.map * (point - self.middles[0])
    }
}

impl Surroundings {
    /// The surroundings of vertices of a body, along its edges: an arm beside a hip does not count for it. Each has how
    /// far its point hangs, 0 beside the body. Incomplete beyond the bound of `work`.
    pub fn new(bodies: &Bodies, places: &[(usize, f64)], work: &WorkLimit) -> Self {
        let (points, mut neighbours) = (&bodies.from, vec![Vec::new(); bodies.from.len()]);
        for &[a, b] in &bodies.edges {
            let length = points[a].distance(points[b]);
            neighbours[a].push((b, length));
            neighbours[b].push((a, length));
        }
        let least = REACH * bodies.size();
        let area = |own: &Vec<Near>| own.iter().map(|n| n.1 * n.1).sum::<f64>() / own.len().max(1) as f64;
        let areas: Vec<f64> = neighbours.iter().map(area).collect();
        let step = |beyond: f64| (REACH_STEPS * (1.0 + REACH_BEYOND * beyond * beyond).log2()).round().clamp(0.0, 99.0);
        let places: Vec<(usize, u32)> = places.iter().map(|&(v, beyond)| (v, step(beyond) as u32)).collect();
        let vertices = each_once(places.clone());
        let places = places.iter().map(|place| vertices.partition_point(|v| v < place)).collect();
        let most = (work.left() / (WORK_AROUND * vertices.len()).max(1)).clamp(AROUND[0], AROUND[1]);
        // A vertex counts for the area around it, less where it is farther away.
        let around = |&(place, step): &(usize, u32)| {
            // On a coarse body the neighbours count at least.
            let longest = neighbours[place].iter().map(|n| n.1).fold(0.0, f64::max);
            let reach = least.max(2.0 * longest) * (f64::from(step) / REACH_STEPS).exp2();
            let weigh = |(v, distance): Near| (v, areas[v] * (1.0 - (distance / reach).powi(2)));
            within(&neighbours, place, (reach, most), work).into_iter().map(weigh).collect()
        };
        Self { of: vertices.par_iter().map(around).collect(), places }
    }

    /// The map around each place from one shape to another.
    pub fn frames(&self, from: &[DVec3], to: &[DVec3]) -> Vec<Frame> {
        let of: Vec<Frame> = self.of.par_iter().map(|around| frame(around, from, to)).collect();
        self.places.iter().map(|&place| of[place]).collect()
    }
}

/// The vertices within a reach of one along edges, with their distances (Dijkstra 1959).
fn within(neighbours: &[Vec<Near>], place: usize, (reach, most): (f64, usize), work: &WorkLimit) -> Vec<Near> {
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
        if found.len() == most || !work.take(neighbours[v].len()) {
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

/// The affine map of weighted points.
fn frame(around: &[Near], from: &[DVec3], to: &[DVec3]) -> Frame {
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
        return Frame { middles: [a, b], map: DMat3::IDENTITY, stretch: DMat3::IDENTITY };
    }
    let turn = DMat3::from_quat(rotation(&cross, DQuat::IDENTITY));
    let (share, scale) = (SIMILARITY * spread, (size / spread).sqrt());
    let map = (cross + turn * (share * scale)) * (own + DMat3::from_diagonal(DVec3::splat(share))).inverse();
    let turn = DMat3::from_quat(rotation(&map, DQuat::IDENTITY));
    let stretch = turn.transpose() * map;
    Frame { middles: [a, b], map, stretch: (stretch + stretch.transpose()) * 0.5 }
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
        let of = Surroundings::new(&bodies, &[(246, 0.0)], &WorkLimit::default());
        let Frame { stretch, .. } = of.frames(&bodies.from, &bodies.to)[0];
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
        let of = Surroundings::new(&bodies, &[(246, 0.0)], &WorkLimit::default());
        let Frame { stretch, .. } = of.frames(&bodies.from, &bodies.to)[0];
        assert!((stretch - DMat3::IDENTITY).x_axis.length() < 1e-6, "{stretch}");
    }
}
